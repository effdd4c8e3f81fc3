"""The reference kinematics: closed forms, limits, signs and derivatives."""

import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import expm

from ccgen.kinematics import tip_position, tip_slopes
from ccgen.kinematics import uvh as kin

H = 0.02
RADIUS = 0.05


def angles(shape: tuple[int, ...], largest: float, seed: int = 1) -> tuple[kin.Array, kin.Array]:
    generator = np.random.default_rng(seed)
    return generator.uniform(-largest, largest, shape), generator.uniform(-largest, largest, shape)


def test_straight_pose_is_exact() -> None:
    expected = np.eye(4)
    expected[2, 3] = H
    np.testing.assert_array_equal(kin.segment_transform(0.0, 0.0, H), expected)


@pytest.mark.parametrize("phi", [1e-200, 1e-9, 1e-5, 1e-3, 0.3, 0.999, 1.001, 2.0, math.pi])
def test_transform_is_the_matrix_exponential_of_the_twist(phi: float) -> None:
    u, v = 0.6 * phi, -0.8 * phi
    twist = np.array([[0, 0, v, 0], [0, 0, -u, 0], [-v, u, 0, H], [0, 0, 0, 0]])
    np.testing.assert_allclose(kin.segment_transform(u, v, H), expm(twist), rtol=0, atol=2e-15)


def exact_series(first: int, phi: float) -> float:
    """Sum over k of (-phi^2)^k / (2 k + first)! in rational arithmetic, correctly rounded."""
    square = Fraction(phi) ** 2
    return float(sum((-square) ** k / math.factorial(2 * k + first) for k in range(20)))


@pytest.mark.parametrize("phi", [0.0, 1e-8, 1e-3, 0.1, 0.5, 0.9999, 1.0, 1.0001, 1.5, 3.0])
def test_coefficients_agree_with_exact_series_to_the_last_bits(phi: float) -> None:
    u, v = np.array(phi), np.array(0.0)
    computed = (*kin.sinc(u, v), *kin.remainders(u, v))
    for first, value in enumerate(computed, start=1):
        assert abs(value - exact_series(first, phi)) <= 1.2e-16


def test_chain_is_the_product_of_its_segments_for_every_leading_index() -> None:
    u, v = angles((2, 3, 5), 0.4)
    poses = kin.chain(u, v, H)
    assert poses.shape == (2, 3, 5, 4, 4)
    product = np.eye(4)
    for i in range(5):
        product = product @ kin.segment_transform(u[1, 2, i], v[1, 2, i], H)
        np.testing.assert_allclose(poses[1, 2, i], product, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(kin.tip_pose(u, v, H), poses[..., -1, :, :])


def test_equal_bending_in_one_plane_lies_on_a_circle() -> None:
    m, angle = 24, math.radians(3.0)
    total, length = m * angle, m * H
    tip = kin.tip_pose(np.zeros(m), np.full(m, angle), H)
    np.testing.assert_allclose(
        tip[:3, 3],
        [length * (1 - math.cos(total)) / total, 0.0, length * math.sin(total) / total],
        rtol=0,
        atol=1e-15,
    )


def test_rotations_stay_orthonormal_over_a_long_chain() -> None:
    u, v = angles((50, 64), 0.2)
    rotation = kin.tip_pose(u, v, H)[..., :3, :3]
    gram = rotation @ np.swapaxes(rotation, -1, -2)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), rtol=0, atol=5e-14)


def offset_curve_length(u: kin.Array, v: kin.Array, alpha: float) -> float:
    """Length of the curve at radius RADIUS along a joint, by polygons and Richardson's rule."""

    def polygon(pieces: int) -> float:
        start, total = np.eye(4), 0.0
        for ui, vi in zip(u, v, strict=True):
            t = np.linspace(0.0, 1.0, pieces + 1)
            poses = np.array([kin.segment_transform(ui * s, vi * s, H * s) for s in t])
            poses = start @ poses
            offset = np.array([RADIUS * math.cos(alpha), RADIUS * math.sin(alpha), 0.0, 1.0])
            total += np.linalg.norm(np.diff((poses @ offset)[:, :3], axis=0), axis=1).sum()
            start = poses[-1]
        return total

    coarse, fine = polygon(64), polygon(128)
    return fine + (fine - coarse) / 3


@pytest.mark.parametrize(
    ("u", "v"),
    [
        ([0.3, 0.3, 0.3], [0.0, 0.0, 0.0]),
        ([0.0, 0.0, 0.0], [0.3, 0.3, 0.3]),
        ([-0.2, 0.1, 0.35], [0.15, -0.3, 0.05]),
    ],
)
def test_sensors_measure_the_sum_of_their_axis_with_positive_sign(
    u: list[float], v: list[float]
) -> None:
    straight = len(u) * H
    u_sensor = offset_curve_length(np.array(u), np.array(v), kin.U_SENSOR_ANGLE)
    v_sensor = offset_curve_length(np.array(u), np.array(v), kin.V_SENSOR_ANGLE)
    assert u_sensor - straight == pytest.approx(RADIUS * sum(u), abs=2e-10)
    assert v_sensor - straight == pytest.approx(RADIUS * sum(v), abs=2e-10)


@pytest.mark.parametrize("alpha", [0.0, 0.7, math.pi / 2, 2.5, math.pi, -1.0])
def test_tendon_length_is_the_length_of_the_offset_curve(alpha: float) -> None:
    u, v = np.array([0.3]), np.array([-0.4])
    length = kin.tendon_length(u, v, H, RADIUS, alpha)
    assert length[0] == pytest.approx(offset_curve_length(u, v, alpha), abs=2e-10)


def test_positive_angles_move_the_tip_away_from_their_sensor() -> None:
    assert kin.segment_transform(0.1, 0.0, H)[1, 3] < 0
    assert kin.segment_transform(0.0, 0.1, H)[0, 3] > 0


def differenced_jacobian(u: kin.Array, v: kin.Array, step: float = 1e-3) -> kin.Array:
    """Central differences with Richardson's rule on poses, rotation through dR R^T."""
    m = len(u)
    rotation = kin.tip_pose(u, v, H)[:3, :3]

    def column(index: int, size: float) -> kin.Array:
        q = np.concatenate((u, v))
        q[index] += size
        upper = kin.tip_pose(q[:m], q[m:], H)
        q[index] -= 2 * size
        rate = (upper - kin.tip_pose(q[:m], q[m:], H)) / (2 * size)
        spin = rate[:3, :3] @ rotation.T
        return np.array([*rate[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])

    columns = [(4 * column(i, step / 2) - column(i, step)) / 3 for i in range(2 * m)]
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("largest", [0.0, 1e-4, 0.3, 1.2])
def test_jacobian_is_the_derivative_of_the_tip_pose(largest: float) -> None:
    u, v = angles((2, 6), largest)
    jacobian = kin.tip_jacobian(u, v, H)
    assert jacobian.shape == (2, 6, 12)
    for i in range(2):
        np.testing.assert_allclose(
            jacobian[i], differenced_jacobian(u[i], v[i]), rtol=0, atol=3e-12
        )


def test_the_tip_carried_alone_is_that_of_the_chain() -> None:
    random = np.random.default_rng(5)
    u, v = 0.4 * random.standard_normal((2, 40, 9))
    u[0], v[0] = 0.0, 0.0
    h = random.uniform(0.01, 0.03, (40, 9))
    at = tip_position(u, v, h)
    np.testing.assert_allclose(at, kin.tip_pose(u, v, h)[:, :3, 3], atol=1e-15)
    slopes = tip_slopes(u, v, h)
    jacobian = kin.tip_jacobian(u, v, 0.02)[:, :3]
    alike = tip_slopes(u, v, 0.02)
    np.testing.assert_allclose(np.concatenate([alike.u, alike.v], axis=2), jacobian, atol=1e-14)
    step = 1e-6 * np.eye(9)
    for own, ahead in (
        (slopes.u, lambda i: tip_position(u + step[i], v, h)),
        (slopes.v, lambda i: tip_position(u, v + step[i], h)),
        (slopes.h, lambda i: tip_position(u, v, h + step[i])),
    ):
        for i in (0, 4, 8):
            np.testing.assert_allclose(own[..., i], (ahead(i) - at) / 1e-6, atol=1e-6)
