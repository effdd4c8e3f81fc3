"""Poses at places along a joint: against the chain of segments, and their derivatives."""

import numpy as np
import pytest

from ccgen.kinematics import chain
from ccgen.kinematics.rotations import logarithm
from ccgen.kinematics.stations import places, seen_from_base

SECTIONS, M, LENGTH = (3, 2), 5, 0.02
AT = [0.0, 0.013, 0.04, 0.0405, 0.1, 0.085]


def states(count=6, twist=0.3):
    x = 0.3 * np.random.default_rng(0).standard_normal((count, 2 * M + 3))
    x[:, -3:-1] *= 0.2
    x[:, -1] *= twist
    return x


def test_at_borders_of_segments_they_are_the_chain_s():
    x = states(twist=0.0)
    h = LENGTH * (1 + np.repeat(x[:, 2 * M : -1], SECTIONS, axis=1))
    poses = chain(x[:, :M], x[:, M : 2 * M], h)
    seen = seen_from_base(x, places(AT, SECTIONS, LENGTH))
    for place, segment in ((2, 1), (4, 4)):
        np.testing.assert_allclose(seen.position[:, place], poses[:, segment, :3, 3], atol=1e-15)
        np.testing.assert_allclose(seen.rotation[:, place], poses[:, segment, :3, :3], atol=1e-14)
    assert not seen.position[:, 0].any()
    np.testing.assert_array_equal(seen.rotation[0, 0], np.eye(3))


def test_within_a_segment_curvature_is_constant():
    x = np.zeros((1, 2 * M + 3))
    x[:, :M] = 0.2
    seen = seen_from_base(x, places([0.033], SECTIONS, LENGTH))
    bend = 0.2 * 0.033 / LENGTH
    radius = LENGTH / 0.2
    expected = [0.0, -radius * (1 - np.cos(bend)), radius * np.sin(bend)]
    np.testing.assert_allclose(seen.position[0, 0], expected, atol=1e-15)


@pytest.mark.parametrize("number", range(2 * M + 3))
def test_derivatives_are_those_of_the_poses(number):
    x, where = states(), places(AT, SECTIONS, LENGTH)
    step = np.zeros(x.shape[1])
    step[number] = 1e-6
    seen, high, low = (seen_from_base(x + s * step, where) for s in (0, 1, -1))
    np.testing.assert_allclose(
        seen.linear[..., number], (high.position - low.position) / 2e-6, atol=1e-9
    )
    turned = logarithm(high.rotation @ np.swapaxes(low.rotation, -1, -2)) / 2e-6
    np.testing.assert_allclose(seen.angular[..., number], turned, atol=1e-9)
