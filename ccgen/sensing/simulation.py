"""One simulated shape of a joint, and what ideal sensors make of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint
from ccgen.joint.loads import StatedLoads
from ccgen.kinematics import tip_pose
from ccgen.sensing.counts import raw_counts, within
from ccgen.sensing.readings import length_changes
from ccgen.shapes import Shapes, single_shape, unstretched

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Simulation:
    """A joint of m segments and S sections, bent, and what its n sensors measure."""

    u: Floats
    """Segment angles about x, shape (m,), radians."""
    v: Floats
    """Segment angles about y, shape (m,), radians."""
    h: Floats
    """Elongation of each section, shape (S,), share of its length."""
    lengths: Floats
    """Tendon length over each sensor's span, shape (n,), metres."""
    counts: Integers
    """Ideal readings, zeros included, shape (n,), counts."""
    out_of_range: tuple[int, ...]
    """Sensors whose count the transducer cannot give."""
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
    bent = single_shape(geometry.segments, case, first_segment)[None]
    straight = np.zeros_like(bent)
    u, v = (bent, straight) if axis == "u" else (straight, bent)
    return sensed(joint, unstretched(u, v, len(geometry.sections), case))


def simulate_loads(joint: Joint, loads: StatedLoads) -> Simulation:
    """Bend a joint under stated loads.

    Raises:
        ReachError: loads that buckle the joint, or bend a segment by more than 90 degrees.
    """
    from ccgen.shapes.loads.stated import shape_under

    return sensed(joint, shape_under(loads, joint.geometry.sections, joint.geometry.length))


def sensed(joint: Joint, shape: Shapes) -> Simulation:
    """What ideal sensors make of one shape; `shape` has one row."""
    geometry, (u,), (v,), (h,) = joint.geometry, shape.u, shape.v, shape.h
    counts = raw_counts(joint, shape)[0]
    unbent = geometry.segment_length * np.array([sensor.segments for sensor in joint.sensors])
    return Simulation(
        u=u,
        v=v,
        h=h,
        lengths=unbent + length_changes(joint, shape.state)[0],
        counts=counts,
        out_of_range=tuple(
            j
            for j, (sensor, count) in enumerate(zip(joint.sensors, counts, strict=True))
            if not within(sensor, int(count))
        ),
        tip_pose=tip_pose(u, v, segment_lengths(joint, h)),
    )


def segment_lengths(joint: Joint, elongation: Floats) -> Floats:
    """Neutral axis of each segment, shape (..., m), metres, for elongations (..., S)."""
    stretch = np.repeat(1.0 + elongation, joint.geometry.sections, axis=-1)
    return np.asarray(joint.geometry.segment_length * stretch)
