"""Weights of sensors that read several axes at once: formulas, symmetries, and the paper's sets."""

import math
from dataclasses import replace

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.errors import InputError
from ccgen.estimation import (
    elongation_adds,
    elongation_bias,
    elongation_warning,
    fit_coupled,
    fit_joint,
)
from ccgen.joint.file import parse_joint
from ccgen.sensing.counts import counts_of, raw_counts
from ccgen.sensing.noise import told_noise
from ccgen.sensing.readings import length_changes, normalised_response, normaliser
from ccgen.shapes import combined_shapes, fit_library, fit_shapes, score_shapes


def joint_of(sensors, method="wam", geometry="", transducer="", tables=""):
    """A joint with sensors (name, first, last, degrees), radius 0.03 m."""
    lists = "".join(
        f'[[sensor]]\nname = "{name}"\nspan = [{first}, {last}]\nangle = {degrees}\nradius = 0.03\n'
        for name, first, last, degrees in sensors
    )
    return parse_joint(
        'name = "any"\n[geometry]\nsegments = 6\nlength = 0.12\nrange_of_motion = 5.0\n'
        f"{geometry}\n"
        f"[sensors.transducer]\nmetres_per_count = 1e-6\nnoise = 5e-5\n{transducer}\n"
        f"[shapes]\nfit_samples = 8\nscore_samples = 5\n{tables}\n"
        f'[estimator]\nmethod = "{method}"\n{lists}',
        "any.toml",
    )


ROUND = [
    (f"s{j}_{last}", 0, last, degrees)
    for j, degrees in enumerate((90, 210, 330))
    for last in (2, 5)
]
STRETCH = "elongation = [0.0, 0.04]"
PAIRS = [("up", 0, 5, 90), ("down", 0, 5, 270), ("right", 0, 5, 0), ("left", 0, 5, 180)]


# ---- shapes ----------------------------------------------------------------------------------


def test_bends_and_elongations_of_combined_shapes_are_uncorrelated():
    joint = joint_of(ROUND, geometry=f"{STRETCH}\nsections = [2, 4]")
    library = fit_library(joint)
    shapes = combined_shapes(library, joint.geometry, joint.axes)
    assert len(shapes) == 4 * len(library.angles)
    assert set(shapes.source) == {"cases"}
    np.testing.assert_allclose(shapes.u.T @ shapes.v, 0.0, atol=1e-15)
    np.testing.assert_allclose(shapes.u.T @ shapes.h, 0.0, atol=1e-15)
    assert shapes.h.min() >= 0.0
    assert shapes.h.max() <= 0.04
    assert np.ptp(shapes.h, axis=0).min() > 0.035
    assert abs(np.corrcoef(shapes.h.T)[0, 1]) < 0.3
    np.testing.assert_allclose(shapes.u.T @ shapes.u, 4 * library.angles.T @ library.angles)


def test_an_axis_that_is_not_estimated_stays_straight():
    joint = parse_joint(joint_text(tables='[estimator]\naxes = ["v"]'), "planar.toml")
    shapes = combined_shapes(fit_library(joint), joint.geometry, joint.axes)
    assert not shapes.u.any()
    assert shapes.v.any()
    assert set(fit_joint(joint)) == {"v"}


# ---- the paper's sets ------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["equal", "wam", "noise-aware"])
def test_sensors_of_the_papers_sets_get_the_papers_weights_in_either_way(method):
    text = joint_text(segments=8, step=1e-12, bits=32, precision=32, transducer="noise = 2e-5")
    joint = parse_joint(text, "paper.toml")
    paper = fit_joint(joint, method)
    for axis in ("u", "v"):
        general = fit_coupled(joint, axis, method, fit_shapes(joint))
        np.testing.assert_allclose(general.matrix, paper[axis].matrix, rtol=1e-6, atol=1e-9)
        assert general.spans == paper[axis].spans


def test_direct_weights_take_the_one_reading_of_the_papers_sets():
    text = joint_text(segments=8).replace("heuristic", "end-to-end")
    joint = parse_joint(text, "paper.toml")
    general = fit_coupled(joint, "u", "direct", fit_shapes(joint))
    np.testing.assert_array_equal(general.matrix, fit_joint(joint, "direct")["u"].matrix)


# ---- opposite pairs --------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", ["", STRETCH])
def test_opposite_sensors_tell_bending_by_half_their_difference(geometry):
    joint = joint_of(PAIRS, "equal", geometry)
    weights = fit_joint(joint)
    other = [] if not geometry else [0.0, 0.0]
    np.testing.assert_allclose(weights["u"].matrix, [[0.5, -0.5, *other]] * 6, atol=1e-15)
    np.testing.assert_allclose(weights["v"].matrix, [[*other, -0.5, 0.5]] * 6, atol=1e-15)
    if geometry:
        quarter = 0.25 * 0.03 / 0.02  # r / h0: a normalised reading of elongation
        np.testing.assert_allclose(weights["h"].matrix, [[quarter] * 4], atol=1e-15)


@pytest.mark.parametrize("method", ["wam", "noise-aware"])
def test_fitted_weights_of_opposite_sensors_are_antisymmetric(method):
    weights = fit_joint(joint_of(PAIRS, method))
    matrix = weights["u"].matrix
    np.testing.assert_allclose(matrix[:, 0], -matrix[:, 1], atol=1e-9)


# ---- three strings with elongation -----------------------------------------------------------


def test_noise_aware_weights_are_the_wiener_filter_of_the_whole_state():
    joint = joint_of(ROUND, "noise-aware", STRETCH, "gain_tolerance = 0.01")
    weights, states = fit_joint(joint), fit_shapes(joint).state
    C, H = states.T @ states / len(states), normalised_response(joint)
    # Fifty micrometres, a step of one, and one per cent of what the lengths do.
    lengths = (H * normaliser(joint)[:, None]) @ C @ (H * normaliser(joint)[:, None]).T
    variance = 5e-5**2 + 1e-6**2 / 12 + 0.01**2 * np.diag(lengths)
    R = np.diag(variance / normaliser(joint) ** 2)
    G = C @ H.T @ np.linalg.inv(H @ C @ H.T + R)
    for axis, one in weights.items():
        np.testing.assert_allclose(one.matrix, G[joint.rows(axis)], rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(told_noise(joint, "u", C), np.sqrt(np.diag(R)))


@pytest.mark.parametrize("method", ["equal", "wam", "noise-aware"])
def test_strings_all_around_tell_elongation_from_bending(method):
    joint = joint_of(ROUND, method, STRETCH)
    fit = ccgen.fit(joint)
    weights = fit.weights
    for axis in ("u", "v"):
        np.testing.assert_allclose(elongation_bias(joint, axis, weights[axis]), 0.0, atol=1e-9)
    np.testing.assert_allclose(elongation_bias(joint, "h", weights["h"]), 1.0, rtol=1e-3)
    assert fit.errors[0].elongation_rms_percent < 0.005
    assert not any("cannot tell" in warning for warning in fit.warnings)


def test_each_section_elongates_by_itself():
    sensors = [
        (f"{name}{first}", first, last, degrees)
        for name, degrees in (("a", 90), ("b", 210), ("c", 330))
        for first, last in ((0, 2), (3, 5))
    ]
    joint = joint_of(sensors, "equal", f"{STRETCH}\nsections = [3, 3]")
    weights = fit_joint(joint)
    state = np.zeros(14)
    state[12:] = 0.03, 0.01
    sensed = length_changes(joint, state) / normaliser(joint)
    np.testing.assert_allclose(weights["h"].estimate(sensed), [0.03, 0.01], rtol=1e-12)
    np.testing.assert_allclose(weights["u"].estimate(sensed), 0.0, atol=1e-15)


def test_counts_of_strings_turn_back_into_bends_and_elongation():
    joint = joint_of(ROUND, "noise-aware", STRETCH, "zero = 100")
    fit, shapes = ccgen.fit(joint), score_shapes(joint)
    estimate = fit.estimate(raw_counts(joint, shapes))
    assert np.abs(estimate.u - shapes.u).mean() < 0.02 * math.radians(5.0)
    assert np.abs(estimate.v - shapes.v).mean() < 0.02 * math.radians(5.0)
    np.testing.assert_allclose(estimate.h, shapes.h, atol=1e-3)


def test_shapes_given_as_arrays_are_fitted_together():
    joint = joint_of(ROUND, "noise-aware", STRETCH)
    shapes = fit_shapes(joint)
    fit = ccgen.fit(joint, shapes={"u": shapes.u, "v": shapes.v, "h": shapes.h})
    np.testing.assert_array_equal(fit.weights["v"].matrix, fit_joint(joint)["v"].matrix)
    assert [row.source for row in fit.errors[::2]] == ["cases", "given", "other loads"]


# ---- what sensors cannot tell ----------------------------------------------------------------


def test_what_elongation_adds_is_what_a_stretched_joint_reads():
    joint = parse_joint(joint_text(transducer="noise = 2e-5"), "shoulder.toml")
    weights = fit_joint(joint)
    state = np.zeros(25)
    state[24] = 0.01
    sensed = (length_changes(joint, state) / normaliser(joint))[joint.own("v")]
    bias = np.abs(weights["v"].estimate(sensed)).mean()
    assert elongation_adds(joint, weights)["v"] == pytest.approx(100 * bias / math.radians(3.0))
    assert elongation_warning(joint, weights) == (
        "the sensors cannot tell elongation from bending: each 1 % that the joint may elongate "
        "adds 7.64 % of ROM to u and 7.64 % of ROM to v"
    )


def test_sets_of_the_paper_on_a_joint_that_elongates_are_fitted_together_and_warned_of():
    text = joint_text(transducer="noise = 2e-5").replace(
        "range_of_motion = 3.0", "range_of_motion = 3.0\nelongation = [0.0, 0.02]"
    )
    joint = parse_joint(text, "shoulder.toml")
    fit = ccgen.fit(joint, "noise-aware")
    assert [one.matrix.shape for one in fit.weights.values()] == [(12, 6), (12, 6), (1, 6)]
    assert any("each 1 % of it adds" in warning for warning in fit.warnings)


def test_expected_errors_hold_under_noise_steps_and_gains():
    joint = joint_of(ROUND, "noise-aware", STRETCH, "bits = 12\ngain_tolerance = 0.02")
    joint = replace(
        joint, sensors=tuple(replace(one, metres_per_count=2e-4) for one in joint.sensors)
    )
    fit, shapes = ccgen.fit(joint), score_shapes(joint)
    random = np.random.default_rng(3)
    errors = []
    for _ in range(300):
        gains = random.normal(1.0, 0.02, len(joint.sensors))
        noise = random.normal(0.0, 5e-5, (len(shapes), len(joint.sensors)))
        lengths = 2e-4 * np.rint((length_changes(joint, shapes.state) * gains + noise) / 2e-4)
        estimate = fit.weights["u"].estimate(lengths / normaliser(joint))
        errors.append(np.abs(estimate - shapes.u).mean())
    expected = fit.errors[1].mean_percent_rom["u"]
    measured = 100 * np.mean(errors) / math.radians(5.0)
    assert measured == pytest.approx(expected, rel=0.15)
    assert np.abs(counts_of(joint, shapes)).max() > 10


def test_direct_weights_solve_three_sensors_for_three_unknowns():
    sensors = [("a", 0, 5, 90), ("b", 0, 5, 180), ("c", 0, 5, 270)]
    joint = joint_of(sensors, "direct", STRETCH)
    weights = fit_joint(joint)
    state = np.array([0.02] * 6 + [-0.03] * 6 + [0.01])
    sensed = length_changes(joint, state) / normaliser(joint)
    for axis, value in (("u", 0.02), ("v", -0.03), ("h", 0.01)):
        np.testing.assert_allclose(weights[axis].estimate(sensed), value, rtol=1e-12)


@pytest.mark.parametrize(
    ("sensors", "count"),
    [(ROUND, 6), ([("a", 0, 5, 90), ("b", 0, 5, 180), ("c", 0, 5, 90)], 3)],
)
def test_direct_weights_need_one_solution_a_segment(sensors, count):
    with pytest.raises(InputError) as refused:
        fit_joint(joint_of(sensors, "direct", STRETCH))
    assert str(refused.value) == (
        f"any.toml: estimator.method: axis u: segment 0 is covered by {count} sensors, which must "
        'be 3 that tell u, v, h from each other; use the method "equal"'
    )


def test_unknown_methods_and_noise_that_is_not_stated_are_refused():
    joint = joint_of(ROUND, geometry=STRETCH)
    shapes = fit_shapes(joint)
    with pytest.raises(InputError, match="unknown method 'wam-paper-call'"):
        fit_coupled(joint, "u", "wam-paper-call", shapes)
    silent = replace(joint, sensors=tuple(replace(one, noise=None) for one in joint.sensors))
    with pytest.raises(InputError, match=r"state sensors\.transducer\.noise"):
        fit_coupled(silent, "u", "noise-aware", shapes)
