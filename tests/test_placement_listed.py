"""Sensors of [[sensor]], placed one by one: held against formulas, the sets, and all placements."""

import itertools
import json
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.errors import InputError
from ccgen.estimation.sources import simulated_sources
from ccgen.joint.file import parse_joint
from ccgen.placement import Constraints, ListedProblem, Search, SetsProblem, place, search
from ccgen.placement.groups import Group
from ccgen.placement.moments import GroupMoments, MomentModel

ROUND = [("a", 0, 3, 90), ("b", 0, 3, 210), ("c", 0, 3, 330)]
PAIRS = [("up", 0, 3, 90), ("down", 0, 3, 270), ("right", 0, 3, 0), ("left", 0, 3, 180)]
STRETCH = "elongation = [0.0, 0.04]"


def text_of(sensors, geometry=STRETCH, estimator="", segments=4, own=None, top=""):
    """A joint file with sensors (name, first, last, degrees)."""
    listed = "".join(
        f'[[sensor]]\nname = "{name}"\nspan = [{first}, {last}]\nangle = {degrees}\nradius = 0.03\n'
        f"{(own or {}).get(name, '')}\n"
        for name, first, last, degrees in sensors
    )
    stretched = "elongation = [0.0, 0.03]" if geometry else ""
    return f"""
name = "any"
{top}
[geometry]
segments = {segments}
length = 0.2
range_of_motion = 8.0
{geometry}
[sensors.transducer]
bits = 14
metres_per_count = 2e-5
noise = 3e-5
gain_tolerance = 0.01
[loads]
samples = 40
stiffness = 0.3
stiffness_profile = [2.0, 1.0, 1.0, 2.0]
actuation = [-25.0, 25.0]
tip_force = [0.0, 1.5]
contact = [0.0, 3.0]
{stretched}
[estimator]
method = "noise-aware"
check = false
{estimator}
{listed}"""


def posed(sensors, by_tip=False, constraints=None, **said):
    joint = parse_joint(text_of(sensors, **said), "any.toml")
    return ListedProblem(
        joint=joint,
        sources=simulated_sources(joint),
        constraints=constraints or Constraints(),
        by_tip=by_tip,
    )


def random_placements(segments, sensors, count, seed=1):
    random = np.random.default_rng(seed)
    return np.sort(random.integers(segments, size=(count, sensors, 2)), axis=-1)


def spans_of(placement):
    return tuple(map(tuple, np.asarray(placement).tolist()))


# ---- the objective ---------------------------------------------------------------------------


def test_the_model_is_what_the_covariance_leaves_where_some_rows_are_not_estimated():
    random = np.random.default_rng(3)
    m, rows = 6, 9
    kinds = np.array([0, 1, 1, 2])
    estimated = np.arange(rows) < 7
    group = Group(
        axes={},
        slots=slice(0, 4),
        rows=slice(0, rows),
        estimated=estimated,
        kinds=kinds,
        patterns=random.normal(size=(3, m, rows)),
        deviation=np.array([0.1, 0.3, 0.2]),
        tolerance=np.array([0.0, 0.02, 0.1]),
    )
    C, D = (part @ part.T for part in random.normal(size=(2, rows, rows)))
    model = MomentModel([GroupMoments.of(group, C, D)], 1.0)
    spans = random_placements(m, 4, 10)
    for placement, value in zip(spans, model.values(spans), strict=True):
        H = np.array(
            [
                group.patterns[kind, first : last + 1].sum(axis=0)
                for kind, (first, last) in zip(kinds, placement, strict=True)
            ]
        )
        clean = H @ C @ H.T
        own = group.deviation[kinds] ** 2 + group.tolerance[kinds] ** 2 * np.diag(clean)
        S = clean + np.diag(own)
        gain = np.where(estimated[:, None], C @ H.T @ np.linalg.inv(S), 0.0)
        error = (gain @ H - np.eye(rows)) @ C @ (gain @ H - np.eye(rows)).T
        error += gain @ np.diag(own) @ gain.T
        assert value == pytest.approx(100.0 * np.sqrt(np.trace(D @ error)), rel=1e-8)
    catalogue = np.array([(a, b) for a in range(m) for b in range(a, m)])
    for slot in range(4):
        tried = np.repeat(spans[:1], len(catalogue), axis=0)
        tried[:, slot] = catalogue
        moved = model.moved_values(np.delete(spans[0], slot, axis=0), catalogue, slot)
        np.testing.assert_allclose(moved, model.values(tried), rtol=1e-8)


@pytest.mark.parametrize(
    "said",
    [
        {},
        {"estimator": 'axes = ["u", "v"]'},
        {"geometry": ""},
        {"geometry": f"{STRETCH}\nsections = [1, 3]"},
        {"own": {"b": "noise = 2e-4\ngain_tolerance = 0.03"}},
    ],
    ids=["three axes", "no h", "no elongation", "sections", "a noisy one"],
)
@pytest.mark.parametrize(("by_tip", "within"), [(False, 1e-9), (True, 0.02)])
def test_the_fast_objective_is_what_estimation_tells(said, by_tip, within):
    problem = posed([*ROUND, ("d", 0, 3, 45)], by_tip=by_tip, **said)
    spans = random_placements(4, 4, 4)
    told = [problem.percent(spans_of(one)) for one in spans]
    np.testing.assert_allclose(problem.percents(spans), told, rtol=within)


def test_a_planar_joint_is_judged_by_its_axis():
    sensors = [("a", 0, 3, 150), ("b", 0, 3, 210)]
    problem = posed(sensors, geometry="", estimator='axes = ["v"]')
    spans = random_placements(4, 2, 4)
    told = [problem.percent(spans_of(one)) for one in spans]
    np.testing.assert_allclose(problem.percents(spans), told, rtol=1e-9)
    assert not problem.violations(np.array([[[0, 1], [2, 3]]])).any()


@pytest.mark.parametrize("by_tip", [False, True])
def test_the_papers_sets_in_a_list_have_the_errors_of_sets(by_tip):
    spans = ((0, 1), (1, 3))
    listed = [(f"u{j}", a, b, 90) for j, (a, b) in enumerate(spans)]
    listed += [(f"v{j}", a, b, 180) for j, (a, b) in enumerate(spans)]
    problem = posed(listed, by_tip=by_tip, geometry="")
    text = text_of([], geometry="").replace(
        "[sensors.transducer]",
        f"[sensors]\nradius = 0.03\nspans = {[list(span) for span in spans]}\n[sensors.transducer]",
    )
    sets = parse_joint(text, "sets.toml")
    like = SetsProblem(
        joint=sets, axes=("u", "v"), sources=simulated_sources(sets), sensors=2, by_tip=by_tip
    )
    assert len(problem.groups) == 2
    assert problem.percent(spans * 2) == pytest.approx(like.percent(spans), rel=1e-9)
    twice, once = np.array([spans * 2]), np.array([spans])
    np.testing.assert_allclose(problem.percents(twice), like.percents(once), rtol=1e-9)
    np.testing.assert_allclose(problem.model.values(twice), like.model.values(once), rtol=1e-9)


# ---- the search ------------------------------------------------------------------------------


def best_of_all(problem):
    """The lowest objective of all placements that keep to the constraints."""
    every = np.array(list(itertools.product(problem.catalogue.tolist(), repeat=problem.sensors)))
    every = every[problem.violations(every) == 0]
    return problem.percents(every).min()


@pytest.mark.parametrize("by_tip", [False, True])
@pytest.mark.parametrize(
    ("sensors", "said"),
    [
        (ROUND, {}),
        (ROUND, {"own": {"b": "noise = 2e-4"}}),
        ([("a", 0, 3, 180), ("b", 0, 3, 0), ("c", 0, 3, 0)], {"estimator": 'axes = ["v", "h"]'}),
        ([("a", 0, 3, 150), ("b", 0, 3, 150)], {"geometry": "", "estimator": 'axes = ["v"]'}),
    ],
    ids=["120 degrees", "one noisy", "pair and one", "planar"],
)
def test_the_search_finds_the_best_of_all_placements(sensors, said, by_tip):
    problem = posed(sensors, by_tip=by_tip, **said)
    found = search(problem, Search(starts=8))
    best = best_of_all(problem)
    assert problem.percents(np.array([found.spans]))[0] <= 1.0001 * best
    assert found.optimality == "none"


def test_sensors_that_are_alike_are_counted_once():
    sensors = [("a", 0, 3, 90), ("b", 0, 3, 90), ("c", 0, 3, 180), ("d", 0, 3, 180)]
    own = {"d": "noise = 1e-4"}
    problem = posed(sensors, own=own)
    first = np.array([[0, 3], [0, 1], [2, 3], [0, 1]])
    assert problem.arranged(first) == ((0, 1), (0, 3), (2, 3), (0, 1))
    kept = posed(sensors, own=own, constraints=Constraints(staying=("a",)))
    assert kept.arranged(first) == spans_of(first)


def test_the_search_keeps_to_constraints():
    sensors = [(f"s{k}", 0, 3, degrees) for k, degrees in enumerate([90, 90, 210, 210, 330, 330])]
    sensors[2] = ("s2", 1, 2, 210)
    limits = Constraints(longest=3, stacked=1, staying=("s2",), forbidden=())
    problem = posed(sensors, constraints=limits)
    found = search(problem, Search(starts=6))
    assert problem.allows(found.spans)
    assert found.spans[2] == (1, 2)
    for a, b in (found.spans[k : k + 2] for k in (0, 2, 4)):
        assert max(a[0], b[0]) > min(a[1], b[1])
    assert all(b - a < 3 for a, b in found.spans)


def test_each_segment_needs_two_directions_unless_the_joint_is_planar():
    pair = posed(PAIRS[:3], geometry="")
    assert pair.violations(np.array([[[0, 3], [0, 3], [0, 2]]])).tolist() == [1]
    assert pair.violations(np.array([[[0, 1], [2, 3], [0, 3]]])).tolist() == [0]


# ---- the command -----------------------------------------------------------------------------


def run(*arguments):
    return CliRunner().invoke(app, ["place", *map(str, arguments)])


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "any.toml"
    path.write_text(text_of(PAIRS, own={"left": "zero = 7  # mine\nrange = [-8000, 8000]"}))
    return path


def test_lines_that_are_pasted_give_the_errors_that_place_tells(file, tmp_path):
    options = [file, "--method", "search", "--starts", "4"]
    found = json.loads(run(*options, "--json").stdout)
    assert found["sensors"] == [name for name, *_ in PAIRS]
    assert set(found["axes"]) == {"u", "v"}
    printed = run(*options).stdout
    lines = printed[printed.index("[[sensor]]") :]
    tables = tomllib.loads(lines)["sensor"]
    assert [table["span"] for table in tables] == found["spans"]
    assert (tables[3]["zero"], tables[3]["range"]) == (7, [-8000, 8000])
    text = file.read_text()
    file.write_text(text[: text.index("[[sensor]]")] + lines)
    fitted = json.loads(CliRunner().invoke(app, ["fit", str(file), "--json"]).stdout)
    rows = [row for row in fitted["errors"] if row["source"] == "loads"]
    for told, row in zip(found["errors"], rows, strict=True):
        assert (told["source"], told["noise"]) == (row["source"], row["noise"])
        # What fixed point rounds is in the errors of `fit` alone.
        assert told["tip_rms_m"] == pytest.approx(row["tip_rms_m"], rel=0.02)
        assert told["mean_percent_rom"] == pytest.approx(row["mean_percent_rom"], rel=0.02)


def test_methods_are_compared_with_what_the_file_states(file):
    found = json.loads(run(file, "--individuals", 40, "--generations", 2, "--json").stdout)
    names = [one["method"] for one in found["methods"]]
    assert names == ["stated", "end-to-end", "heuristic", "evolutionary", "search"]
    assert found["methods"][0]["spans"] == [[first, last] for _, first, last, _ in PAIRS]
    scores = [one["score_with_noise_percent_rom"] for one in found["methods"]]
    assert found["score_with_noise_percent_rom"] == min(scores)


def test_a_sensor_that_is_kept_stays(file):
    found = json.loads(run(file, "--keep", "up", "--method", "search", "--json").stdout)
    assert found["spans"][0] == [0, 3]


def test_spans_with_parts_of_segments_are_told_and_may_stay_as_they_are(tmp_path):
    file = tmp_path / "any.toml"
    file.write_text(text_of(PAIRS).replace("span = [0, 3]", "span_m = [0.0, 0.19]", 1))
    result = run(file, "--method", "stated")
    assert result.exit_code == 0
    assert "span_m = [0.0, 0.19]" in result.stdout


def test_sets_of_a_joint_that_elongates_are_placed_one_by_one(tmp_path):
    file = tmp_path / "any.toml"
    sets = "[sensors]\nradius = 0.03\ncount = 2\n[sensors.transducer]"
    file.write_text(text_of([]).replace("[sensors.transducer]", sets))
    result = run(file, "--method", "search", "--starts", 4)
    assert result.exit_code == 0, result.stderr
    lines = tomllib.loads(result.stdout[result.stdout.index("[sensors.u]") :])
    text = file.read_text().replace("count = 2\n", "\n")
    for axis in "uv":
        text += f"\n[sensors.{axis}]\nspans = {lines['sensors'][axis]['spans']}\n"
    parse_joint(text, "pasted.toml")


def test_spans_are_drawn_with_names(file, tmp_path):
    plot = tmp_path / "spans.svg"
    assert run(file, "--method", "stated", "--plot", plot).exit_code == 0
    assert all(f">{name}<" in plot.read_text() or name in plot.read_text() for name, *_ in PAIRS)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--sensors", 3], "--sensors: is for the sets of [sensors]; sensors that are placed one"),
        (["--axis", "u"], "--axis: is for the sets of [sensors]"),
        (["--objective", "paper"], "--objective: 'paper' is for the sets"),
        (["--fix", "0-2"], "--fix: is for the sets of [sensors]"),
        (["--keep", "top"], "--keep: no sensor is called 'top'; give up or down or right or left"),
        (["--method", "single", "--max-span", 2], "the layout single does not keep"),
        (["--max-span", 1, "--max-stacked", 1], "no placement"),
    ],
)
def test_bad_input_is_one_line(file, options, message):
    result = run(file, *options, "--starts", 2, "--individuals", 20, "--generations", 1)
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert message in result.stderr


def test_names_do_not_stay_in_sets(tmp_path):
    file = tmp_path / "any.toml"
    sets = "[sensors]\nradius = 0.03\ncount = 2\n[sensors.transducer]"
    file.write_text(text_of([], geometry="").replace("[sensors.transducer]", sets))
    result = run(file, "--keep", "u0")
    assert result.exit_code == 2
    assert "--keep: is for sensors that are placed one by one" in result.stderr


def test_noise_of_some_sensors_alone_is_refused():
    text = text_of(ROUND, own={"b": "noise = 1e-4"}).replace("noise = 3e-5", "")
    text = text.replace("noise-aware", "wam")
    with pytest.raises(InputError, match=r"any.toml: sensor\[0\].noise: not stated"):
        place(parse_joint(text, "any.toml"))


def test_without_noise_plain_weights_judge():
    text = text_of(ROUND).replace("noise = 3e-5", "").replace("noise-aware", "wam")
    (placed,) = place(parse_joint(text, "any.toml"), search=Search(starts=3))
    assert placed.estimator == "wam"
    assert {one.method for one in placed.found} >= {"stated", "search"}
