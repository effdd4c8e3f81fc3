"""The joint's geometry: what concerns several keys of [geometry] at once."""

import math

from ccgen.joint.messages import KeyProblemError, missing_key, toml_value
from ccgen.joint.specification import Geometry
from ccgen.joint.tables import LEAST_RANGE, GeometryTable, JointTable

_STEEPEST = 90.0
_NARROWEST = 1e-6
"""Width of a range of elongation, share of the length."""


def geometry_of(table: JointTable) -> Geometry:
    """Return the geometry; its elongation is what [geometry] or else [loads] states.

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    geometry = table.geometry
    elongation = _elongation(table)
    return Geometry(
        segments=geometry.segments,
        length=float(geometry.length),
        range_of_motion=math.radians(_range_of_motion(geometry)),
        sections=_sections(geometry, elongation is not None),
        elongation=elongation,
    )


def _range_of_motion(table: GeometryTable) -> float:
    """Degrees per segment and axis."""
    total, own = table.total_range_of_motion, table.range_of_motion
    if total is None:
        if own is None:
            field = GeometryTable.model_fields["range_of_motion"]
            raise KeyProblemError(missing_key("geometry.range_of_motion", field))
        return own
    if own is not None:
        raise KeyProblemError(
            "geometry.total_range_of_motion: stands beside range_of_motion; remove one of them"
        )
    if total > _STEEPEST * table.segments:
        raise KeyProblemError(
            f"geometry.total_range_of_motion: {total:g} degrees are more than {_STEEPEST:g} for "
            f"each of {table.segments} segments; write at most {_STEEPEST * table.segments:g}, or "
            "more segments"
        )
    if total < LEAST_RANGE * table.segments:
        raise KeyProblemError(
            f"geometry.total_range_of_motion: {total:g} degrees are less than {LEAST_RANGE:g} for "
            f"each of {table.segments} segments; write at least {LEAST_RANGE * table.segments:g}"
        )
    return total / table.segments


def _elongation(table: JointTable) -> tuple[float, float] | None:
    ends = table.geometry.elongation
    if ends is None:
        low, high = table.loads.elongation
        return (float(low), float(high)) if (low, high) != (0.0, 0.0) else None
    low, high = ends
    if high - low < _NARROWEST:
        what = f"is narrower than {_NARROWEST:g}"
        if low >= high:
            what = "is reversed" if low > high else "holds one value only"
        raise KeyProblemError(
            f"geometry.elongation: {toml_value(ends)} {what}; write the lowest share of the length "
            "first, such as elongation = [0.0, 0.05]"
        )
    return float(low), float(high)


def _sections(table: GeometryTable, elongates: bool) -> tuple[int, ...]:
    sections = table.sections
    if sections is None:
        return (table.segments,)
    if sum(sections) != table.segments:
        raise KeyProblemError(
            f"geometry.sections: {toml_value(sections)} are {sum(sections)} segments in all; "
            f"let them add up to segments = {table.segments}"
        )
    if not elongates:
        raise KeyProblemError(
            "geometry.sections: says which parts elongate by themselves, but the file states no "
            "elongation; write elongation = [0.0, 0.05] too, or remove sections"
        )
    return tuple(sections)
