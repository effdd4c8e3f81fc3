import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from ccgen.errors import InputError
from ccgen.estimation import score_percent_rom, wam, wam_matrix, wam_objective, wam_paper_call
from ccgen.estimation.soft_l1 import minimise, soft_l1
from ccgen.estimation.wam import F_SCALE
from ccgen.joint.layouts import end_to_end, heuristic
from ccgen.shapes import ShapeLibrary, shape_library

EPS = np.finfo(float).eps


def library(segments, degrees):
    return shape_library(segments, np.radians(degrees), 30)


@pytest.fixture(scope="module")
def reference():
    return library(12, 3.0)


def span_means(angles, spans):
    return np.stack([angles[:, a : b + 1].mean(axis=1) for a, b in spans], axis=1)


def tight_least_squares(readings, target, start):
    """SciPy's own minimum: tolerances at its limit and the problem scaled up to meet them."""
    scale = 1.0 / np.abs(target).max()
    return least_squares(
        lambda w: scale * (readings @ w - target),
        start,
        jac=lambda w: scale * readings,
        loss="soft_l1",
        f_scale=scale * F_SCALE,
        x_scale="jac",
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
    ).x


def excess(readings, target, ours, starts):
    """How far our objective lies above SciPy's best, in margins of rounding (at most 1 is none)."""

    def loss(weights):
        return soft_l1(readings @ weights - target, F_SCALE)

    theirs = [tight_least_squares(readings, target, start) for start in starts]
    best = min(theirs, key=loss)
    terms = np.abs(readings) @ np.abs(best) + np.abs(target)
    margin = 1e-12 * loss(best) + 2 * EPS * np.abs(readings @ best - target) @ terms
    return (loss(ours) - loss(best)) / (margin + 1e-30)


@pytest.mark.parametrize(
    ("segments", "degrees", "spans"),
    [
        (12, 3.0, heuristic(12, 2)),
        (12, 3.0, heuristic(12, 3)),
        (12, 3.0, heuristic(12, 5)),
        (12, 3.0, end_to_end(12, 4)),
        (12, 3.0, ((0, 7), (4, 11))),
        (20, 6.0, heuristic(20, 3)),
        (48, 1.0, heuristic(48, 6)),
    ],
)
def test_objective_is_never_above_tightly_solved_least_squares(segments, degrees, spans):
    angles = library(segments, degrees).angles
    readings = span_means(angles, spans)
    matrix = wam_matrix(angles, spans)
    random = np.random.default_rng(segments)
    for i in range(0, segments, 5):
        linear = np.linalg.lstsq(readings, angles[:, i], rcond=None)[0]
        starts = [np.ones(len(spans)), linear, random.normal(size=len(spans))]
        assert excess(readings, angles[:, i], matrix[i], starts) <= 1.0


@pytest.mark.parametrize("where", ["targets", "readings"])
@pytest.mark.parametrize("size", [0.3, 3.0, 30.0])
def test_objective_is_never_above_least_squares_among_gross_outliers(reference, where, size):
    random = np.random.default_rng(3)
    angles, spans = reference.angles.copy(), heuristic(12, 3)
    readings = span_means(angles, spans)
    spoilt = angles if where == "targets" else readings
    hits = random.random(spoilt.shape) < 0.08
    spoilt[hits] += size * random.standard_cauchy(hits.sum())
    matrix = minimise(readings, angles, F_SCALE)
    for i in range(0, 12, 3):
        linear = np.linalg.lstsq(readings, angles[:, i], rcond=None)[0]
        starts = [np.ones(3), linear, np.zeros(3)]
        assert excess(readings, angles[:, i], matrix[i], starts) <= 1.0


def test_outliers_move_the_weights_far_less_than_in_least_squares(reference):
    random = np.random.default_rng(5)
    angles, spans = reference.angles, heuristic(12, 3)
    readings = span_means(angles, spans)
    spoilt = angles.copy()
    spoilt[random.integers(0, len(angles), 6)] += 20.0
    clean = readings @ minimise(readings, angles, F_SCALE).T
    robust = readings @ minimise(readings, spoilt, F_SCALE).T
    linear = readings @ np.linalg.lstsq(readings, spoilt, rcond=None)[0]
    assert np.abs(robust - clean).max() < 0.05 * np.abs(linear - clean).max()


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    sensors=st.integers(1, 6),
    spread=st.floats(0, 4),
    tail=st.floats(1.0, 10.0),
)
def test_the_gradient_vanishes_at_the_minimum(seed, sensors, spread, tail):
    random = np.random.default_rng(seed)
    readings = random.normal(size=(60, sensors)) * np.logspace(0, -spread, sensors)
    targets = readings @ random.normal(size=(sensors, 4)) + random.standard_t(tail, (60, 4))
    residuals = readings @ minimise(readings, targets, F_SCALE).T - targets
    pull = residuals / np.sqrt(1 + (residuals / F_SCALE) ** 2)
    gradient = (readings / np.linalg.norm(readings, axis=0)).T @ pull
    assert np.abs(gradient).max() < 1e-6 * np.linalg.norm(pull)


def test_objective_has_the_value_of_least_squares_cost(reference):
    spans = heuristic(12, 2)
    readings = span_means(reference.angles, spans)
    matrix = np.full((12, 2), 3.0)
    objective = wam_objective(matrix, reference.angles, spans)
    for target, row, ours in zip(reference.angles.T, matrix, objective, strict=True):
        once = least_squares(
            lambda w, target=target: readings @ w - target,
            row,
            loss="soft_l1",
            f_scale=F_SCALE,
            max_nfev=1,
        )
        assert once.cost == pytest.approx(ours, rel=1e-12)


def test_the_loss_is_quadratic_for_small_and_linear_for_large_residuals():
    assert soft_l1(np.array([1e-9]), F_SCALE) == pytest.approx(0.5e-18, rel=1e-12)
    assert soft_l1(np.array([1e6]), F_SCALE) == pytest.approx(F_SCALE * 1e6, rel=1e-6)


def test_angles_that_are_combinations_of_the_readings_are_fitted_to_rounding():
    # Three shape functions, three sensors: the weights are determined and exact.
    s = (np.arange(12) + 0.5) / 12
    basis = np.stack([np.ones(12), 1 - s, (1 - s) ** 2])
    mixture = np.random.default_rng(2).normal(size=(40, 3)) @ basis
    simple = ShapeLibrary(mixture, ("synthetic",) * 40, mixture[:, 0], 1.0)
    spans = heuristic(12, 3)
    assert score_percent_rom(wam(simple, spans), simple) < 1e-12


def test_directions_that_the_shapes_do_not_show_get_no_weight(reference):
    # The same span twice: the minimum of smallest norm shares the weight evenly.
    once = wam_matrix(reference.angles, ((0, 6), (5, 11)))
    twice = wam_matrix(reference.angles, ((0, 6), (0, 6), (5, 11)))
    np.testing.assert_allclose(twice[:, 0], twice[:, 1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(twice[:, 0] + twice[:, 1], once[:, 0], rtol=0, atol=1e-9)


def test_a_library_without_bending_gives_zero_weights():
    assert not wam_matrix(np.zeros((8, 5)), ((0, 2), (2, 4))).any()


def test_fewer_shapes_than_sensors_are_fitted_exactly():
    angles = np.random.default_rng(4).normal(size=(2, 6))
    spans = ((0, 1), (2, 3), (4, 5))
    few = ShapeLibrary(angles, ("a", "b"), angles[:, 0], 1.0)
    assert score_percent_rom(wam(few, spans), few) < 1e-12


def test_a_batch_of_placements_is_fitted_as_each_alone(reference):
    random = np.random.default_rng(6)
    batch = np.sort(random.integers(0, 12, (150, 3, 2)), axis=-1)
    together = wam_matrix(reference.angles, batch)
    assert together.shape == (150, 12, 3)
    for k in range(0, 150, 10):
        alone = wam_matrix(reference.angles, batch[k])
        for matrix in (together[k], alone):
            assert np.isfinite(matrix).all()
        ours, single = (
            wam_objective(w, reference.angles, [tuple(s) for s in batch[k]])
            for w in (together[k], alone)
        )
        np.testing.assert_allclose(ours, single, rtol=1e-11, atol=1e-26)


def test_a_fit_that_does_not_settle_is_an_error_not_a_wrong_answer(reference, monkeypatch):
    monkeypatch.setattr("ccgen.estimation.soft_l1.MAX_STEPS", 1)
    targets = reference.angles.copy()
    targets[::7] += 5.0
    with pytest.raises(InputError, match="did not settle in 1 steps; remove the gross outliers"):
        minimise(reference.angles[:, :3], targets, F_SCALE)


def test_the_papers_call_stays_short_of_the_minimum_near_the_papers_row(reference):
    score = shape_library(12, np.radians(3.0), 10)
    # Medians over the paper's 80 joints (Table 2); a single joint lies within a factor of two.
    for sensors, paper in ((2, 1.552), (3, 0.262), (4, 0.0915), (5, 0.0434), (6, 0.0366)):
        spans = heuristic(12, sensors)
        theirs = wam_paper_call(reference, spans)
        assert theirs.method == "wam-paper-call"
        assert paper / 2 < score_percent_rom(theirs, score) < paper * 2
        minimum = wam(reference, spans)
        ours, stopped = (
            wam_objective(w.matrix, reference.angles, spans).sum() for w in (minimum, theirs)
        )
        assert ours < stopped


def test_the_papers_call_depends_on_the_radius_as_its_tolerances_are_absolute(reference):
    spans = heuristic(12, 3)
    score = shape_library(12, np.radians(3.0), 10)
    near = score_percent_rom(wam_paper_call(reference, spans, radius=0.004), score)
    far = score_percent_rom(wam_paper_call(reference, spans, radius=0.4), score)
    assert far < near / 10
