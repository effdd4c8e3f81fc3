"""Plans integer tip Jacobians, and proves how exact they are.

Beside a frame S that lies within f of the exact one R (`ccgen.fixedpoint.pose_bounds`), a column
that is linear in the frame, with the exact local vector w and the truncated series' w', errs by

    S w' + E - R w = (S - R) w + S (w' - w) + E,      at most f |w| + (1 + f) |w' - w| + |E|

where |w| is at most 1 for a turn and 1/2 for a chord's velocity, both being means over rotations.
The lever of the tip errs no more than the tip's position. A cross product of a turn t within a of
its own and a lever l within p of its own errs by at most (1 + a) p + a |l|.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import count

from ccgen.errors import FormatError
from ccgen.fixedpoint.jacobian import JacobianBounds, JacobianModel
from ccgen.fixedpoint.pose import PoseBounds, PoseModel, PoseTask
from ccgen.fixedpoint.pose_bounds import FRAME_MARGIN, norm, raised, root
from ccgen.fixedpoint.pose_plan import CHORD_REACH, narrowed
from ccgen.kinematics.symbolic import (
    Degrees,
    column_function,
    columns_of_turn,
    stretch_function,
)
from ccgen.polynomial import Compiled, Input, Output, compile_function
from ccgen.polynomial.proof import prove

SHARE = 0.25
"""Of the poses' errors, what roundings of the Jacobian are aimed to add."""

_LAXEST = 20
"""Doublings of that, where no plan of 32 bits is as exact."""


@dataclass(frozen=True)
class _Parts:
    """Largest errors of one segment's columns, norms, and the longest that they may be."""

    turn: Fraction
    chord: Fraction
    turn_reach: Fraction
    chord_reach: Fraction


@lru_cache(maxsize=64)
def jacobian_model(poses: PoseModel) -> JacobianModel:
    """Plan the tip Jacobian beside poses, about as exact as they are.

    Raises:
        FormatError: no plan of 32 bits holds it.
    """
    task = poses.task
    aim = SHARE * max(poses.bounds.rotation, poses.bounds.position / task.length)
    degrees = _degrees(task, Fraction(aim))
    columns = _closest(lambda lax: _columns(poses, degrees, lax * aim))
    wide = _parts(task, columns, degrees, poses.wide_bounds, None)
    column = _closest(lambda lax: _column(poses, wide, lax * aim))
    stretch = None
    if task.elongation_bits is not None:
        stretch = _closest(lambda lax: _stretch(poses, column, lax * aim))
    narrow_angle = min(Fraction(task.angle), task.full_angle)
    narrow = _parts(task, columns, degrees, poses.bounds, narrow_angle)
    own = [column, stretch]
    return JacobianModel(
        poses,
        columns,
        column,
        stretch,
        _bounds(task, narrow, own, poses.bounds, Fraction(task.elongation)),
        _bounds(task, wide, own, poses.wide_bounds, task.full_elongation),
    )


def _closest(plan: Callable[[float], Compiled]) -> Compiled:
    """The plan of the least error that is one."""
    for lax in range(_LAXEST):
        with suppress(FormatError):
            return plan(2.0**lax)
    return plan(2.0**_LAXEST)


def _degrees(task: PoseTask, share: Fraction) -> Degrees:
    """Least degrees whose truncation of a column is no more than a share, and small throughout."""
    angle = min(Fraction(task.angle), task.full_angle)
    for degree in count():
        for degrees in (Degrees(degree, max(degree - 1, 0)), Degrees(degree, degree)):
            near = max(_truncations(angle, degrees))
            if near <= share and max(_truncations(task.full_angle, degrees)) <= FRAME_MARGIN:
                return degrees
    raise AssertionError("the series converges faster")


def _truncations(angle: Fraction, degrees: Degrees) -> tuple[Fraction, Fraction]:
    """What a turn and a chord's velocity lack without the series' other terms; norms."""
    square = 2 * angle**2
    phi = root(square)
    c = square ** (degrees.c + 1) / math.factorial(2 * degrees.c + 5)
    d = square ** (degrees.d + 1) / math.factorial(2 * degrees.d + 6)
    b = square * d
    k = (2 * d + c) * phi + c + b
    return raised(angle * (c * phi + b)), raised(angle * k + b)


def _columns(poses: PoseModel, degrees: Degrees, error: float) -> Compiled:
    """One segment's columns; every vector may err by so much."""
    inputs = {
        one.name: Input(_range(poses, one.name), one.fraction_bits, one.bits, one.held)
        for one in poses.turn.plan.inputs
    }
    each = error / math.sqrt(3)
    bits = poses.frame_bits
    outputs = {
        "turn_u": Output(each, bits), "turn_v": Output(each, bits),
        "chord_u": Output(each, bits), "chord_v": Output(each, bits),
    }  # fmt: skip
    return compile_function(columns_of_turn(degrees), inputs, outputs)


def _range(poses: PoseModel, name: str) -> tuple[float, float]:
    own = next(one for one in poses.turn.plan.inputs if one.name == name)
    return math.ldexp(own.low, -own.fraction_bits), math.ldexp(own.high, -own.fraction_bits)


def _column(poses: PoseModel, parts: _Parts, error: float) -> Compiled:
    """The linear part of a column."""
    task, bits = poses.task, poses.frame_bits
    lever = [poses.place.proof.integers[step] for _, step in poses.place.plan.outputs]
    unit = 2.0**-poses.position_bits
    ends = [(low * unit, high * unit) for low, high in lever]
    inputs = {
        "turn": Input(_within(parts.turn_reach), bits, 32, held=True),
        "chord": Input(_within(parts.chord_reach), bits, 32, held=True),
        "lever": Input(ends, poses.position_bits, 32, held=True),
    }
    if task.elongation_bits is not None:
        end = task.largest * 2.0**-task.elongation_bits
        inputs["h"] = Input((-end, end), task.elongation_bits, task.precision)
    function = column_function(task.segment_length, task.elongation_bits is not None)
    return compile_function(function, inputs, {"linear": Output(error * task.length)})


def _within(reach: Fraction) -> tuple[float, float]:
    end = math.nextafter(float(reach), math.inf)
    return -end, end


def _stretch(poses: PoseModel, column: Compiled, error: float) -> Compiled:
    """The linear part of an elongation's column, in the format of the others."""
    task = poses.task
    reach = float(CHORD_REACH) * max(task.sections)
    sums = next(one for one in poses.place.plan.inputs if one.name == "sums")
    inputs = {"sum": Input((-reach, reach), sums.fraction_bits, 32, held=True)}
    outputs = {"linear": Output(error * task.length, column.formats["linear"])}
    return compile_function(stretch_function(task.segment_length), inputs, outputs)


def _parts(
    task: PoseTask,
    columns: Compiled,
    degrees: Degrees,
    poses: PoseBounds,
    angle: Fraction | None,
) -> _Parts:
    """Errors of a segment's columns for angles up to one in magnitude, or for all."""
    proof = columns.proof
    if angle is not None and angle < task.full_angle:
        inputs = tuple(narrowed(one, angle) for one in columns.plan.inputs)
        proof = prove(replace(columns.plan, inputs=inputs))
    bounds = proof.bounds()
    names = [one.name for one, _ in columns.plan.outputs]
    rounded = {
        kind: max(
            norm([bound for key, bound in zip(names, bounds, strict=True) if key == name])
            for name in (f"{kind}_u", f"{kind}_v")
        )
        for kind in ("turn", "chord")
    }
    frame = _up(poses.rotation)
    lacking = _truncations(task.full_angle if angle is None else angle, degrees)
    turn = frame + (1 + frame) * lacking[0] + rounded["turn"]
    chord = frame / 2 + (1 + frame) * lacking[1] + rounded["chord"]
    return _Parts(raised(turn), raised(chord), raised(1 + turn), raised(Fraction(1, 2) + chord))


def _bounds(
    task: PoseTask,
    parts: _Parts,
    functions: list[Compiled | None],
    poses: PoseBounds,
    stretch: Fraction,
) -> JacobianBounds:
    """Errors of whole columns."""
    column, elongation = functions
    assert column is not None
    length = Fraction(task.length) * (1 + stretch)
    position = _up(poses.position)
    own = Fraction(task.segment_length) * (1 + stretch) * parts.chord
    crossed = (1 + parts.turn) * position + parts.turn * length
    linear = own + crossed + norm(column.bounds["linear"])
    if elongation is not None:
        # The position's error holds h0 times that of the chords, with elongation.
        linear = max(linear, position + norm(elongation.bounds["linear"]))
    return JacobianBounds(_float(linear), _float(parts.turn))


def _up(value: float) -> Fraction:
    return Fraction(math.nextafter(value, math.inf))


def _float(value: Fraction) -> float:
    return math.nextafter(float(value), math.inf)
