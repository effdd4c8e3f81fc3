"""Compares what came over a bus with the reference models."""

import math

import numpy as np
from numpy.typing import NDArray

from ccgen import kinematics
from ccgen.can.exchange import Exchange
from ccgen.targets.exported import Exported
from ccgen.verify.run import Run

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

_BLOCK = 4096


def compare_exchange(
    exported: Exported, target: str, transport: str, counts: Integers, answers: Exchange
) -> Run:
    """Compare every angle bit for bit and every tip position within its bound, where published.

    Args:
        exported: the folder, with its reference model.
        target, transport: for the record.
        counts: shape (k, nu + nv), what was sent.
        answers: what came back.
    """
    right = exported.model.estimate(counts)
    complete = answers.complete
    layout = exported.layout
    compared = right[complete if layout.publishes("angles") else np.zeros_like(complete)]
    wrong = int(np.count_nonzero(answers.angles[complete][: len(compared)] != compared))
    # A tip is rounded to half a step; the rest is the bound of single precision.
    step = 2.0**-layout.tip_fraction_bits
    tips = tip_positions(exported, right[complete]) if layout.publishes("tip") else np.zeros((0, 3))
    distance = np.linalg.norm(answers.tips[complete][: len(tips)] * step - tips, axis=-1)
    return Run(
        target=target,
        transport=transport,
        snapshots=answers.snapshots,
        compared_values=compared.size or tips.size,
        mismatches=wrong,
        lost_frames=answers.lost_frames,
        rate_hz=answers.rate_hz,
        pose_max_error_m=float(distance.max(initial=0.0)),
        pose_bound_m=exported.pose_bounds.position + 0.5 * math.sqrt(3.0) * step,
        note=_note(exported, answers),
    )


def _note(exported: Exported, answers: Exchange) -> str:
    other = answers.stranger(exported.fingerprint & 0xFFFF)
    damaged = f"{answers.corrupted} frames came damaged" if answers.corrupted else ""
    gone = f"the bus went away ({answers.gone})" if answers.gone else ""
    return "; ".join(filter(None, (other, damaged, gone)))


def angles_in_radians(exported: Exported, angles: Integers) -> tuple[Floats, Floats]:
    """Both axes of integer angles, shape (k, 2 m), in rad; each (k, m)."""
    m = exported.model.segments
    return exported.model.u.radians(angles[:, :m]), exported.model.v.radians(angles[:, m:])


def tip_positions(exported: Exported, angles: Integers) -> Floats:
    """Tip positions in double precision, metres; (k, 2 m) integer angles to (k, 3)."""
    h = exported.joint.geometry.segment_length
    positions = [np.zeros((0, 3))]
    for first in range(0, len(angles), _BLOCK):
        u, v = angles_in_radians(exported, angles[first : first + _BLOCK])
        positions.append(kinematics.tip_pose(u, v, h)[:, :3, 3])
    return np.concatenate(positions)
