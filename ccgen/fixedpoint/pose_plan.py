"""Plans integer poses, and proves how exact they are."""

import math
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from ccgen.errors import FormatError
from ccgen.fixedpoint.model import FixedPointModel
from ccgen.fixedpoint.pose import PoseBounds, PoseModel, PoseTask
from ccgen.fixedpoint.pose_bounds import (
    FRAME_MARGIN,
    Roundings,
    chain_bounds,
    norm,
    truncations,
)
from ccgen.fixedpoint.ranges import MARGIN
from ccgen.joint import AXES, Joint
from ccgen.kinematics.symbolic import TurnDegrees, place_function, turn_function
from ccgen.polynomial import Compiled, Input, Output, compile_function
from ccgen.polynomial.intervals import power_of_two
from ccgen.polynomial.proof import prove
from ccgen.polynomial.specification import Variable
from ccgen.shapes import Shapes

ANGLE_LIMIT = 4.0
"""Radians a segment: beyond, the series cancel more bits than 32 have to spare."""

TARGETS = {16: 4e-6, 32: 5e-7}
"""By precision, the error of the tip that plans are made for, as a share of the length."""

LAXEST = 64
"""Times the error that plans are made for: still below half a step of the TIP frame's signals."""

MOST_TERMS = 24
"""Most terms of a turn's series together; more cancel more bits than they bring."""

CHORD_REACH = Fraction(101, 100)
"""Longest chord of a segment of length 1, rounding and all."""

_SHARES = (
    (5.0, 0.6), (8.0, 0.2), (5.0, 0.3), (5.0, 0.1), (3.5, 0.3), (3.5, 0.1), (2.0, 0.3), (2.0, 0.1),
    (1.0, 0.2), (0.5, 0.1), (0.25, 0.05),
)  # fmt: skip
"""Shares of the aimed error that a frame's entries, over all segments, and a chord's may take.

Errors seldom are as large as they are allowed to be: the first pair whose bound is small enough
serves.
"""


@lru_cache(maxsize=64)  # plans take seconds, and one joint is exported again and again
def closest_poses(task: PoseTask) -> PoseModel:
    """Plan poses as exact as `TARGETS` say, or nearly so where no plan of 32 bits is.

    Raises:
        FormatError: the angles reach too far, or no plan is within `LAXEST` times that.
    """
    for lax in (1, 4, 16):
        with suppress(FormatError):
            return pose_model(task, lax * TARGETS[task.precision])
    return pose_model(task, LAXEST * TARGETS[task.precision])


def pose_model(task: PoseTask, target: float | None = None) -> PoseModel:
    """Plan poses that are proven as exact as is aimed at.

    Args:
        task: what they are made for.
        target: error of the tip as a share of the length; what `TARGETS` say unless it is given.

    Raises:
        FormatError: the angles reach too far, or no plan of 32 bits is as exact.
    """
    if task.full_angle > ANGLE_LIMIT:
        raise FormatError(
            f"the angle format reaches {float(task.full_angle):g} rad a segment, integer poses at "
            f"most {ANGLE_LIMIT:g}; use more segments or a smaller range of motion"
        )
    target = target or TARGETS[task.precision]
    degrees = _degrees(task, target / 3)
    place = _place(task, target * task.length / 20)
    most_bits = _frame_bits(float(task.full_angle))
    for frame_bits in range(most_bits, most_bits - 3, -1):
        for frame, chord in _SHARES:
            try:
                turn = _turn(task, degrees, frame * target, chord * target, frame_bits)
            except FormatError:
                break  # smaller shares need still more bits
            bounds = _bounds(task, turn, place, degrees)
            if bounds and bounds[0].position <= target * task.length:
                return PoseModel(task, turn, place, *bounds)
    raise _no_plan(task, target)


def _degrees(task: PoseTask, share: float) -> TurnDegrees:
    """Few terms whose truncation moves the tip by no more than a share of the length.

    For all angles of the format the frames' margin must hold as well. A first term of eta costs
    three products of its own: there is none unless the other series need it.
    """
    angle = min(Fraction(task.angle), task.full_angle)

    def excess(degrees: TurnDegrees) -> Fraction:
        turn, chord = truncations(angle, degrees)
        widest, _ = truncations(task.full_angle, degrees)
        near = (turn * task.segments / 2 + chord) / Fraction(share)
        return max(near, 4 * widest * task.segments / FRAME_MARGIN)

    degrees = TurnDegrees(1, 0, 0)
    while excess(degrees) > 1:
        if degrees.alpha + degrees.kappa + degrees.eta >= MOST_TERMS:
            raise _no_plan(task, 3 * share)
        longer = min(
            replace(degrees, alpha=degrees.alpha + 1),
            replace(degrees, kappa=degrees.kappa + 1),
            key=excess,
        )
        other = replace(degrees, eta=degrees.eta + 1)
        # Where angles are wide, a term more may err by more until the next one is there as well.
        helps = excess(longer) < Fraction(9, 10) * excess(degrees)
        degrees = longer if helps or excess(other) >= excess(degrees) else other
    return degrees


def _no_plan(task: PoseTask, target: float) -> FormatError:
    return FormatError(
        f"no plan of 32 bits has poses of {task.segments} segments within {target:g} of the length "
        f"for angles up to {float(task.full_angle):.3g} rad; use fewer segments or "
        "a smaller range of motion"
    )


def _turn(
    task: PoseTask, degrees: TurnDegrees, frame: float, chord: float, frame_bits: int
) -> Compiled:
    """One segment's plan; frames after all segments and every chord may err by so much."""
    one = float(1 + FRAME_MARGIN)
    u, v = (
        Input((-end, end), bits, task.precision)
        for bits in task.fraction_bits
        for end in [task.largest * 2.0**-bits]
    )
    inputs = {"frame": Input((-one, one), frame_bits, 32, held=True), "u": u, "v": v}
    outputs = {
        "distal": Output(frame / (3 * max(task.segments - 1, 1)), frame_bits),
        "chord": Output(chord, _sum_bits(task)),
    }
    return compile_function(turn_function(degrees), inputs, outputs)


def _frame_bits(angle: float) -> int:
    """Most fraction bits of a frame with room for what intervals think a turn about one axis does.

    Where both axes bend far, intervals may need a bit more.
    """
    reach = 1.01 + angle * (1 + angle + angle**2 / 3 + angle**3 / 6)
    return 31 - math.ceil(math.log2(reach))


def _sum_bits(task: PoseTask) -> int:
    """Fraction bits with which the sum of all chords fits 32 bits."""
    return 30 - math.ceil(math.log2(float(CHORD_REACH) * task.segments))


def _place(task: PoseTask, error: float) -> Compiled:
    """The position's plan."""
    reach = [float(CHORD_REACH) * count for count in task.sections for _ in range(3)]
    inputs = {"sums": Input([(-end, end) for end in reach], _sum_bits(task), 32, held=True)}
    if task.elongation_bits is not None:
        end = task.largest * 2.0**-task.elongation_bits
        inputs["h"] = Input((-end, end), task.elongation_bits, task.precision)
    function = place_function(task.segment_length, len(task.sections), "h" in inputs)
    return compile_function(function, inputs, {"position": Output(error)})


def _bounds(
    task: PoseTask, turn: Compiled, place: Compiled, degrees: TurnDegrees
) -> tuple[PoseBounds, PoseBounds] | None:
    """Bounds over what shapes need and over all that the formats hold; None where errors add up
    to more than the frames' margin.
    """
    found = []
    for angle, stretch in (
        (min(Fraction(task.angle), task.full_angle), Fraction(task.elongation)),
        (task.full_angle, task.full_elongation),
    ):
        roundings = _roundings(turn, angle if angle < task.full_angle else None)
        chain = chain_bounds(task.segments, angle, degrees, roundings)
        _, lacking = truncations(angle, degrees)
        reach = (1 + chain.frame) * (1 + lacking) + roundings.chord
        if chain.frame > FRAME_MARGIN or reach > CHORD_REACH:
            return None
        own = norm(place.bounds["position"])
        position = Fraction(task.segment_length) * (1 + stretch) * chain.chords + own
        found.append(PoseBounds(float(position), float(chain.frame)))
    return found[0], found[1]


def _roundings(turn: Compiled, angle: Fraction | None) -> Roundings:
    """What a segment rounds away for angles up to one in magnitude, or for all."""
    proof = turn.proof
    if angle is not None:
        inputs = tuple(narrowed(one, angle) for one in turn.plan.inputs)
        proof = prove(replace(turn.plan, inputs=inputs))
    bounds = proof.bounds()
    names = [one.name for one, _ in turn.plan.outputs]
    parts = {
        name: [bound for key, bound in zip(names, bounds, strict=True) if key == name]
        for name in ("distal", "chord")
    }
    return Roundings(norm(parts["distal"]), norm(parts["chord"]))


def narrowed(variable: Variable, angle: Fraction) -> Variable:
    """An angle's input with no more than so many radians; a frame's entry as it is."""
    if variable.name == "frame":
        return variable
    most = math.floor(angle * power_of_two(variable.fraction_bits))
    return replace(variable, low=max(variable.low, -most), high=min(variable.high, most))


def pose_task(joint: Joint, model: FixedPointModel, shapes: Shapes) -> PoseTask:
    """What a joint's integer poses are made for.

    Args:
        joint: the joint.
        model: its integer model, whose formats the angles have; a bending axis that it lacks has
            the other's format.
        shapes: that the formats were chosen for.
    """
    state = np.abs(shapes.state)
    bending = [model.axes[axis].fraction_bits for axis in AXES if axis in model.axes]
    length = model.axes.get("h")
    return PoseTask(
        sections=joint.geometry.sections,
        segment_length=joint.geometry.segment_length,
        precision=model.precision,
        fraction_bits=(bending[0], bending[-1]),
        angle=MARGIN * max(float(state[:, joint.rows(axis)].max()) for axis in AXES),
        elongation_bits=None if length is None else length.fraction_bits,
        elongation=0.0 if length is None else MARGIN * float(state[:, joint.rows("h")].max()),
    )
