"""One simulated shape of a joint, and what ideal sensors make of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint
from ccgen.kinematics import tip_pose
from ccgen.sensing.counts import counts_of, within
from ccgen.sensing.readings import length_changes
from ccgen.shapes import Shapes, single_shape, unstretched

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
    shapes = unstretched(u[None], v[None], len(geometry.sections), case)
    return Simulation(
        u=_sensed(joint, "u", shapes, u),
        v=_sensed(joint, "v", shapes, v),
        tip_pose=tip_pose(u, v, geometry.segment_length),
    )


def _sensed(joint: Joint, axis: str, shapes: Shapes, angles: Floats) -> SensedAxis:
    own = joint.own(axis)
    sensors, counts = joint.sensors[own], counts_of(joint, shapes)[0, own]
    unbent = joint.geometry.segment_length * np.array([sensor.segments for sensor in sensors])
    return SensedAxis(
        angles=angles,
        lengths=unbent + length_changes(joint, shapes.state)[0, own],
        counts=counts,
        out_of_range=tuple(
            j
            for j, (sensor, count) in enumerate(zip(sensors, counts, strict=True))
            if not within(sensor, int(count))
        ),
    )
