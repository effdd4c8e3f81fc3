"""Poses, Jacobian and tendon lengths of a joint of constant-curvature segments (uvh).

A segment bends by u about the local x axis and by v about the local y axis of its proximal frame,
z runs along the unbent neutral axis, and the neutral axis keeps its length h. Sensors run parallel
to the neutral axis at radius r; alpha counts counter-clockwise from +x, seen against +z:

                    y
                    |
                    o  u-sensor, alpha = 90 deg:   l - h = r u
                    |
       o ---------- z ---------- x                 (z points at the reader)
    v-sensor,       |
    alpha = 180 deg:
    l - h = r v

With u > 0 the tip moves towards -y, away from the u-sensor, with v > 0 towards +x, away from the
v-sensor: a positive angle lengthens its sensor. Equations (1) and (2) of the paper.

The functions below are entire in phi^2 = u^2 + v^2; each is computed without cancellation, so the
straight pose is a point like any other:

    a = sin(phi) / phi               b = (1 - cos(phi)) / phi^2
    c = (1 - a) / phi^2              d = (1/2 - b) / phi^2

Angles are in radians, lengths in metres; leading dimensions broadcast.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

U_SENSOR_ANGLE = math.pi / 2
V_SENSOR_ANGLE = math.pi

_SERIES_LIMIT = 1.0  # of phi^2: beyond, the closed forms of c and d lose less than two bits
_SERIES_TERMS = 10  # the first one left out is below 1e-20


def segment_transform(u: ArrayLike, v: ArrayLike, h: ArrayLike) -> Array:
    """Pose of a segment's distal end in its proximal frame.

    Args:
        u: bending about x, shape (...), radians.
        v: bending about y, shape (...), radians.
        h: length of the neutral axis, a number or shape (...), metres.

    Returns:
        Homogeneous transforms, shape (..., 4, 4), metres.
    """
    u, v = _pair(u, v)
    h = np.asarray(h, dtype=np.float64)
    a, b = sinc(u, v)
    transform = np.zeros((*u.shape, 4, 4))
    transform[..., 0, 0] = 1 - b * v * v
    transform[..., 0, 1] = transform[..., 1, 0] = b * u * v
    transform[..., 1, 1] = 1 - b * u * u
    transform[..., 0, 2] = a * v
    transform[..., 2, 0] = -a * v
    transform[..., 1, 2] = -a * u
    transform[..., 2, 1] = a * u
    transform[..., 2, 2] = np.cos(np.hypot(u, v))
    transform[..., 0, 3] = h * b * v
    transform[..., 1, 3] = -h * b * u
    transform[..., 2, 3] = h * a
    transform[..., 3, 3] = 1
    return transform


def chain(u: ArrayLike, v: ArrayLike, h: ArrayLike) -> Array:
    """Poses of the distal ends of all segments in the base frame.

    Args:
        u: bending about x, shape (..., m), radians.
        v: bending about y, shape (..., m), radians.
        h: length of a segment, a number or shape (..., m), metres.

    Returns:
        Homogeneous transforms, shape (..., m, 4, 4), metres.
    """
    poses = segment_transform(u, v, h)
    for i in range(1, poses.shape[-3]):
        poses[..., i, :, :] = poses[..., i - 1, :, :] @ poses[..., i, :, :]
    return poses


def tip_pose(u: ArrayLike, v: ArrayLike, h: ArrayLike) -> Array:
    """Pose of the joint's tip in the base frame, shape (..., 4, 4); arguments as for `chain`."""
    return chain(u, v, h)[..., -1, :, :]


def tip_jacobian(u: ArrayLike, v: ArrayLike, h: ArrayLike) -> Array:
    """Geometric Jacobian of the tip in the base frame.

    Args:
        u: bending about x, shape (..., m), radians.
        v: bending about y, shape (..., m), radians.
        h: length of a segment, a number or shape (..., m), metres.

    Returns:
        Shape (..., 6, 2m): rows vx, vy, vz (metres per radian), wx, wy, wz (1); columns
        u_0 ... u_{m-1}, v_0 ... v_{m-1}.
    """
    u, v = _pair(u, v)
    poses = chain(u, v, h)
    proximal = _proximal(poses)
    linear, angular = _segment_velocities(u, v, np.asarray(h, dtype=np.float64)[..., None, None])
    angular = proximal @ angular
    lever = (poses[..., -1:, :3, 3] - poses[..., :3, 3])[..., None]
    linear = proximal @ linear + np.cross(angular, lever, axis=-2)
    columns = np.concatenate((linear, angular), axis=-2)  # (..., m, 6, 2)
    return np.moveaxis(columns, -3, -1).reshape(*u.shape[:-1], 6, 2 * u.shape[-1])


def elongation_columns(u: ArrayLike, v: ArrayLike, h: float, sections: Sequence[int]) -> Array:
    """Velocity of the tip for unit rates of the elongation of each section; nothing turns.

    Args:
        u: bending about x, shape (..., m), radians.
        v: bending about y, shape (..., m), radians.
        h: length of a segment at no elongation, metres.
        sections: segments of each section from the base.

    Returns:
        Shape (..., 6, number of sections): rows as of `tip_jacobian`, metres per share of the
        length, wx, wy, wz 0.
    """
    u, v = _pair(u, v)
    a, b = sinc(u, v)
    chord = h * np.stack((b * v, -b * u, a), axis=-1)[..., None]
    linear = (_proximal(chain(u, v, h)) @ chord)[..., 0]  # elongation turns no frame
    starts = np.cumsum([0, *sections[:-1]])
    columns = np.swapaxes(np.add.reduceat(linear, starts, axis=-2), -1, -2)
    return np.concatenate((columns, np.zeros_like(columns)), axis=-2)


def tendon_length(
    u: ArrayLike, v: ArrayLike, h: ArrayLike, radius: ArrayLike, alpha: ArrayLike
) -> Array:
    """Length of a tendon parallel to a segment's neutral axis, exact at any bending angle.

    Args:
        u: bending about x, shape (...), radians.
        v: bending about y, shape (...), radians.
        h: length of the neutral axis, metres.
        radius: distance of the tendon from the neutral axis, metres.
        alpha: the tendon's place, counter-clockwise from +x, radians.

    Returns:
        Lengths, shape (...), metres.
    """
    u, v, h, radius, alpha = (np.asarray(x, dtype=np.float64) for x in (u, v, h, radius, alpha))
    return np.asarray(h + radius * (u * np.sin(alpha) - v * np.cos(alpha)))


def _proximal(poses: Array) -> Array:
    """Rotations of the proximal frames of all segments, shape (..., m, 3, 3)."""
    rotations = np.empty((*poses.shape[:-2], 3, 3))
    rotations[..., 0, :, :] = np.eye(3)
    rotations[..., 1:, :, :] = poses[..., :-1, :3, :3]
    return rotations


def _segment_velocities(u: Array, v: Array, h: Array | float) -> tuple[Array, Array]:
    """Velocities of a segment's distal end for unit rates of u and v, in its proximal frame.

    The angular part is the left Jacobian of the rotation vector (u, v, 0), the linear part
    differentiates h (b v, -b u, a) with da/du = u (c - b) and db/du = u (2 d - c).

    Returns:
        Linear (metres per radian) and angular (1) parts, both shape (..., 3, 2).
    """
    _, b = sinc(u, v)
    c, d = remainders(u, v)
    da, db = c - b, 2 * d - c
    linear = np.empty((*u.shape, 3, 2))
    linear[..., 0, 0] = db * u * v
    linear[..., 1, 0] = -(b + db * u * u)
    linear[..., 2, 0] = da * u
    linear[..., 0, 1] = b + db * v * v
    linear[..., 1, 1] = -db * u * v
    linear[..., 2, 1] = da * v
    angular = np.empty((*u.shape, 3, 2))
    angular[..., 0, 0] = 1 - c * v * v
    angular[..., 1, 0] = angular[..., 0, 1] = c * u * v
    angular[..., 2, 0] = -b * v
    angular[..., 1, 1] = 1 - c * u * u
    angular[..., 2, 1] = b * u
    return h * linear, angular


def _pair(u: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
    first, second = np.broadcast_arrays(
        np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
    )
    return first, second


def sinc(u: Array, v: Array) -> tuple[Array, Array]:
    """The functions a and b; the half angle keeps b = sinc(phi / 2)^2 / 2 from cancelling."""
    phi = np.hypot(u, v)
    return np.sinc(phi / np.pi), np.sinc(phi / (2 * np.pi)) ** 2 / 2


def remainders(u: Array, v: Array) -> tuple[Array, Array]:
    """The functions c and d: series for small angles, closed forms beyond."""
    a, b = sinc(u, v)
    square = u * u + v * v
    small = square < _SERIES_LIMIT
    divisor = np.where(small, 1.0, square)
    return (
        np.where(small, _series(3, square), (1 - a) / divisor),
        np.where(small, _series(4, square), (0.5 - b) / divisor),
    )


def _series(first: int, square: Array) -> Array:
    """Sum over k of (-square)^k / (2 k + first)!, for square below `_SERIES_LIMIT`."""
    square = np.minimum(square, _SERIES_LIMIT)
    total = np.zeros_like(square)
    for k in reversed(range(_SERIES_TERMS)):
        total = 1 / math.factorial(2 * k + first) - square * total
    return total
