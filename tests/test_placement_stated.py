import itertools
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.cli.place_output import figure
from ccgen.estimation.sources import simulated_sources
from ccgen.joint.file import parse_joint
from ccgen.placement import Constraints, Search, SetsProblem, place, search
from ccgen.placement.groups import of_one_kind
from ccgen.placement.moments import GroupMoments, MomentModel

JOINT = """
name = "finger"
[geometry]
segments = 8
length = 0.2
range_of_motion = 4.0
[sensors]
spans = {spans}
radius = 0.03
[sensors.transducer]
bits = 14
metres_per_count = 2e-5
noise = 3e-5
gain_tolerance = 0.01
[loads]
samples = 60
stiffness = 0.3
stiffness_profile = [2.0, 1.0, 1.0, 2.0]
actuation = [-25.0, 25.0]
tip_force = [0.0, 1.5]
contact = [0.0, 3.0]
[estimator]
method = "noise-aware"
check = false
"""
SPANS = "[[0, 2], [2, 5], [5, 7]]"


def joint(spans=SPANS):
    return parse_joint(JOINT.format(spans=spans), "finger.toml")


def posed(sensors=3, constraints=None, by_tip=False, axes=("u", "v")):
    asked = joint()
    sources = simulated_sources(asked)
    return SetsProblem(
        joint=asked,
        axes=axes,
        sources=sources,
        sensors=sensors,
        constraints=constraints or Constraints(),
        by_tip=by_tip,
    )


def random_placements(segments, sensors, count, seed=1):
    random = np.random.default_rng(seed)
    return np.sort(random.integers(segments, size=(count, sensors, 2)), axis=-1)


def random_moment(segments, seed):
    half = np.random.default_rng(seed).normal(size=(segments, segments))
    return half @ half.T


def moments(C, D, sensors, deviation, tolerance):
    return GroupMoments.of(of_one_kind("u", slice(0, len(C)), sensors, deviation, tolerance), C, D)


def what_is_left(C, D, spans, deviation, tolerance):
    """tr(D P) by the formula itself."""
    at = np.arange(len(C))
    H = ((at >= spans[:, :1]) & (at <= spans[:, 1:])).astype(float)
    clean = H @ C @ H.T
    R = np.diag(deviation**2 + tolerance**2 * np.diag(clean))
    return np.trace(D @ (C - C @ H.T @ np.linalg.inv(clean + R) @ H @ C))


@pytest.mark.parametrize("sensors", [1, 3, 6])
def test_the_model_is_the_root_of_what_the_covariance_leaves(sensors):
    pairs = [(random_moment(10, k), random_moment(10, 5 + k)) for k in range(2)]
    model = MomentModel([moments(C, D, sensors, 0.3, 0.02) for C, D in pairs], 7.0)
    spans = random_placements(10, sensors, 20)
    left = [sum(what_is_left(C, D, one, 0.3, 0.02) for C, D in pairs) for one in spans]
    np.testing.assert_allclose(model.values(spans), 100 * np.sqrt(left) / 7.0, rtol=1e-8)


@pytest.mark.parametrize("deviation", [0.0, 0.3])
def test_moved_values_are_those_of_the_moved_placements(deviation):
    model = MomentModel([moments(random_moment(10, 1), np.eye(10), 3, deviation, 0.0)], 1.0)
    catalogue = np.array([(a, b) for a in range(10) for b in range(a, 10)])
    others = np.array([[0, 3], [3, 8]])
    spans = np.concatenate([np.repeat(others[None], len(catalogue), 0), catalogue[:, None]], axis=1)
    moved = model.moved_values(others, catalogue, 2)
    # Of equal spans without noise, only rounding tells how much they add.
    np.testing.assert_allclose(moved, model.values(spans), rtol=1e-4)


@pytest.mark.parametrize(("by_tip", "within"), [(False, 1e-9), (True, 0.02)])
def test_the_fast_objective_is_what_estimation_tells(by_tip, within):
    problem = posed(by_tip=by_tip)
    spans = random_placements(8, 3, 5)
    told = [problem.percent(tuple(map(tuple, one))) for one in spans.tolist()]
    np.testing.assert_allclose(problem.percents(spans), told, rtol=within)


@pytest.mark.parametrize("by_tip", [False, True])
def test_the_search_finds_the_best_of_all_placements(by_tip):
    problem = posed(2, by_tip=by_tip)
    every = np.array(list(itertools.combinations_with_replacement(problem.catalogue.tolist(), 2)))
    every = every[problem.violations(every) == 0]
    found = search(problem, Search(starts=6))
    best = problem.percents(every).min()
    assert problem.percents(np.array([found.spans]))[0] == pytest.approx(best, rel=1e-9)
    assert found.optimality == "none"


def test_the_search_keeps_to_constraints():
    limits = Constraints(longest=5, fixed=((2, 4),), stacked=2)
    problem = posed(4, limits)
    found = search(problem, Search(starts=4))
    assert problem.allows(found.spans)


def test_an_axis_with_a_table_of_its_own_is_placed_by_its_own_noise():
    text = JOINT.format(spans=SPANS) + "[sensors.v.transducer]\nnoise = 1e-3\n"
    u, v = place(parse_joint(text, "finger.toml"), 3, "search", search=Search(starts=3))
    assert (u.axes, v.axes) == (("u",), ("v",))
    assert u.best.percent < v.best.percent


def answer(file, *options):
    result = CliRunner().invoke(app, ["place", str(file), "--method", "search", *options, "--json"])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_spans_that_are_pasted_give_the_errors_that_place_tells(tmp_path):
    file = tmp_path / "finger.toml"
    file.write_text(JOINT.format(spans=SPANS))
    found = answer(file, "--sensors", "3", "--starts", "4")
    assert found["objective"] == "angles"
    np.testing.assert_allclose(
        found["spans_m"], [[0.025 * a, 0.025 * (b + 1)] for a, b in found["spans"]]
    )
    file.write_text(JOINT.format(spans=found["spans"]))
    fitted = CliRunner().invoke(app, ["fit", str(file), "--json"])
    rows = [row for row in json.loads(fitted.stdout)["errors"] if row["source"] == "loads"]
    for told, row in zip(found["errors"], rows, strict=True):
        assert (told["source"], told["noise"]) == (row["source"], row["noise"])
        # What fixed point rounds is in the errors of `fit` alone.
        assert told["tip_rms_m"] == pytest.approx(row["tip_rms_m"], rel=0.02)
        assert told["mean_percent_rom"] == pytest.approx(row["mean_percent_rom"], rel=0.02)


def test_the_tip_is_an_objective_of_its_own(tmp_path):
    file = tmp_path / "finger.toml"
    file.write_text(JOINT.format(spans=SPANS))
    by = {one: answer(file, "--starts", "4", "--objective", one) for one in ("angles", "tip")}
    tip, mean = (
        {name: pick(one["errors"][1]) for name, one in by.items()}
        for pick in (lambda row: row["tip_rms_m"], lambda row: row["mean_percent_rom"]["u"])
    )
    assert tip["tip"] < tip["angles"]
    assert mean["angles"] < mean["tip"]
    assert by["tip"]["objective"] == "tip"


@pytest.mark.parametrize(
    ("objective", "unit"), [("angles", "% of ROM"), ("tip", "% of the length at the tip")]
)
def test_the_plot_says_what_its_errors_are_shares_of(objective, unit):
    placed = place(joint(), method="heuristic", objective=objective)
    assert figure(joint(), placed, ()).axes[0].get_title().endswith(unit)
