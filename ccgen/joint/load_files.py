"""Loads from a user's files: what concerns several keys of [loads], or of stated loads, at once."""

import math
from pathlib import Path

from pydantic import ValidationError

from ccgen.errors import InputError
from ccgen.joint import toml
from ccgen.joint.load_tables import StatedLoadsTable, StiffnessTable
from ccgen.joint.loads import Contact, LoadRanges, Range, StatedLoads, Vector
from ccgen.joint.messages import KeyProblemError, first_problem, toml_value
from ccgen.joint.specification import Geometry
from ccgen.joint.tables import JointTable

_BENDING = ("mass", "payload", "tip_force", "tip_moment", "contact")
"""Keys of [loads] whose loads bend the joint by its stiffness; actuation is told as a bend."""
_STATED_BENDING = ("tip_force", "tip_moment", "distributed", "contacts")

_STATED_KIND = toml.Kind(
    "file of loads", "write one, such as tip_force = [1.0, 0.0, 0.0]", "stiffness = 0.4"
)


def load_ranges(table: JointTable) -> LoadRanges | None:
    """Return the ranges of [loads]; None where a joint file has no such table.

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    if "loads" not in table.model_fields_set:
        return None
    loads = table.loads
    stated = [key for key in _BENDING if _any(getattr(loads, key))]
    if not stated and not _any(loads.actuation) and not _any(loads.elongation):
        raise KeyProblemError(
            f"loads: states no load; write one of actuation, {', '.join(_BENDING)}, such as "
            "actuation = [-90.0, 90.0]"
        )
    if loads.contact_from > table.geometry.length:
        raise KeyProblemError(
            f"loads.contact_from: {loads.contact_from} m lies beyond the tip; write metres from 0 "
            f"at the base to {table.geometry.length} at the tip (geometry.length)"
        )
    ranges = {
        key: _range(getattr(loads, key), f"loads.{key}")
        for key in ("payload", "tip_force", "tip_moment", "contact", "elongation")
    }
    low, high = _range(loads.actuation, "loads.actuation")
    return LoadRanges(
        samples=loads.samples,
        stiffness=_stiffness(loads, stated, "loads."),
        stiffness_profile=tuple(loads.stiffness_profile),
        stiffness_tolerance=loads.stiffness_tolerance,
        actuation=(math.radians(low), math.radians(high)),
        mass=loads.mass,
        mounting=None if loads.mounting is None else math.radians(loads.mounting),
        contact_from=loads.contact_from,
        **ranges,
    )


def read_loads(path: Path, geometry: Geometry) -> StatedLoads:
    """Read and check a file of loads on a joint.

    Raises:
        InputError: in one line the file, the key (or line), what is wrong, what would be right.
    """
    return parse_loads(toml.read(path, _STATED_KIND), str(path), geometry)


def parse_loads(text: str, source: str, geometry: Geometry) -> StatedLoads:
    """Check the text of a file of loads; `source` names it in messages.

    Raises:
        InputError: as `read_loads`.
    """
    document = toml.parse(text, source, _STATED_KIND)
    try:
        return _stated(StatedLoadsTable.model_validate(document), source, geometry)
    except ValidationError as error:
        raise InputError(f"{source}: {first_problem(error, StatedLoadsTable)}") from None
    except KeyProblemError as problem:
        raise InputError(f"{source}: {problem}") from None


def _stated(table: StatedLoadsTable, source: str, geometry: Geometry) -> StatedLoads:
    for i, contact in enumerate(table.contacts):
        if contact.at > geometry.length:
            raise KeyProblemError(
                f"contacts[{i}].at: {contact.at} m lies beyond the tip; write metres from 0 at the "
                f"base to {geometry.length} at the tip"
            )
    sections = len(geometry.sections)
    if table.elongation and len(table.elongation) != sections:
        raise KeyProblemError(
            f"elongation: {toml_value(table.elongation)} has {len(table.elongation)} numbers; "
            f"write one for each of the joint's sections, here {sections}"
        )
    stated = [key for key in _STATED_BENDING if _any(getattr(table, key))]
    return StatedLoads(
        stiffness=_stiffness(table, stated),
        stiffness_profile=tuple(table.stiffness_profile),
        actuation=(math.radians(table.actuation_u), math.radians(table.actuation_v)),
        tip_force=_vector(table.tip_force),
        tip_moment=(table.tip_moment[0], table.tip_moment[1]),
        distributed=_vector(table.distributed),
        contacts=tuple(Contact(c.at, _vector(c.force)) for c in table.contacts),
        elongation=tuple(table.elongation),
        source=source,
    )


def _stiffness(table: StiffnessTable, bending: list[str], prefix: str = "") -> float:
    """Return the stiffness, or 1 where no load bends by it."""
    if table.stiffness is None and bending:
        raise KeyProblemError(
            f"{prefix}stiffness: missing, but {bending[0]} bends the joint by it; write "
            "stiffness = 0.4 (N m^2, the bending stiffness)"
        )
    return 1.0 if table.stiffness is None else table.stiffness


def _any(value: object) -> bool:
    """Tell whether a load is there: a number that is not 0, a list that holds anything else."""
    return any(value) if isinstance(value, list) else bool(value)


def _range(ends: list[float], key: str) -> Range:
    low, high = ends
    if low > high:
        raise KeyProblemError(
            f"{key}: {toml_value(ends)} is reversed; write {toml_value([high, low])}"
        )
    return low, high


def _vector(values: list[float]) -> Vector:
    x, y, z = values
    return x, y, z
