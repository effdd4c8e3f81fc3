"""Whether a recording makes sense: each check says in one line what is wrong and what is right.

What is recognised by its size: degrees and radians, metres and millimetres, shares and per cent.
"""

import difflib
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.recordings.columns import ORIENTATION
from ccgen.recordings.sensors import RecordedSensors
from ccgen.recordings.table import Table

Floats = NDArray[np.float64]

FEWEST_ROWS = 10
"""Two for each of the five blocks that are held out."""

LARGEST_ANGLE = 90.0
"""Degrees; no segment of constant curvature bends further here."""

_RADIANS = 1 / 20  # of the range of motion: angles that stay below are no degrees
_NORM_TOLERANCE = 0.02
_MOST_OUTSIDE = 0.5
_LARGEST_SHARE = 1.0

_FARTHEST = 1e6
"""Metres that nobody measures with."""

_LENGTH_UNITS = ((200.0, 5000.0, "millimetres"), (25.0, 200.0, "centimetres or inches"))
_LONGEST_RATIO = 3.0
_SHORTEST_RATIO = 0.01


def check_rows(table: Table) -> None:
    """Check that there are enough rows to fit and hold out.

    Raises:
        InputError: fewer than `FEWEST_ROWS`.
    """
    count = len(table.values)
    if count < FEWEST_ROWS:
        raise InputError(
            f"{table.source}: {count} row{'' if count == 1 else 's'} of samples; a recording needs "
            f"{FEWEST_ROWS} or more, so that some can be held out; fewer poses with segment angles "
            "calibrate sensors: `ccgen calibrate`"
        )


def check_time(table: Table, t: Floats) -> None:
    """Check that time is known and runs on, never back.

    Raises:
        InputError: naming the line.
    """
    missing = np.flatnonzero(np.isnan(t))
    if len(missing):
        raise InputError(f"{table.where(int(missing[0]), 't')}: is empty; every row needs its time")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        row = int(back[0]) + 1
        raise InputError(
            f"{table.where(row, 't')}: time runs back from {t[row - 1]:g} to {t[row]:g} s; "
            "sort the rows, or cut the file where the clock was set"
        )
    if len(t) > 1 and t[0] == t[-1]:
        raise InputError(
            f"{table.source}: column t: time stands still at {t[0]:g} s; write seconds that run "
            "on, or leave the column out"
        )


def check_angles(table: Table, u: Floats, v: Floats, range_of_motion: float) -> None:
    """Check segment angles in degrees.

    Args:
        table: where they come from.
        u: shape (N, m), degrees.
        v: shape (N, m), degrees.
        range_of_motion: of a segment and axis, radians.

    Raises:
        InputError: beyond any reach, or radians.
    """
    for axis, angles in (("u", u), ("v", v)):
        wrong = np.argwhere(np.abs(angles) > LARGEST_ANGLE)
        if len(wrong):
            row, segment = (int(x) for x in wrong[0])
            raise InputError(
                f"{table.where(row, f'{axis}{segment}')}: {angles[row, segment]:g} degrees are "
                f"beyond any reach of a segment; write degrees from -{LARGEST_ANGLE:g} to "
                f"{LARGEST_ANGLE:g}"
            )
    largest = _largest(u, v)
    reach = float(np.degrees(range_of_motion))
    if 0 < largest < _RADIANS * reach:
        raise InputError(
            f"{table.source}: columns u0 ... v0 ...: angles of at most {largest:.3g} look like "
            f"radians for a range of motion of {reach:.3g} degrees; write degrees"
        )


def _largest(*values: Floats) -> float:
    finite = np.concatenate([np.abs(v[~np.isnan(v)]) for v in values])
    return float(finite.max()) if len(finite) else 0.0


def check_elongation(table: Table, h: Floats) -> None:
    """Check elongations, shape (N, sections).

    Raises:
        InputError: more than the joint's own length, or less than nothing left of it.
    """
    wrong = np.argwhere(np.abs(h) > _LARGEST_SHARE)
    if len(wrong):
        row, section = (int(x) for x in wrong[0])
        name = "elongation" if "elongation" in table.names else f"h{section}"
        raise InputError(
            f"{table.where(row, name)}: {h[row, section]:g} is no share of the length; "
            "write 0.05 for five per cent"
        )


def check_appears(table: Table, body: str, positions: Mapping[str, Floats]) -> None:
    """Check that a body of the joint file is in the recording.

    Raises:
        InputError: it has no columns, or they are empty.
    """
    if body not in positions:
        near = difflib.get_close_matches(body, list(positions), n=1)
        known = ", ".join(list(positions)[:8]) or "none"
        remedy = f"did you mean {near[0]}?" if near else f"its bodies are: {known}"
        raise InputError(
            f"{table.source}: no columns {body}_x, {body}_y, {body}_z, but [[recordings]] names "
            f"{body}; {remedy}"
        )
    if np.isnan(positions[body]).any(axis=1).all():
        raise InputError(
            f"{table.source}: columns {body}_x, {body}_y, {body}_z: {body} never appears; "
            f"remove {body} from [[recordings]]"
        )


def check_places(table: Table, body: str, positions: Floats) -> None:
    """Check that a body is somewhere, whatever the unit.

    Raises:
        InputError: naming the first place that is none.
    """
    row, axis = np.unravel_index(np.argmax(np.nan_to_num(np.abs(positions))), positions.shape)
    if abs(positions[row, axis]) > _FARTHEST:
        column = f"{body}_{'xyz'[axis]}"
        raise InputError(
            f"{table.where(int(row), column)}: {positions[row, axis]:g} m is no "
            f"place of a body; write metres, and leave the cells empty where {body} was not seen"
        )


def check_quaternions(table: Table, body: str, quaternions: Floats) -> None:
    """Check that quaternions (N, 4) are unit, as far as rounding goes.

    Raises:
        InputError: naming the line.
    """
    norm = np.linalg.norm(quaternions, axis=1)
    wrong = np.flatnonzero(np.abs(norm - 1) > _NORM_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        columns = " ".join(f"{body}_{part}" for part in ORIENTATION)
        raise InputError(
            f"{table.where(row)}, columns {columns}: a quaternion of norm {norm[row]:.3g} is no "
            "orientation; write unit quaternions, and leave the cells empty where there is none"
        )


def check_distances(
    source: str, bodies: Sequence[tuple[str, float | None, Floats]], length: float
) -> None:
    """Check that bodies lie as far apart as their stations, by size.

    Args:
        source: the file.
        bodies: name, station (metres; None for a marker of the base), positions (N, 3).
        length: of the joint, metres.

    Raises:
        InputError: naming two bodies, or one that goes further than any joint could.
    """
    placed = [(name, at, p) for name, at, p in bodies if at is not None]
    for (first, start, p), (second, end, q) in pairwise(placed):
        apart = np.linalg.norm(q - p, axis=1)
        if end - start < length * 1e-3 or np.isnan(apart).all():
            continue
        distance = float(np.nanmedian(apart))
        _check_ratio(
            source, f"{first} and {second} lie {distance:.3g} apart", distance, end - start
        )
    for name, _, p in bodies:
        finite = p[~np.isnan(p).any(axis=1)]
        way = float(
            np.linalg.norm(np.percentile(finite, 95, axis=0) - np.percentile(finite, 5, axis=0))
        )
        if way > 2 * length:
            _check_ratio(source, f"{name} moves by {way:.3g}", way, 2 * length)


def _check_ratio(source: str, what: str, distance: float, expected: float) -> None:
    ratio = distance / expected
    if _SHORTEST_RATIO < ratio < _LONGEST_RATIO:
        return
    unit = next((unit for low, high, unit in _LENGTH_UNITS if low <= ratio < high), None)
    seems = f"they look like {unit}" if unit else "that fits no unit of length"
    raise InputError(
        f"{source}: {what} where the joint file says {expected:.3g} m: {seems}; write metres, "
        "and check stations and geometry.length"
    )


def usable_counts(
    source: str, counts: Floats, sensors: RecordedSensors, bends: bool
) -> tuple[Floats, tuple[str, ...]]:
    """Counts without those that stand at the end of their range, and what to say of them.

    Args:
        source: the file.
        counts: shape (N, n).
        sensors: their ranges.
        bends: whether the recording shows the joint bent; counts of the straight one alone may
            all stand still.

    Raises:
        InputError: most counts of a sensor lie outside its range, no sensor has any, or none
            changes though the joint bends.
    """
    there = ~np.isnan(counts)
    if not there.any():
        raise InputError(f"{source}: every count_... is empty; write raw counts, or no such column")
    beyond = there & ((counts < sensors.lowest) | (counts > sensors.highest))
    ends = there & ((counts <= sensors.lowest) | (counts >= sensors.highest))
    notes, still = [], []
    for j, name in enumerate(sensors.names):
        seen = int(there[:, j].sum())
        if not seen:
            notes.append(f"{source}: sensor {name} has no counts")
        elif beyond[:, j].mean() > _MOST_OUTSIDE * seen / len(counts):
            raise InputError(
                f"{source}: column count_{name}: most counts lie outside "
                f"{sensors.lowest[j]:.0f} ... {sensors.highest[j]:.0f}; correct bits or range of "
                "the transducer"
            )
        elif ends[:, j].any():
            notes.append(
                f"{source}: sensor {name}: {int(ends[:, j].sum())} counts at the end of their range"
            )
        elif bends and _still(counts[:, j]):
            still.append(name)
            notes.append(f"{source}: sensor {name} reads {counts[there[:, j], j][0]:g} throughout")
    if bends and len(still) == int(there.any(axis=0).sum()):
        raise InputError(
            f"{source}: no count ever changes in it; record the counts while the joint bends, or "
            "leave out the columns count_..."
        )
    return np.where(ends, np.nan, counts), tuple(notes)


def _still(counts: Floats) -> bool:
    """Whether a sensor reads the same in enough rows to say so."""
    there = counts[~np.isnan(counts)]
    return len(there) >= FEWEST_ROWS and bool(np.all(there == there[0]))


def check_delay(source: str, delay: float, t: Floats, counts: Floats) -> None:
    """Check that counts are left for the rows of a recording where the sensors lag so much.

    Args:
        source: the file.
        delay: seconds, as the joint file states it.
        t: times of the rows, seconds.
        counts: times of the counts, seconds.

    Raises:
        InputError: fewer rows than a recording needs.
    """
    read_at = t + delay
    there = int(((read_at >= counts[0]) & (read_at <= counts[-1])).sum())
    if there < min(FEWEST_ROWS, len(t)):
        raise InputError(
            f"{source}: delay = {delay:g} leaves {there} of its rows with counts, which run from "
            f"{counts[0]:g} to {counts[-1]:g} s; write the seconds by which the sensors lag, or "
            '"estimate"'
        )


def check_interval(source: str, key: str, interval: tuple[float, float], t: Floats) -> None:
    """Check that an interval of the joint file holds rows of the recording.

    Raises:
        InputError: fewer than five.
    """
    inside = int(((t >= interval[0]) & (t <= interval[1])).sum())
    if inside < 5:
        raise InputError(
            f"{source}: {inside} row{'' if inside == 1 else 's'} within {key} = "
            f"[{interval[0]:g}, {interval[1]:g}]; the recording runs from {t[0]:g} to {t[-1]:g} s"
        )
