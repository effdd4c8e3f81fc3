from itertools import pairwise

import numpy as np
import pytest

from ccgen.estimation import noise_aware, score_percent_rom, score_with_noise_percent_rom, wam
from ccgen.joint.layouts import heuristic
from ccgen.placement import Problem
from ccgen.placement.bound import lower_bound
from ccgen.placement.certificate import Certificate
from ccgen.placement.objective import distinct_shapes, orthonormalise
from ccgen.placement.problem import as_spans
from ccgen.sensing.readings import readings
from ccgen.shapes import shape_library


def problem(segments, degrees, sensors, noise=0.0):
    rom = np.radians(degrees)
    fit, score = shape_library(segments, rom, 30), shape_library(segments, rom, 10)
    return Problem(fit, score, sensors, noise=noise)


def random_placements(segments, sensors, count, seed=1):
    random = np.random.default_rng(seed)
    return np.sort(random.integers(segments, size=(count, sensors, 2)), axis=-1)


def least_squares_percent(posed, spans):
    read = readings(posed.fit.angles, spans)
    matrix = np.linalg.lstsq(read, posed.fit.angles, rcond=1e-14)[0]
    errors = readings(posed.score.angles, spans) @ matrix - posed.score.angles
    return 100 * np.abs(errors).mean() / posed.score.range_of_motion


@pytest.mark.parametrize(("segments", "degrees"), [(12, 3.0), (20, 8.0), (48, 8.0), (48, 1.0)])
@pytest.mark.parametrize("sensors", [1, 2, 3, 4, 6])
def test_value_is_the_least_squares_score(segments, degrees, sensors):
    posed = problem(segments, degrees, sensors)
    spans = random_placements(segments, sensors, 40)
    expected = [least_squares_percent(posed, as_spans(one)) for one in spans]
    np.testing.assert_allclose(posed.model.values(spans), expected, rtol=2e-4, atol=1e-9)


@pytest.mark.parametrize("sensors", [3, 4, 5, 6])
def test_value_is_the_wam_score_where_residuals_are_small(sensors):
    posed = problem(12, 3.0, sensors)
    spans = heuristic(12, sensors)
    expected = score_percent_rom(wam(posed.fit, spans), posed.score)
    assert posed.model.values(np.array([spans]))[0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("sensors", [2, 4, 6])
def test_value_under_noise_is_the_expected_score_of_noise_aware_weights(sensors):
    noise = 4e-4
    posed = problem(16, 5.0, sensors, noise)
    spans = random_placements(16, sensors, 20)
    expected = []
    for one in map(as_spans, spans):
        sigma = [noise / (b - a + 1) for a, b in one]
        weights = noise_aware(posed.fit, one, sigma)
        expected.append(score_with_noise_percent_rom(weights, posed.score, sigma))
    np.testing.assert_allclose(posed.model.values(spans), expected, rtol=1e-9)
    np.testing.assert_allclose(posed.percents(spans), expected, rtol=1e-12)


def test_a_sensor_laid_twice_adds_nothing():
    posed = problem(12, 3.0, 3)
    twice = np.array([[[0, 8], [0, 8], [6, 11]]])
    once = np.array([[[0, 8], [6, 11]]])
    assert posed.model.values(twice)[0] == pytest.approx(posed.model.values(once)[0], rel=1e-12)


@pytest.mark.parametrize("noise", [0.0, 4e-4])
@pytest.mark.parametrize("slot", [0, 2, 3])
def test_moved_values_are_the_values_of_the_moved_placements(slot, noise):
    posed = problem(16, 4.0, 4, noise)
    placement = np.array(heuristic(16, 4))
    others = np.delete(placement, slot, axis=0)
    moved = np.repeat(placement[None], len(posed.catalogue), axis=0)
    moved[:, slot] = posed.catalogue
    values = posed.model.moved_values(others, posed.catalogue, slot)
    np.testing.assert_allclose(values, posed.model.values(moved), rtol=1e-6)


@pytest.mark.parametrize(("segments", "degrees"), [(12, 1.0), (20, 8.0), (40, 8.0), (48, 8.0)])
@pytest.mark.parametrize("sensors", [2, 3])
def test_certificate_bounds_the_soft_l1_value_from_below_and_near(segments, degrees, sensors):
    posed = problem(segments, degrees, sensors)
    spans = np.concatenate(
        [random_placements(segments, sensors, 60), [heuristic(segments, sensors)]]
    )
    true, bounds = posed.percents(spans), Certificate(posed).lower_bounds(spans)
    assert (bounds <= true * (1 + 1e-9)).all()
    if segments < 40:
        assert bounds[-1] > 0.9 * true[-1]


@pytest.mark.parametrize(("segments", "degrees"), [(12, 3.0), (24, 8.0)])
@pytest.mark.parametrize("sensors", [1, 2, 3, 5])
def test_no_placement_gets_below_the_lower_bound(segments, degrees, sensors):
    posed = problem(segments, degrees, sensors)
    floor = lower_bound(posed.model, sensors)
    spans = random_placements(segments, sensors, 2000)
    assert 0 < floor < posed.model.values(spans).min()


def test_lower_bound_holds_for_the_best_linear_subspace_too():
    posed = problem(12, 3.0, 2)
    scored = posed.score.angles
    _, _, right = np.linalg.svd(scored)
    for rank in (1, 2, 3):
        errors = scored - scored @ right[:rank].T @ right[:rank]
        percent = 100 * np.abs(errors).mean() / posed.score.range_of_motion
        assert lower_bound(posed.model, rank) <= percent


def test_distinct_shapes_keep_the_sum_of_absolute_values_of_any_linear_map():
    score = shape_library(12, np.radians(4.0), 10)
    shapes, counts = distinct_shapes(score.angles, scalable=True)
    row = np.random.default_rng(3).normal(size=12)
    assert len(shapes) == 16
    assert counts @ np.abs(shapes @ row) == pytest.approx(np.abs(score.angles @ row).sum())


def test_mirrored_shapes_alone_are_merged_where_noise_does_not_scale():
    score = shape_library(12, np.radians(4.0), 10)
    shapes, counts = distinct_shapes(score.angles, scalable=False)
    assert len(shapes) == 1 + 4 * 5
    assert counts.sum() == 40
    assert all((a != b).any() for a, b in pairwise(shapes))


def test_orthonormal_readings_stay_orthogonal_where_readings_are_nearly_dependent():
    posed = problem(12, 1.0, 6)
    spans = random_placements(12, 6, 50)
    vectors = posed.model.vectors(spans, np.arange(6), 6)
    orthonormalise(vectors, posed.model.rank)
    head = vectors[..., : posed.model.rank]
    products = head @ np.swapaxes(head, 1, 2)
    off = products - np.eye(6) * np.diagonal(products, axis1=1, axis2=2)[..., None, :]
    assert np.abs(off).max() < 1e-13
