"""What the columns of a recording mean: time, counts, bodies, segment angles, elongation.

| column | what it holds |
|---|---|
| `t` | seconds |
| `count_NAME` | raw counts of sensor NAME |
| `BODY_x`, `BODY_y`, `BODY_z` | position of a body or marker, metres |
| `BODY_qx`, `BODY_qy`, `BODY_qz`, `BODY_qw` | its orientation, a unit quaternion |
| `u0` …, `v0` … | segment angles, degrees |
| `elongation`, or `h0` … | share of the length, for all sections or for each |
"""

import difflib
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.recordings.table import Table

Floats = NDArray[np.float64]

POSITION = ("x", "y", "z")
ORIENTATION = ("qx", "qy", "qz", "qw")

_COUNT = "count_"
_BODY = re.compile(r"(.+)_(q?[xyz]|qw)")
_INDEXED = re.compile(r"([uvh])(0|[1-9][0-9]{0,3})")


@dataclass(frozen=True)
class Expected:
    """What the joint file lets a recording hold."""

    sensors: tuple[str, ...]
    segments: int
    sections: int = 1
    bodies: tuple[str, ...] = ()
    """Bodies and markers that the joint file names."""


@dataclass(frozen=True, eq=False)
class Columns:
    """A table by meaning; NaN where a cell is empty, units as in the file."""

    t: Floats | None
    """Shape (N,), seconds; None without a column."""
    counts: Floats | None
    """Shape (N, sensors), in the joint's order; None where no sensor has a column."""
    positions: dict[str, Floats]
    """By body, shape (N, 3), metres."""
    orientations: dict[str, Floats]
    """By body, shape (N, 4), quaternions x, y, z, w."""
    u: Floats | None
    """Shape (N, segments), degrees; None where neither axis has a column."""
    v: Floats | None
    """Shape (N, segments), degrees."""
    h: Floats | None
    """Shape (N, sections), share of the length; None without a column."""


def sorted_columns(table: Table, expected: Expected) -> Columns:
    """Sort the columns of a table by what they mean.

    Raises:
        InputError: a column that no joint has or this one does not, a body in parts.
    """
    known = _Sorter(table, expected)
    for name in table.names:
        known.take(name)
    return known.columns()


class _Sorter:
    """Takes the columns one by one; says of each that does not fit what would."""

    def __init__(self, table: Table, expected: Expected) -> None:
        self._table = table
        self._expected = expected
        self._bodies: dict[str, set[str]] = {}

    def take(self, name: str) -> None:
        if name in ("t", "elongation"):
            return
        if name.startswith(_COUNT):
            self._check_sensor(name)
        elif found := _INDEXED.fullmatch(name):
            self._check_index(name, found[1], int(found[2]))
        elif found := _BODY.fullmatch(name):
            self._bodies.setdefault(found[1], set()).add(found[2])
        else:
            raise InputError(
                f"{self._table.source}: column {_shown(name)} is unknown; {self._remedy(name)}"
            )

    def columns(self) -> Columns:
        for body, parts in self._bodies.items():
            self._check_body(body, parts)
        names = self._table.names
        if "elongation" in names and any(f"h{i}" in names for i in range(self._expected.sections)):
            raise InputError(
                f"{self._table.source}: columns elongation and h0 say the same; remove one of them"
            )
        return Columns(
            t=self._table.column("t") if "t" in names else None,
            counts=self._gathered(f"{_COUNT}{name}" for name in self._expected.sensors),
            positions={body: self._all(body, POSITION) for body in self._bodies},
            orientations={
                body: self._all(body, ORIENTATION)
                for body, parts in self._bodies.items()
                if parts.issuperset(ORIENTATION)
            },
            u=self._angles("u"),
            v=self._angles("v"),
            h=self._elongation(),
        )

    def _angles(self, axis: str) -> Floats | None:
        """Angles of one axis; all NaN where only the other axis has columns."""
        m = self._expected.segments
        both = [self._gathered(f"{name}{i}" for i in range(m)) for name in (axis, "uv".strip(axis))]
        if both[0] is None and both[1] is not None:
            return np.full_like(both[1], np.nan)
        return both[0]

    def _elongation(self) -> Floats | None:
        if "elongation" in self._table.names:
            whole = self._table.column("elongation")
            return np.repeat(whole[:, None], self._expected.sections, axis=1)
        return self._gathered(f"h{i}" for i in range(self._expected.sections))

    def _gathered(self, names: Iterable[str]) -> Floats | None:
        """Columns of these names side by side, NaN for those that are missing; None without any."""
        wanted = list(names)
        if not any(name in self._table.names for name in wanted):
            return None
        empty = np.full(len(self._table.values), np.nan)
        there = set(self._table.names)
        return np.stack([self._table.column(n) if n in there else empty for n in wanted], axis=1)

    def _all(self, body: str, parts: tuple[str, ...]) -> Floats:
        return np.stack([self._table.column(f"{body}_{part}") for part in parts], axis=1)

    def _check_sensor(self, name: str) -> None:
        sensor = name.removeprefix(_COUNT)
        if sensor in self._expected.sensors:
            return
        near = difflib.get_close_matches(sensor, self._expected.sensors, n=1)
        remedy = (
            f"did you mean {_COUNT}{near[0]}?"
            if near
            else f"its sensors are {', '.join(self._expected.sensors)}"
        )
        raise InputError(
            f"{self._table.source}: column {_shown(name)}: the joint has no sensor "
            f"{_shown(sensor)}; {remedy}"
        )

    def _check_index(self, name: str, axis: str, index: int) -> None:
        count = self._expected.sections if axis == "h" else self._expected.segments
        if index >= count:
            parts = "section" if axis == "h" else "segment"
            raise InputError(
                f"{self._table.source}: column {name}: the joint has {count} {parts}"
                f"{'' if count == 1 else 's'}; write {axis}0 to {axis}{count - 1}"
            )

    def _check_body(self, body: str, parts: set[str]) -> None:
        for whole in (POSITION, ORIENTATION):
            missing = [part for part in whole if part not in parts]
            if missing and (whole is POSITION or not parts.isdisjoint(whole)):
                columns = ", ".join(_shown(f"{body}_{part}") for part in whole)
                raise InputError(
                    f"{self._table.source}: column {_shown(f'{body}_{missing[0]}')} is missing; "
                    f"write all of {columns}"
                )

    def _remedy(self, name: str) -> str:
        """What might have been meant by a column."""
        near = difflib.get_close_matches(name, self._known(), n=1)
        if near and near[0] not in self._table.names:
            return f"did you mean {near[0]}?"
        return (
            "write t, count_SENSOR, BODY_x BODY_y BODY_z, BODY_qx BODY_qy BODY_qz BODY_qw, "
            "u0 ..., v0 ..., elongation or h0 ..."
        )

    def _known(self) -> list[str]:
        expected = self._expected
        return [
            "t",
            "elongation",
            *(f"{_COUNT}{sensor}" for sensor in expected.sensors),
            *(f"{axis}{i}" for axis in "uv" for i in range(expected.segments)),
            *(f"h{i}" for i in range(expected.sections)),
            *(f"{body}_{part}" for body in expected.bodies for part in (*POSITION, *ORIENTATION)),
        ]


def _shown(name: str) -> str:
    """A name from the file as it may stand in one line of a message."""
    text = name if len(name) <= 40 else name[:36] + " ..."
    return text if text.isprintable() else repr(text)
