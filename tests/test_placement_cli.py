import json
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.joint import parse_joint
from ccgen.layouts import heuristic

SHOULDER = Path(__file__).parents[1] / "examples" / "shoulder.toml"
FEW = ["--individuals", "40", "--generations", "2", "--starts", "2"]


def run(*arguments):
    return CliRunner().invoke(app, ["place", *map(str, arguments)])


def answer(*arguments):
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


@pytest.mark.parametrize("sensors", [2, 3])
def test_search_is_proven_for_two_and_three_sensors(sensors):
    found = answer(SHOULDER, "--sensors", sensors, "--method", "search")
    assert found["optimality"] == "proven"
    assert len(found["spans"]) == sensors
    assert found["evaluations"] == {2: 144, 3: 8438}[sensors]


def test_all_methods_are_compared_and_the_best_is_the_answer():
    found = answer(SHOULDER, "--sensors", 4, *FEW, "--enumerate", 0)
    names = [one["method"] for one in found["methods"]]
    assert names == ["end-to-end", "heuristic", "evolutionary", "search"]
    assert found["score_percent_rom"] == min(m["score_percent_rom"] for m in found["methods"])
    assert found["methods"][3]["optimality"] == "bound"
    assert 0 < found["methods"][3]["gap"] < 1


def test_toml_on_stdout_can_be_pasted():
    result = run(SHOULDER, "--sensors", 3, "--method", "heuristic")
    start = result.stdout.index("[sensors]")
    spans = tomllib.loads(result.stdout[start:])["sensors"]["spans"]
    assert tuple(map(tuple, spans)) == heuristic(12, 3)
    text = SHOULDER.read_text().replace('placement = "heuristic"\ncount = 3', f"spans = {spans}")
    assert parse_joint(text, "pasted").u.spans == heuristic(12, 3)


def test_constraints_of_the_command_line_hold():
    limits = ["--min-span", 2, "--max-span", 8, "--forbid", "4,6-7", "--fix", "3-7"]
    found = answer(SHOULDER, "--sensors", 3, *limits, "--max-stacked", 2, "--method", "search")
    spans = [tuple(span) for span in found["spans"]]
    assert (3, 7) in spans
    for a, b in spans:
        assert (a, b) == (3, 7) or (2 <= b - a + 1 <= 8 and not {a, b} & {4, 6, 7})
    assert all(1 <= sum(a <= k <= b for a, b in spans) <= 2 for k in range(12))


def test_noise_is_the_objective_where_asked_or_where_the_estimator_knows_it(tmp_path):
    found = answer(SHOULDER, "--sensors", 3, "--method", "search", "--objective", "noise")
    paper = answer(SHOULDER, "--sensors", 3, "--method", "search")
    assert (found["objective"], paper["objective"]) == ("noise", "paper")
    assert found["score_with_noise_percent_rom"] < paper["score_with_noise_percent_rom"]
    aware = tmp_path / "aware.toml"
    aware.write_text(SHOULDER.read_text().replace('method = "wam"', 'method = "noise-aware"'))
    assert answer(aware, "--sensors", 3, "--method", "search") == found


def test_spans_are_drawn(tmp_path):
    plot = tmp_path / "spans.svg"
    result = run(SHOULDER, "--method", "heuristic", "--plot", plot, "--forbid", "5")
    assert result.exit_code == 0
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--forbid", "x"], "--forbid: 'x'"),
        (["--fix", "3"], "--fix: '3'"),
        (["--sensors", "2", "--max-span", "4"], "no placement of 2 sensors"),
        (["--sensors", "0"], "0 sensors"),
        (["--method", "heuristic", "--max-stacked", "1"], "does not keep"),
    ],
)
def test_bad_input_is_one_line(options, message):
    result = run(SHOULDER, *options, "--individuals", 20, "--generations", 1)
    assert result.exit_code == 2
    assert message in result.stderr.splitlines()[-1]


def test_axes_that_differ_in_noise_are_placed_one_by_one(tmp_path):
    joint = tmp_path / "joint.toml"
    joint.write_text(SHOULDER.read_text() + "\n[sensors.v]\nradius = 0.02\n")
    result = run(joint, "--objective", "noise", "--method", "heuristic")
    assert result.exit_code == 2
    assert "--axis" in result.stderr
    assert run(joint, "--objective", "noise", "--method", "heuristic", "--axis", "v").exit_code == 0
