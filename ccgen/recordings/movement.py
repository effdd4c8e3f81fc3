"""Whether a joint moves in a recording, and rests where it is called straight."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.joint.specification import Geometry, Joint

Floats = NDArray[np.float64]

_STILL_ANGLE = 1 / 50  # of the range of motion
_STILL_POSITION = 1 / 200  # of the length
_REST_ANGLE = 1 / 10  # of the range of motion
_REST_POSITION = 1 / 100  # of the length

_PARTS, _FEWEST = 20, 5
"""Parts of a time in which sensors rest, and rows of one."""
_NOISE = 5.0
"""Times the median step from row to row, which is as large as a standard deviation of noise."""


def check_motion(
    source: str,
    angles: Sequence[Floats | None],
    positions: Sequence[Floats],
    length: float,
    range_of_motion: float,
) -> None:
    """Check that the joint moves.

    Args:
        source: the file.
        angles: of both axes, shape (N, m), radians; None without.
        positions: of bodies, shape (N, 3), metres.
        length: of the joint, metres.
        range_of_motion: radians.

    Raises:
        InputError: angles change by less than a fiftieth of the range of motion, and bodies by
            less than a two-hundredth of the length.
    """
    turned = max((_spread(a) for a in angles if a is not None), default=0.0)
    moved = max((_spread(p) for p in positions), default=0.0)
    if turned < _STILL_ANGLE * range_of_motion and moved < _STILL_POSITION * length:
        raise InputError(
            f"{source}: the joint does not move in it (by {moved:.2g} m and "
            f"{np.degrees(turned):.2g} degrees); record it while it bends"
        )


def check_rest(
    source: str,
    interval: tuple[float, float],
    bends: Floats,
    positions: Sequence[Floats],
    geometry: Geometry,
) -> None:
    """Check that the joint rests while it is called straight.

    Args:
        source: the file.
        interval: when that is, seconds.
        bends: of segments in that time, shape (rows, k), radians.
        positions: of bodies in that time, shape (rows, 3), metres.
        geometry: of the joint.

    Raises:
        InputError: by how much it moves.
    """
    turned, moved = _spread(bends), max((_spread(p) for p in positions), default=0.0)
    if turned > _REST_ANGLE * geometry.range_of_motion or moved > _REST_POSITION * geometry.length:
        what = f"{moved:.2g} m" if len(positions) else f"{np.degrees(turned):.2g} degrees"
        raise InputError(
            f"{source}: straight = [{interval[0]:g}, {interval[1]:g}]: the joint moves by {what} "
            "in that time; name a time in which it rests"
        )


def check_resting_sensors(
    source: str, interval: tuple[float, float], lengths: Floats, joint: Joint
) -> None:
    """Check by the sensors that the joint rests while it is called straight.

    Args:
        source: the file.
        interval: when that is, seconds.
        lengths: in that time, shape (rows, n), metres; NaN for no reading.
        joint: its sensors.

    Raises:
        InputError: which sensor moves most, and by how much.
    """
    rest = _REST_ANGLE * joint.geometry.range_of_motion
    found = [
        (_drift(column) / (rest * sensor.radius * sensor.segments), sensor.name, _drift(column))
        for sensor, column in zip(joint.sensors, lengths.T, strict=True)
    ]
    share, name, drift = max(found)
    if share > 1.0:
        raise InputError(
            f"{source}: straight = [{interval[0]:g}, {interval[1]:g}]: sensor {name} moves by "
            f"{drift:.2g} m in that time; name a time in which the joint rests"
        )


def _drift(lengths: Floats) -> float:
    """By how much a reading moves beyond its noise: between medians of parts of the time."""
    seen = lengths[~np.isnan(lengths)]
    parts = min(_PARTS, len(seen) // _FEWEST)
    if parts < 2:
        return 0.0
    medians = [float(np.median(part)) for part in np.array_split(seen, parts)]
    noise = float(np.median(np.abs(np.diff(seen))))
    jitter = _NOISE * noise / float(np.sqrt(len(seen) / parts))
    return max(max(medians) - min(medians) - jitter, 0.0)


def _spread(values: Floats) -> float:
    """The widest of the columns' ranges, without one value in fifty at either end."""
    columns = [c[~np.isnan(c)] for c in values.T]
    return max(
        (float(np.subtract(*np.percentile(c, (98, 2)))) for c in columns if len(c)), default=0.0
    )
