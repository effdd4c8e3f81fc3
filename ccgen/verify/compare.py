"""Compares what came over a bus with the reference models."""

import math

import numpy as np
from numpy.typing import NDArray

from ccgen import kinematics
from ccgen.can.exchange import Exchange
from ccgen.fixedpoint.guarded import LOST
from ccgen.fixedpoint.pose import pose_inputs
from ccgen.sensing.simulation import segment_lengths
from ccgen.targets.exported import Exported
from ccgen.verify.run import Run

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

_BLOCK = 4096
_TIP_LIMIT = 2**15 - 1
"""Steps of a coordinate at which TIP saturates."""

_NO_TIP = -(2**15)
"""Of a coordinate: no reading."""


def compare_exchange(
    exported: Exported, target: str, transport: str, counts: Integers, answers: Exchange
) -> Run:
    """Compare every angle and every tip bit for bit, where published.

    Beside it, how far tips lie from double precision: a bound that single precision would keep,
    and that is left out where the folder has no poses in single precision.

    Args:
        exported: the folder, with its reference model.
        target, transport: for the record.
        counts: shape (k, n), what was sent.
        answers: what came back.
    """
    followed = exported.guarded.follow(counts)
    right = followed.values
    complete = answers.complete
    layout = exported.layout
    compared = right[complete if layout.publishes("angles") else np.zeros_like(complete)]
    wrong = int(np.count_nonzero(answers.angles[complete][: len(compared)] != compared))
    lost = (followed.states == LOST).any(axis=1)
    whole = complete & ~lost
    # A tip is rounded to half a step; the rest is the bound of single precision.
    step = 2.0**-layout.tip_fraction_bits
    tips = tip_positions(exported, right[whole]) if layout.publishes("tip") else np.zeros((0, 3))
    distance = np.linalg.norm(answers.tips[whole][: len(tips)] * step - tips, axis=-1)
    bounds = exported.pose_bounds
    compared_tips = wrong_tips = 0
    if layout.publishes("tip"):
        compared_tips = int(np.count_nonzero(complete))
        wrong_tips = int(
            np.count_nonzero(
                (answers.tips[whole] != tip_signals(exported, right[whole])).any(axis=1)
            )
        )
        gone = answers.tips[complete & lost] != _NO_TIP
        wrong_tips += int(np.count_nonzero(gone.any(axis=1)))
    return Run(
        target=target,
        transport=transport,
        snapshots=answers.snapshots,
        compared_values=compared.size or tips.size,
        mismatches=wrong,
        lost_frames=answers.lost_frames,
        rate_hz=answers.rate_hz,
        pose_max_error_m=None if bounds is None else float(distance.max(initial=0.0)),
        pose_bound_m=None if bounds is None else bounds.position + 0.5 * math.sqrt(3.0) * step,
        note=_note(exported, answers),
        degraded_snapshots=int(np.count_nonzero(followed.states.any(axis=1))),
        compared_poses=compared_tips,
        pose_mismatches=wrong_tips,
    )


def _note(exported: Exported, answers: Exchange) -> str:
    other = answers.stranger(exported.fingerprint & 0xFFFF)
    damaged = f"{answers.corrupted} frames came damaged" if answers.corrupted else ""
    gone = f"the bus went away ({answers.gone})" if answers.gone else ""
    return "; ".join(filter(None, (other, damaged, gone)))


def states_of(exported: Exported, values: Integers) -> tuple[Floats, Floats, Floats]:
    """Bends (rad) and lengths (m) of all segments, each (k, m), from integer values of all axes.

    A bend that is not estimated is none, as in the C.
    """
    model, geometry = exported.model, exported.joint.geometry
    parts = {axis: model.axis(axis).radians(own) for axis, own in model.split(values).items()}
    straight = np.zeros((len(values), geometry.segments))
    rest = np.zeros((len(values), len(geometry.sections)))
    lengths = segment_lengths(exported.joint, parts.get("h", rest))
    return parts.get("u", straight), parts.get("v", straight), lengths


def tip_signals(exported: Exported, values: Integers) -> Integers:
    """Coordinates of TIP frames as the integer model has them; values of all axes to (k, 3)."""
    shift = exported.poses.position_bits - exported.layout.tip_fraction_bits
    doubled = integer_tips(exported, values)[:, 9:] >> (shift - 1)
    return np.asarray(np.clip((doubled + 1) >> 1, -_TIP_LIMIT, _TIP_LIMIT))


def integer_tips(exported: Exported, values: Integers) -> Integers:
    """Tip poses of the integer model, as the C has them; values of all axes to (k, 12)."""
    found = [np.zeros((0, 12), dtype=np.int64)]
    for first in range(0, len(values), _BLOCK):
        inputs = pose_inputs(exported.model, values[first : first + _BLOCK])
        found.append(exported.poses.entries(*inputs))
    return np.concatenate(found)


def integer_jacobians(exported: Exported, values: Integers) -> Integers:
    """Tip Jacobians of the integer model, as the C has them; values of all axes to (k, 6, rows)."""
    model = exported.model
    u, v, h = pose_inputs(model, values)
    found = exported.jacobian.jacobian(u, v, h)
    m = model.segments
    columns = {"u": found[..., :m], "v": found[..., m : 2 * m], "h": found[..., 2 * m :]}
    return np.concatenate([columns[axis] for axis in model.axes], axis=-1)


def tip_positions(exported: Exported, values: Integers) -> Floats:
    """Tip positions, metres, held by the TIP frame's format; values of all axes to (k, 3)."""
    most = _TIP_LIMIT * 2.0**-exported.layout.tip_fraction_bits
    return np.clip(pose_positions(exported, values), -most, most)


def pose_positions(exported: Exported, values: Integers) -> Floats:
    """Tip positions in double precision, metres; integer values of all axes to (k, 3)."""
    positions = [np.zeros((0, 3))]
    for first in range(0, len(values), _BLOCK):
        poses = kinematics.tip_pose(*states_of(exported, values[first : first + _BLOCK]))
        positions.append(poses[:, :3, 3])
    return np.concatenate(positions)


def tip_jacobians(exported: Exported, values: Integers) -> Floats:
    """Tip Jacobians in double precision, a column a value; to (k, 6, values)."""
    u, v, lengths = states_of(exported, values)
    geometry, bends = exported.joint.geometry, kinematics.tip_jacobian(u, v, lengths)
    m = geometry.segments
    columns = {
        "u": bends[..., :m],
        "v": bends[..., m:],
        "h": kinematics.elongation_columns(u, v, geometry.segment_length, geometry.sections),
    }
    return np.concatenate([columns[axis] for axis in exported.model.axes], axis=-1)
