"""Place of a joint's tip and its derivatives, for many shapes at once.

No pose is made. The tip is carried from frame to frame towards the base: a segment takes a point
(x, y, z) of its distal frame to

    x + v A,   y - u A,   a D + cos(phi) z + h a,     D = u y - v x,   A = b D + a z + h b

with a and b of `ccgen.kinematics.uvh`. Derivatives in a segment's proximal frame follow from these
terms; the rotations before it take them to the base frame.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.kinematics.uvh import remainders, sinc

Array = NDArray[np.float64]


class TipSlopes(NamedTuple):
    """Derivatives of the tip's place, shape (N, 3, m) each."""

    u: Array
    """Metres per radian."""
    v: Array
    """Metres per radian."""
    h: Array
    """Metres per metre of a segment's length."""


def tip_position(u: ArrayLike, v: ArrayLike, h: ArrayLike) -> Array:
    """Place of the tip in the base frame.

    Args:
        u: bending about x, shape (..., m), radians.
        v: bending about y, shape (..., m), radians.
        h: length of a segment, a number or shape (..., m), metres.

    Returns:
        Shape (..., 3), metres.
    """
    u, v, h = (np.asarray(x, dtype=np.float64) for x in np.broadcast_arrays(u, v, h))
    return np.moveaxis(_carried(u, v, h)[0], 0, -1)


def tip_slopes(u: ArrayLike, v: ArrayLike, h: ArrayLike) -> TipSlopes:
    """Derivatives of the tip's place by every bend and length; arguments as of `tip_position`.

    Of shapes (N, m).
    """
    u, v, h = (np.asarray(x, dtype=np.float64) for x in np.broadcast_arrays(u, v, h))
    (a, b), (c, d) = sinc(u, v), remainders(u, v)
    da, db = c - b, 2 * d - c  # da/du = u da, and so on
    _, (x, y, z) = _carried(u, v, h)
    D = u * y - v * x
    A = b * D + a * z + h * b
    same_a, same_b = da * D + h * da - a * z, db * D + da * z + h * db
    by_u = (v * (b * y + u * same_b), -A - u * (b * y + u * same_b), a * y + u * same_a)
    by_v = (A + v * (v * same_b - b * x), -u * (v * same_b - b * x), v * same_a - a * x)
    by_h = (v * b, -u * b, a)
    before = _rotations(u, v, a, b)
    return TipSlopes(*(_turned(before, local) for local in (by_u, by_v, by_h)))


def _carried(u: Array, v: Array, h: Array) -> tuple[Array, Array]:
    """The tip in the base frame, shape (3, ...), and in every segment's distal one, (3, ..., m)."""
    a, b = sinc(u, v)
    cosine = np.cos(np.hypot(u, v))
    seen = np.zeros((3, *u.shape))
    x, y, z = np.zeros((3, *u.shape[:-1]))
    for i in reversed(range(u.shape[-1])):
        seen[..., i] = x, y, z
        ui, vi, ai, bi, hi = (part[..., i] for part in (u, v, a, b, h))
        D = ui * y - vi * x
        A = bi * D + ai * z + hi * bi
        x, y, z = x + vi * A, y - ui * A, ai * D + cosine[..., i] * z + hi * ai
    return np.stack([x, y, z]), seen


def _rotations(u: Array, v: Array, a: Array, b: Array) -> Array:
    """Columns of each segment's proximal frame in the base frame, shape (3 columns, 3, ..., m)."""
    cosine = np.cos(np.hypot(u, v))
    before = np.zeros((3, 3, *u.shape))
    X, Y, Z = (np.broadcast_to(e, (*u.shape[:-1], 3)).T.copy() for e in np.eye(3))
    for i in range(u.shape[-1]):
        before[..., i] = X, Y, Z
        ui, vi, ai, bi = (part[..., i] for part in (u, v, a, b))
        W = vi * X - ui * Y
        X, Y, Z = (
            X - vi * (bi * W + ai * Z),
            Y + ui * (bi * W + ai * Z),
            ai * W + cosine[..., i] * Z,
        )
    return before


def _turned(before: Array, local: tuple[Array, Array, Array]) -> Array:
    """Vectors of the segments' proximal frames in the base frame, shape (N, 3, m)."""
    turned: Array = before[0] * local[0] + before[1] * local[1] + before[2] * local[2]
    return np.moveaxis(turned, 0, 1)
