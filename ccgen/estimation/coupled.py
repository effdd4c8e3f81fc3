"""The two methods that need no fit, where a sensor may read several axes at once.

"direct" and "equal" take, for each segment, the readings of the sensors that cover it, as if it did
the same over their spans: the one solution that there is, or that of least squares.
"""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.double_double import least_squares
from ccgen.errors import InputError
from ccgen.estimation.weights import Floats
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.readings import coverage, direction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ccgen.joint import Joint, Sensor


def spans_of(sensors: "Sequence[Sensor]") -> AnySpans:
    """First and last segments of sensors; numbers with fractions where they cover parts of them."""
    return tuple(
        (int(s.start), int(s.end) - 1)
        if s.start.is_integer() and s.end.is_integer()
        else (s.start, s.end - 1.0)
        for s in sensors
    )


def local(joint: "Joint", axis: str, method: str) -> Floats:
    """Weights, shape (rows, n), from the sensors that cover each segment.

    Args:
        joint: its sensors.
        axis: "u", "v" or "h".
        method: "direct", where exactly as many sensors cover a segment as tell its unknowns, or
            "equal".

    Raises:
        InputError: a segment whose sensors have no one solution, by "direct".
    """
    unknown = _unknown(joint, axis)
    columns, scale = _columns(joint, axis, unknown)
    covered = coverage(joint)[joint.own(axis)] > 0
    rows = np.zeros((joint.geometry.segments, len(columns)))
    for i, over in enumerate(covered.T):
        if method == "direct":
            _check_direct(i, columns[over], unknown)
        solved = least_squares(columns[over], np.eye(int(over.sum()))) * scale[:, None]
        rows[i, over] = solved[unknown.index(axis)]
    if axis != "h":
        return rows
    ends = np.cumsum(joint.geometry.sections)
    return np.array([part.mean(axis=0) for part in np.split(rows, ends[:-1])])


def _check_direct(segment: int, columns: Floats, unknown: "Sequence[str]") -> None:
    """Check that the sensors over a segment have one solution, without one too many."""
    count = len(unknown)
    if len(columns) != count or np.linalg.matrix_rank(columns) < count:
        raise InputError(
            f"segment {segment} is covered by {len(columns)} sensors, which must be {count} that "
            f'tell {", ".join(unknown)} from each other; use the method "equal"'
        )


def _unknown(joint: "Joint", axis: str) -> list[str]:
    """What the sensors that an axis reads may tell of a segment."""
    if not joint.couples:
        return [axis]
    elongates = joint.geometry.elongation is not None
    return [one for one in ("u", "v", "h") if one in joint.axes or (one == "h" and elongates)]


def _columns(joint: "Joint", axis: str, unknown: "Sequence[str]") -> tuple[Floats, Floats]:
    """Normalised readings of what is unknown at its largest, shape (n, k), and those sizes, (k,).

    Where readings do not determine the unknown, the solution that is smallest beside these is
    taken.
    """
    geometry = joint.geometry
    largest = max(map(abs, geometry.elongation), default=1.0) if geometry.elongation else 1.0
    sizes = {"u": geometry.range_of_motion, "v": geometry.range_of_motion, "h": largest}
    parts = []
    for sensor in joint.sensors[joint.own(axis)]:
        sine, cosine = direction(sensor)
        parts.append({"u": sine, "v": -cosine, "h": geometry.segment_length / sensor.radius})
    scale = np.array([sizes[one] for one in unknown])
    return np.array([[part[one] for one in unknown] for part in parts]) * scale, scale
