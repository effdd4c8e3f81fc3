"""Rows of shapes under loads for a joint: what it states, and what nobody stated."""

from __future__ import annotations

import numpy as np

from ccgen.errors import ReachError
from ccgen.joint import Joint
from ccgen.shapes.library import Shapes
from ccgen.shapes.loads.drawn import DrawnShapes, drawn_shapes
from ccgen.shapes.loads.other import KINDS, other_shapes


def loads_library(joint: Joint) -> DrawnShapes | None:
    """Shapes under the joint's own loads, of the source "loads"; None where it states none.

    Raises:
        ReachError: names the joint file and its key where no draw gives a shape.
    """
    ranges, geometry = joint.loads, joint.geometry
    if ranges is None:
        return None
    drawn = drawn_shapes(ranges, geometry.sections, geometry.length, geometry.range_of_motion)
    if not len(drawn.shapes):
        raise ReachError(f"{joint.source}: loads: {_what_failed(drawn)}; {_remedy(drawn)}")
    return drawn


def shortfall(drawn: DrawnShapes, wanted: int) -> str | None:
    """Say how many shapes there are and why, where they are fewer than wanted."""
    found = len(drawn.shapes)
    return None if found >= wanted else f"{found} of {wanted} shapes: {_what_failed(drawn)}"


def other_library(joint: Joint) -> Shapes:
    """Shapes of loads that nobody has stated, of the source "other loads".

    Each bends u and v by two shapes of a kind, as estimators of either axis meet them.
    """
    geometry = joint.geometry
    other = other_shapes(geometry.segments, geometry.range_of_motion)
    kinds = np.array(other.kinds)
    partner = np.concatenate(
        [np.roll(np.flatnonzero(kinds == kind), 1) for kind in KINDS if kind in other.kinds]
    )
    return Shapes(
        other.angles,
        other.angles[partner],
        np.zeros((len(kinds), len(geometry.sections))),
        ("other loads",) * len(kinds),
    )


def _what_failed(drawn: DrawnShapes) -> str:
    parts = [f"of {drawn.drawn} draws"]
    if drawn.buckled:
        parts.append(f"{drawn.buckled} buckle")
    if drawn.out_of_range:
        parts.append(f"{drawn.out_of_range} bend beyond the range of motion by weight alone")
    return f"{parts[0]} {' and '.join(parts[1:])}"


def _remedy(drawn: DrawnShapes) -> str:
    if drawn.buckled > drawn.out_of_range:
        return "write smaller loads or a larger loads.stiffness"
    return "write a smaller loads.mass, a larger loads.stiffness or geometry.range_of_motion"
