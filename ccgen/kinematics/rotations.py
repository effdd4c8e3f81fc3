"""Rotations as matrices, rotation vectors and quaternions; leading dimensions broadcast."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def skew(vector: Floats) -> Floats:
    """The matrices K of shape (..., 3, 3) with K w = vector x w; `vector` is (..., 3)."""
    matrix = np.zeros((*vector.shape, 3))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    matrix[..., 0, 1], matrix[..., 0, 2] = -z, y
    matrix[..., 1, 0], matrix[..., 1, 2] = z, -x
    matrix[..., 2, 0], matrix[..., 2, 1] = -y, x
    return matrix


def exponential(vector: Floats) -> Floats:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3), radians."""
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    K = skew(vector)
    a, b = np.sinc(angle / np.pi), np.sinc(angle / (2 * np.pi)) ** 2 / 2
    return np.asarray(np.eye(3) + a * K + b * (K @ K))


def logarithm(rotation: Floats) -> Floats:
    """Rotation vectors (..., 3) of matrices (..., 3, 3), radians, up to half a turn."""
    axis = np.stack(
        (
            rotation[..., 2, 1] - rotation[..., 1, 2],
            rotation[..., 0, 2] - rotation[..., 2, 0],
            rotation[..., 1, 0] - rotation[..., 0, 1],
        ),
        axis=-1,
    )
    sine = np.linalg.norm(axis, axis=-1) / 2
    cosine = (np.trace(rotation, axis1=-2, axis2=-1) - 1) / 2
    angle = np.arctan2(sine, cosine)
    # Near half a turn the axis stands in the symmetric part; the sign of it does not matter there.
    safe = np.where(sine > 1e-6, sine, 1.0)
    scale = np.where(sine > 1e-6, angle / (2 * safe), 0.5)
    vector = axis * scale[..., None]
    half = (cosine < 0) & (sine <= 1e-6)
    if half.any():
        vector[half] = np.pi * _half_turn_axis(rotation[half])
    return np.asarray(vector)


def _half_turn_axis(rotation: Floats) -> Floats:
    outer = (rotation + np.eye(3)) / 2
    column = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    axis = np.take_along_axis(outer, column[:, None, None], axis=-1)[..., 0]
    return np.asarray(axis / np.linalg.norm(axis, axis=-1, keepdims=True))


def from_quaternions(quaternion: Floats) -> Floats:
    """Rotation matrices (..., 3, 3) of quaternions x, y, z, w of shape (..., 4), of any norm."""
    x, y, z, w = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=-1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=-1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )


def without_twist(start: Floats, end: Floats) -> Floats:
    """The rotations (..., 3, 3) that take one unit vector to another the shortest way.

    Opposite vectors have no shortest way; half a turn about an axis across serves there.
    """
    start, end = np.broadcast_arrays(start, end)
    cosine = (start * end).sum(axis=-1)
    K = skew(np.cross(start, end))
    opposite = cosine < -1 + 1e-12
    rotation = np.eye(3) + K + K @ K / np.where(opposite, 1.0, 1 + cosine)[..., None, None]
    if opposite.any():
        rotation[opposite] = exponential(np.pi * _across(start[opposite]))
    return np.asarray(rotation)


def _across(vector: Floats) -> Floats:
    """Unit vectors at a right angle to those of shape (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vector), axis=-1)]
    across = np.cross(vector, least)
    return np.asarray(across / np.linalg.norm(across, axis=-1, keepdims=True))


def mean_rotation(rotation: Floats) -> Floats:
    """The rotation (3, 3) nearest to the mean of matrices (N, 3, 3), NaN left out.

    Raises:
        ValueError: no rotation to take the mean of.
    """
    there = rotation[~np.isnan(rotation).any(axis=(-2, -1))]
    if not len(there):
        raise ValueError("no rotation to take the mean of")
    U, _, V = np.linalg.svd(there.mean(axis=0))
    return np.asarray(U @ np.diag([1, 1, np.linalg.det(U @ V)]) @ V)
