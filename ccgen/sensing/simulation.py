"""One simulated shape of a joint, and what ideal sensors make of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint
from ccgen.kinematics import U_SENSOR_ANGLE, V_SENSOR_ANGLE, tendon_length, tip_pose
from ccgen.sensing.counts import counts_of
from ccgen.shapes import single_shape

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SensedAxis:
    """One bending axis: its m segments' angles and what its n sensors measure."""

    angles: Floats
    """Shape (m,), radians."""
    lengths: Floats
    """Tendon length over each sensor's span, shape (n,), metres."""
    counts: Integers
    """Ideal readings with zero at the straight pose, shape (n,), counts."""
    out_of_range: tuple[int, ...]
    """Sensors whose count the transducer cannot give."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A joint bent in one plane."""

    u: SensedAxis
    v: SensedAxis
    tip_pose: Floats
    """Homogeneous transform in the base frame, shape (4, 4), metres."""


def simulate(joint: Joint, case: str, first_segment: float, axis: str = "u") -> Simulation:
    """Bend one axis of a joint under a load case; the other axis stays straight.

    Args:
        joint: the specification.
        case: load case, a name of `ccgen.joint.CASES`.
        first_segment: angle of the first segment, radians, of either sign.
        axis: "u" or "v".

    Raises:
        ReachError: an angle that the load case does not reach.
    """
    geometry = joint.geometry
    bent = single_shape(geometry.segments, case, first_segment)
    straight = np.zeros(geometry.segments)
    u, v = (bent, straight) if axis == "u" else (straight, bent)
    h = geometry.segment_length
    lengths_u, lengths_v = (
        tendon_length(u, v, h, joint.axis(name).radius, alpha)
        for name, alpha in (("u", U_SENSOR_ANGLE), ("v", V_SENSOR_ANGLE))
    )
    return Simulation(
        u=_sensed(joint, "u", u, lengths_u),
        v=_sensed(joint, "v", v, lengths_v),
        tip_pose=tip_pose(u, v, h),
    )


def _sensed(joint: Joint, axis: str, angles: Floats, segment_lengths: Floats) -> SensedAxis:
    sensors = joint.axis(axis)
    counts = counts_of(sensors, angles[None, :])[0]
    largest = 2 ** (sensors.transducer.bits - 1) - 1
    low, high = sensors.transducer.range or (-largest, largest)
    return SensedAxis(
        angles=angles,
        lengths=np.array([segment_lengths[a : b + 1].sum() for a, b in sensors.spans]),
        counts=counts,
        out_of_range=tuple(np.flatnonzero((counts < low) | (counts > high)).tolist()),
    )
