import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_files import joint_text
from scipy.special import erf

from ccgen.errors import InputError
from ccgen.estimation import (
    Weights,
    direct,
    equal,
    fit_joint,
    fit_weights,
    noise_gain,
    score_percent_rom,
    score_with_noise_percent_rom,
    wam,
)
from ccgen.estimation.folded import folded_mean
from ccgen.joint.file import parse_joint
from ccgen.joint.layouts import end_to_end, heuristic, single
from ccgen.sensing.noise import reading_noise
from ccgen.sensing.readings import reading_matrix, readings
from ccgen.shapes import bent_alike, fit_library, score_library, shape_library

SEGMENTS = 12
ROM = np.radians(3.0)


@pytest.fixture(scope="module")
def fit():
    return shape_library(SEGMENTS, ROM, 30)


@pytest.fixture(scope="module")
def score():
    return shape_library(SEGMENTS, ROM, 10)


def joint(method="wam", noise="noise = 2.0e-5"):
    text = joint_text(transducer=noise, tables=f'[estimator]\nmethod = "{method}"')
    return parse_joint(text, "shoulder.toml")


@st.composite
def placements(draw):
    segments = draw(st.integers(1, 20))
    index = st.integers(0, segments - 1)
    pair = st.tuples(index, index).map(lambda p: (min(p), max(p)))
    return segments, tuple(draw(st.lists(pair, min_size=1, max_size=6)))


@given(placements(), st.integers(0, 2**32 - 1))
def test_a_reading_is_the_mean_angle_of_its_span(placement, seed):
    segments, spans = placement
    angles = np.random.default_rng(seed).uniform(-1, 1, (3, segments))
    expected = np.array([[shape[a : b + 1].mean() for a, b in spans] for shape in angles])
    np.testing.assert_allclose(readings(angles, spans), expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        angles @ reading_matrix(segments, spans).T, expected, rtol=0, atol=1e-14
    )


def test_a_batch_of_placements_reads_as_each_alone(fit):
    batch = np.array([heuristic(SEGMENTS, 3), ((0, 11), (2, 2), (5, 7))])
    together = readings(fit.angles, batch)
    assert together.shape == (120, 2, 3)
    for k, spans in enumerate(batch):
        assert np.array_equal(together[:, k], readings(fit.angles, spans))


@pytest.mark.parametrize("span", [(-1, 3), (5, 4), (3, 12)])
def test_a_span_outside_the_joint_is_named(span):
    message = rf"span \[{span[0]}, {span[1]}\] does not fit; give 0 <= first <= last <= 11"
    with pytest.raises(InputError, match=message):
        readings(np.zeros(12), ((0, 11), span))


def test_direct_gives_each_segment_its_sensors_reading():
    weights = direct(5, ((0, 1), (2, 4)))
    assert weights.estimate([0.1, 0.2]).tolist() == [0.1, 0.1, 0.2, 0.2, 0.2]
    assert not weights.intercept.any()


def test_direct_refuses_overlap_and_names_the_segment_and_the_remedy():
    with pytest.raises(InputError, match=r'segment 3 is covered by sensors 0 and 1.*"equal"'):
        direct(SEGMENTS, heuristic(SEGMENTS, 3))


def test_equal_averages_the_covering_sensors():
    weights = equal(4, ((0, 1), (1, 3), (1, 2)))
    expected = [[1, 0, 0], [1 / 3, 1 / 3, 1 / 3], [0, 0.5, 0.5], [0, 1, 0]]
    assert np.array_equal(weights.matrix, expected)


def test_equal_is_direct_where_nothing_overlaps():
    spans = end_to_end(SEGMENTS, 5)
    assert np.array_equal(equal(SEGMENTS, spans).matrix, direct(SEGMENTS, spans).matrix)


@pytest.mark.parametrize("method", [direct, equal])
def test_an_uncovered_segment_is_named(method):
    with pytest.raises(InputError, match="segment 4 is covered by no sensor"):
        method(6, ((0, 3), (5, 5)))


@pytest.mark.parametrize("method", ["equal", "wam", "noise-aware"])
def test_constant_curvature_within_rounding_or_noise_is_estimated_as_it_is(fit, method):
    spans = heuristic(SEGMENTS, 3)
    weights = fit_weights(method, fit, spans, np.full(3, 1e-6))
    angles = np.full(SEGMENTS, 0.5 * ROM)
    np.testing.assert_allclose(weights.estimate(readings(angles, spans)), angles, rtol=2e-3)


def test_weights_are_immutable_and_checked():
    weights = Weights("wam", ((0, 1),), np.ones((2, 1)), np.zeros(2))
    assert (weights.segments, weights.sensors) == (2, 1)
    with pytest.raises(ValueError, match="read-only"):
        weights.matrix[0, 0] = 2.0
    with pytest.raises(ValueError, match=r"weights of shape \(2, 1\)"):
        Weights("wam", ((0, 1), (0, 0)), np.ones((2, 1)), np.zeros(2))


def test_estimate_adds_the_intercept_over_leading_dimensions():
    weights = Weights("wam", ((0, 1),), np.array([[1.0], [2.0]]), np.array([0.1, 0.2]))
    expected = [[[1.1, 2.2]], [[0.1, 0.2]]]
    np.testing.assert_allclose(weights.estimate([[[1.0]], [[0.0]]]), expected)


def test_scores_of_the_reference_joint(fit, score):
    spans = heuristic(SEGMENTS, 3)
    assert score_percent_rom(direct(SEGMENTS, single(SEGMENTS)), score) == pytest.approx(
        17.465, rel=1e-4
    )
    assert score_percent_rom(direct(SEGMENTS, end_to_end(SEGMENTS, 3)), score) == pytest.approx(
        5.789, rel=1e-4
    )
    assert score_percent_rom(equal(SEGMENTS, spans), score) == pytest.approx(4.430, rel=1e-4)
    assert score_percent_rom(wam(fit, spans), score) == pytest.approx(0.0105, rel=0.01)


def test_score_is_the_mean_absolute_error_over_cases_samples_and_segments(score):
    nothing = Weights("none", single(SEGMENTS), np.zeros((SEGMENTS, 1)), np.zeros(SEGMENTS))
    total = np.abs(score.angles).sum() / (4 * 10 * SEGMENTS * ROM)
    assert score_percent_rom(nothing, score) == pytest.approx(100 * total, rel=1e-14)


@pytest.mark.parametrize("method", ["equal", "wam"])
def test_expected_score_under_noise_agrees_with_sampled_noise(fit, score, method):
    spans = heuristic(SEGMENTS, 4)
    noise = np.array([1.0, 0.5, 2.0, 0.0]) * 1e-3
    weights = fit_weights(method, fit, spans)
    draws = np.random.default_rng(7).standard_normal((20_000, 1, 4)) * noise
    # A coarse subset of the shapes keeps the sample small.
    errors = weights.estimate(readings(score.angles[::5], spans) + draws) - score.angles[::5]
    some = type(score)(score.angles[::5], score.cases[::5], score.amplitudes[::5], ROM)
    expected = score_with_noise_percent_rom(weights, some, noise)
    assert expected == pytest.approx(100 * np.abs(errors).mean() / ROM, rel=0.01)


def test_expected_score_without_noise_is_the_score(fit, score):
    weights = wam(fit, heuristic(SEGMENTS, 3))
    expected = score_with_noise_percent_rom(weights, score, np.zeros(3))
    assert expected == pytest.approx(score_percent_rom(weights, score), rel=1e-14)


def test_expected_score_of_pure_noise_is_that_of_a_half_normal(score):
    weights = direct(SEGMENTS, single(SEGMENTS))
    straight = type(score)(np.zeros((1, SEGMENTS)), ("end-force",), np.zeros(1), ROM)
    expected = 100 * 1e-3 * np.sqrt(2 / np.pi) / ROM
    assert score_with_noise_percent_rom(weights, straight, [1e-3]) == pytest.approx(expected)


@pytest.mark.parametrize("noise", [[1e-3], [1e-3, -1e-3, 0.0], [1e-3, np.nan, 0.0]])
def test_noise_that_is_no_standard_deviation_is_refused(fit, noise):
    weights = equal(SEGMENTS, heuristic(SEGMENTS, 3))
    with pytest.raises(InputError, match="give 3 standard deviations"):
        score_with_noise_percent_rom(weights, fit, noise)


def test_noise_gain_is_the_root_mean_square_of_the_rows_lengths():
    weights = Weights("wam", ((0, 1), (0, 0)), np.array([[3.0, 4.0], [0.0, 1.0]]), np.zeros(2))
    assert noise_gain(weights) == pytest.approx(np.sqrt((25 + 1) / 2))
    assert noise_gain(direct(SEGMENTS, end_to_end(SEGMENTS, 4))) == 1.0


def test_reading_noise_is_the_transducers_over_span_and_radius():
    # Heuristic overlap of 3 on 12 covers 5, 6 and 5 segments.
    expected = 2e-5 / (0.05 * np.array([5, 6, 5]))
    np.testing.assert_allclose(reading_noise(joint(), "u"), expected, rtol=1e-14)
    assert reading_noise(joint(noise=""), "v") is None


@pytest.mark.parametrize("method", ["equal", "wam", "noise-aware"])
def test_fit_joint_uses_the_joints_method_on_both_axes(method):
    described = joint(method)
    weights = fit_joint(described)
    assert set(weights) == {"u", "v"}
    for axis, fitted in weights.items():
        alone = fit_weights(
            method, fit_library(described), fitted.spans, reading_noise(described, axis)
        )
        assert fitted.method == method
        assert fitted.spans == described.axis(axis).spans
        assert np.array_equal(fitted.matrix, alone.matrix)


def test_fit_joint_takes_another_method_and_library():
    described = joint("wam")
    library = score_library(described)
    given_library = fit_joint(described, shapes=bent_alike(library.angles))["u"]
    assert np.array_equal(given_library.matrix, wam(library, given_library.spans).matrix)
    assert fit_joint(described, "equal", bent_alike(library.angles))["v"].method == "equal"


def test_fit_joint_names_file_key_and_axis():
    with pytest.raises(InputError, match=r"^shoulder\.toml: estimator\.method: axis u: segment 3"):
        fit_joint(joint(), "direct")
    with pytest.raises(InputError, match=r"state sensors\.transducer\.noise .* or use \"wam\""):
        fit_joint(joint(noise=""), "noise-aware")


def test_an_unknown_method_is_refused_with_the_known_ones(fit):
    with pytest.raises(InputError, match="unknown method 'magic'; give one of direct, equal, wam"):
        fit_weights("magic", fit, single(SEGMENTS))


def test_the_mean_of_a_folded_normal_variable_is_its_closed_form():
    random = np.random.default_rng(8)
    mean = random.normal(size=2000) * np.exp(random.uniform(-30, 4, 2000))
    deviation = np.exp(random.uniform(-6, 2, 2000))
    ratio = np.abs(mean) / (deviation * np.sqrt(2))
    expected = deviation * np.sqrt(2 / np.pi) * np.exp(-(ratio**2)) + np.abs(mean) * erf(ratio)
    np.testing.assert_allclose(folded_mean(mean, deviation), expected, rtol=3e-14)
    np.testing.assert_array_equal(folded_mean(np.array([-2.0, 0.0]), np.array(0.0)), [2.0, 0.0])
    assert folded_mean(np.array([0.0]), np.array(3.0))[0] == pytest.approx(3 * np.sqrt(2 / np.pi))
