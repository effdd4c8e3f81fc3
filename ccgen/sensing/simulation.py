"""One simulated shape of a joint, and what ideal sensors make of it."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import ArgumentError
from ccgen.joint import AXES, CASES, Joint
from ccgen.joint.loads import StatedLoads
from ccgen.kinematics import tip_pose
from ccgen.sensing.counts import raw_counts, within
from ccgen.sensing.readings import length_changes
from ccgen.shapes import Shapes, single_shape, unstretched
from ccgen.shapes.given import angle_problem

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


def simulate(
    joint: Joint,
    case: str | None = None,
    first_segment: float | None = None,
    axis: str | None = None,
    loads: StatedLoads | str | Path | None = None,
    far: bool = False,
) -> Simulation:
    """Bend a joint under a load case in one axis, or under stated loads.

    Args:
        joint: the specification.
        case: load case, a name of `ccgen.joint.CASES`.
        first_segment: angle of the first segment under the load case, radians, of either sign.
        axis: "u" or "v", the axis that bends under the load case while the other stays straight;
            by default the first that is estimated.
        loads: instead of a load case; the path of a TOML file that states them, or as read.
        far: whether an angle of several times the range of motion is meant; else it is taken for
            degrees, and refused.

    Raises:
        ArgumentError: neither a load case with an angle nor loads, or both; a name or an angle that
            cannot be. ReachError: an angle that the load case does not reach; loads that buckle
            the joint or bend a segment by more than 90 degrees. InputError: a wrong file of loads.
    """
    if loads is not None:
        for name, value in (("case", case), ("first_segment", first_segment), ("axis", axis)):
            if value is not None:
                raise ArgumentError("belongs to a load case; give it or loads, not both", name)
        return _under_loads(joint, loads)
    if case is None or first_segment is None:
        raise ArgumentError(
            "missing; give a case with the angle of the first segment, or loads",
            "case" if case is None else "first_segment",
        )
    if case not in CASES:
        raise ArgumentError(f"{case!r} is unknown; known: {', '.join(CASES)}", "case")
    if axis not in (None, *AXES):
        raise ArgumentError(f"{axis!r} is unknown; known: {', '.join(AXES)}", "axis")
    _check_angle(joint, first_segment, far)
    geometry = joint.geometry
    bent = single_shape(geometry.segments, case, first_segment)[None]
    straight = np.zeros_like(bent)
    u, v = (bent, straight) if (axis or joint.axes[0]) == "u" else (straight, bent)
    return sensed(joint, unstretched(u, v, len(geometry.sections), case))


def _check_angle(joint: Joint, first_segment: float, far: bool) -> None:
    within = abs(first_segment) <= math.pi / 2
    problem = None if within and far else angle_problem(joint, first_segment)
    if problem is not None:
        raise ArgumentError(problem, "first_segment")


def _under_loads(joint: Joint, loads: StatedLoads | str | Path) -> Simulation:
    from ccgen.joint.load_files import read_loads
    from ccgen.shapes.loads.stated import shape_under

    geometry = joint.geometry
    stated = loads if isinstance(loads, StatedLoads) else read_loads(Path(loads), geometry)
    return sensed(joint, shape_under(stated, geometry.sections, geometry.length))


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
