"""Rotations against SciPy's, and their own special cases."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ccgen.kinematics.rotations import (
    exponential,
    from_quaternions,
    logarithm,
    mean_rotation,
    skew,
    without_twist,
)

RNG = np.random.default_rng(5)
VECTORS = RNG.normal(size=(60, 3)) * np.logspace(-9, 0.3, 60)[:, None]


def test_skew_is_the_cross_product():
    other = RNG.normal(size=(60, 3))
    np.testing.assert_allclose(
        (skew(VECTORS) @ other[..., None])[..., 0], np.cross(VECTORS, other), atol=1e-15
    )


def test_exponential_and_logarithm_are_scipy_s():
    expected = Rotation.from_rotvec(VECTORS)
    np.testing.assert_allclose(exponential(VECTORS), expected.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(logarithm(expected.as_matrix()), expected.as_rotvec(), atol=1e-9)


def test_the_logarithm_of_half_a_turn_turns_by_half_a_turn():
    axes = VECTORS / np.linalg.norm(VECTORS, axis=1, keepdims=True)
    halves = 2 * axes[:, :, None] * axes[:, None, :] - np.eye(3)
    np.testing.assert_allclose(exponential(logarithm(halves)), halves, atol=1e-7)
    np.testing.assert_array_equal(logarithm(np.eye(3)), np.zeros(3))


def test_quaternions_are_x_y_z_w_of_any_norm():
    quaternions = RNG.normal(size=(60, 4))
    expected = Rotation.from_quat(quaternions).as_matrix()
    np.testing.assert_allclose(from_quaternions(quaternions), expected, atol=1e-14)


def test_without_twist_turns_the_shortest_way():
    start, end = (RNG.normal(size=(60, 3)) for _ in range(2))
    start, end = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (start, end))
    rotation = without_twist(start, end)
    np.testing.assert_allclose((rotation @ start[..., None])[..., 0], end, atol=1e-12)
    angle = np.linalg.norm(logarithm(rotation), axis=1)
    np.testing.assert_allclose(np.cos(angle), (start * end).sum(axis=1), atol=1e-9)


@pytest.mark.parametrize("axis", np.eye(3))
def test_opposite_vectors_are_turned_about_any_axis_across(axis):
    rotation = without_twist(axis, -axis)
    np.testing.assert_allclose(rotation @ axis, -axis, atol=1e-12)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)


def test_the_mean_leaves_out_what_is_missing():
    middle = exponential(np.array([0.3, -0.2, 1.0]))
    spread = exponential(np.array([[0.1, 0, 0], [-0.1, 0, 0], [0, 0.2, 0], [0, -0.2, 0]]))
    rotations = np.concatenate([middle @ spread, np.full((1, 3, 3), np.nan)])
    np.testing.assert_allclose(mean_rotation(rotations), middle, atol=1e-12)
    with pytest.raises(ValueError, match="no rotation"):
        mean_rotation(rotations[-1:])
