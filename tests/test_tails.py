"""Shapes far out, by subset simulation, on distributions whose tails are known."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import chi2, norm

from ccgen.estimation.consistency.alarms import sharing
from ccgen.estimation.consistency.sound import SoundReadings
from ccgen.estimation.consistency.tails import Visited, with_tails

DRAWS = 2048


def read(points):
    """Two readings, normal, of points in more dimensions than those."""
    return ndtri(points[:, :2]), np.ones(len(points), bool)


def reach(lengths):
    return np.abs(lengths[:, 0])


def explored(rarest, read=read, reach=reach, enough=lambda lengths, weight: False, seed=0):
    points = np.random.default_rng(seed).random((DRAWS, 5))
    lengths, valid = read(points)
    return with_tails(Visited(points[valid], lengths[valid]), read, reach, enough, rarest)


@pytest.mark.parametrize("far", [2.5, 3.5, 4.5])
def test_shares_of_shapes_far_out_are_right(far):
    found = [explored(rarest=1e-6, seed=seed) for seed in range(5)]
    share = np.mean([weight @ (reach(lengths) > far) for lengths, weight in found])
    assert share == pytest.approx(2.0 * norm.sf(far), rel=0.25)


def test_shapes_far_out_on_several_sides_are_all_found():
    lengths, weight = explored(1e-5, reach=lambda lengths: np.square(lengths).sum(axis=1))
    far = np.square(lengths).sum(axis=1) > chi2.isf(1e-4, 2)
    assert weight @ far == pytest.approx(1e-4, rel=0.5)
    quadrants = 2 * (lengths[far, 0] > 0) + (lengths[far, 1] > 0)
    assert set(quadrants) == {0, 1, 2, 3}


def test_weights_are_shares_of_all_shapes():
    lengths, weight = explored(1e-4)
    assert weight.sum() == pytest.approx(1.0)
    assert weight @ np.square(lengths[:, 1]) == pytest.approx(1.0, rel=0.1)


def test_loads_that_give_no_shape_are_not_visited():
    def some(points):
        lengths, _ = read(points)
        return lengths, lengths[:, 0] < 3.0

    lengths, weight = explored(1e-5, read=some)
    assert lengths[:, 0].max() < 3.0
    assert weight @ (lengths[:, 0] < -3.0) == pytest.approx(norm.sf(3.0), rel=0.5)


def test_draws_that_are_enough_stay_alone():
    lengths, weight = explored(1e-6, enough=lambda lengths, weight: True)
    assert len(lengths) == DRAWS
    assert (weight == 1 / DRAWS).all()


def test_the_same_draws_give_the_same_bytes():
    one, other = explored(1e-4), explored(1e-4)
    assert one[0].tobytes() == other[0].tobytes()


def test_one_shape_that_gives_all_alarms_shares_them_with_nobody():
    lengths = np.zeros((100, 2))
    lengths[7] = 30.0
    sound = SoundReadings(lengths, np.ones((100, 2)), np.full(100, 0.01))
    assert sharing(np.eye(2), sound, 1e-4) == pytest.approx(1.0)
    assert sharing(np.eye(2), sound.of(np.arange(2)), 0.5) > 50
