"""Whether a joint moves in a recording, and rests where it is called straight."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.joint.specification import Geometry

Floats = NDArray[np.float64]

_STILL_ANGLE = 1 / 50  # of the range of motion
_STILL_POSITION = 1 / 200  # of the length
_REST_ANGLE = 1 / 10  # of the range of motion
_REST_POSITION = 1 / 100  # of the length


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


def _spread(values: Floats) -> float:
    """The widest of the columns' ranges, without one value in fifty at either end."""
    columns = [c[~np.isnan(c)] for c in values.T]
    return max(
        (float(np.subtract(*np.percentile(c, (98, 2)))) for c in columns if len(c)), default=0.0
    )
