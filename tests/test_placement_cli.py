import json
import re
import tomllib
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

import ccgen
from ccgen.cli import place as command
from ccgen.cli.main import app
from ccgen.estimation import score_with_noise_percent_rom
from ccgen.joint.file import parse_joint
from ccgen.joint.layouts import heuristic
from ccgen.placement import METHODS
from ccgen.shapes import score_library

EXAMPLES = Path(__file__).parents[1] / "examples"
SHOULDER, WRIST = EXAMPLES / "shoulder.toml", EXAMPLES / "wrist.toml"
FEW = ["--individuals", "40", "--generations", "2", "--starts", "2"]


def run(*arguments):
    return CliRunner().invoke(app, ["place", *map(str, arguments)])


def fit(joint):
    result = CliRunner().invoke(app, ["fit", str(joint), "--json"])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def printed(*arguments):
    """The lines for the joint file."""
    result = run(*arguments)
    assert result.exit_code == 0, result.stderr
    return tomllib.loads(result.stdout[result.stdout.index("[sensors") :])


def pasted(file, joint, found):
    """Write a joint file with other spans, or another estimator, in place of what it had."""
    table = tomllib.loads(joint.read_text())
    sensors, spans = table["sensors"], found.get("sensors", {})
    for part, new in ((sensors, spans), *((sensors.get(k, {}), spans.get(k, {})) for k in "uv")):
        if "spans" in new:
            part.pop("placement", None)
            part.pop("count", None)
            part["spans"] = new["spans"]
    table.update((key, value) for key, value in found.items() if key != "sensors")
    file.write_text("\n".join(toml_lines(table)))
    return file


def toml_lines(table, name=""):
    inner = {key: value for key, value in table.items() if isinstance(value, dict)}
    for key in table.keys() - inner.keys():
        # A literal of these types is one in JSON.
        yield f"{key} = {json.dumps(table[key])}"
    for key, value in inner.items():
        yield f"[{name}{key}]"
        yield from toml_lines(value, f"{name}{key}.")


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
    score = "score_with_noise_percent_rom"
    assert found[score] == min(one[score] for one in found["methods"])
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


@pytest.mark.parametrize("estimator", ["wam", "equal", "noise-aware"])
def test_noise_is_the_objective_wherever_it_is_stated(tmp_path, estimator):
    joint = tmp_path / "joint.toml"
    joint.write_text(SHOULDER.read_text().replace('method = "wam"', f'method = "{estimator}"'))
    found = answer(joint, "--sensors", 3, "--method", "search")
    paper = answer(joint, "--sensors", 3, "--method", "search", "--objective", "paper")
    assert (found["objective"], paper["objective"]) == ("angles", "paper")
    assert (found["estimator"], paper["estimator"]) == ("noise-aware", "wam")
    assert found["score_with_noise_percent_rom"] < paper["score_with_noise_percent_rom"]
    assert found == answer(SHOULDER, "--sensors", 3, "--method", "search", "--objective", "angles")


@pytest.mark.parametrize("noise", ["", "noise = 0.0"])
def test_without_noise_the_papers_objective_is_left(tmp_path, noise):
    joint = tmp_path / "joint.toml"
    joint.write_text(SHOULDER.read_text().replace("noise = 2.0e-5", noise))
    assert answer(joint, "--method", "heuristic")["objective"] == "paper"


def test_five_sensors_are_placed_for_the_noise_that_they_have():
    found = answer(SHOULDER, "--sensors", 5)
    assert found["score_with_noise_percent_rom"] <= 0.125
    lines = printed(SHOULDER, "--sensors", 5, "--method", "search")
    assert lines["sensors"]["spans"] == found["spans"]
    assert lines["estimator"] == {"method": "noise-aware"}


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
        (["--sensors", "0"], "--sensors: 0 sensors on an axis; a joint file takes 1 to 8"),
        (["--sensors", "13"], "--sensors: 13 sensors on an axis; a joint file takes 1 to 8"),
        (["--sensors", "1", "--max-span", "3"], "no placement of 1 sensor covers"),
        (["--sensors", "1", "--forbid", "0"], "no placement of 1 sensor covers"),
        (["--forbid", "7-3"], "--forbid: '7-3' is reversed; write 3-7"),
        (["--forbid", "3-99999999999"], "--forbid: segment 12 does not exist"),
        (["--forbid", "99999999999"], "--forbid: segment 99999999999 does not exist"),
        (["--min-span", "3", "--max-span", "2"], "--min-span, --max-span: spans of 3 to 2"),
        (["--max-stacked", "0"], "--max-stacked: at most 0 sensors"),
        (["--seed", "-1"], "--seed: -1 is too small"),
        (["--method", "heuristic", "--starts", "0"], "--starts: 0 is too small"),
        (["--method", "heuristic", "--enumerate", "-1"], "--enumerate: -1 is too small"),
        (["--method", "search", "--individuals", "0"], "--individuals: 0 is too small"),
        (["--method", "heuristic", "--max-stacked", "1"], "does not keep"),
    ],
)
def test_bad_input_is_one_line(options, message):
    result = run(SHOULDER, "--individuals", 20, "--generations", 1, *options)
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert message in result.stderr


def test_a_single_sensor_is_compared_and_proven_too():
    found = answer(SHOULDER, "--sensors", 1, *FEW)
    assert [one["method"] for one in found["methods"]] == list(METHODS)
    assert (found["spans"], found["optimality"]) == ([[0, 11]], "proven")


@pytest.mark.parametrize("limits", [["--min-span", 4], ["--max-span", 3], ["--min-span", 10]])
def test_every_placement_that_is_printed_keeps_to_the_constraints(limits):
    found = answer(SHOULDER, "--sensors", 8, *limits, *FEW)
    allowed = {"--min-span": lambda n: n >= limits[1], "--max-span": lambda n: n <= limits[1]}
    for one in found["methods"]:
        assert all(allowed[limits[0]](b - a + 1) for a, b in one["spans"])


def test_axes_with_tables_of_their_own_are_placed_one_by_one():
    found = answer(WRIST, "--method", "search")
    assert "spans" not in found
    assert {axis: len(one["spans"]) for axis, one in found["axes"].items()} == {"u": 4, "v": 2}
    alike = answer(WRIST, "--method", "search", "--sensors", 2, "--objective", "paper")
    assert alike["spans"] == alike["axes"]["u"]["spans"] == alike["axes"]["v"]["spans"]
    assert "score_with_noise_percent_rom" not in alike
    alone = answer(WRIST, "--method", "search", "--axis", "v")
    assert alone["axes"] == {"v": found["axes"]["v"]}
    assert alone["spans"] == found["axes"]["v"]["spans"]


def test_an_error_names_the_axis_where_axes_are_placed_one_by_one():
    result = run(WRIST, "--max-span", 3, *FEW)
    assert result.exit_code == 2
    assert result.stderr.startswith("ccgen: error: v: no placement of 2 sensors covers")


def test_axes_that_differ_in_noise_are_answered_for_each(tmp_path):
    joint = tmp_path / "joint.toml"
    joint.write_text(SHOULDER.read_text() + "\n[sensors.v]\nradius = 0.002\n")
    found = answer(joint, "--objective", "angles", "--method", "search")["axes"]
    assert found["u"]["spans"] != found["v"]["spans"]
    for axis in ("u", "v"):
        alone = answer(joint, "--objective", "angles", "--method", "search", "--axis", axis)
        assert alone["axes"][axis] == found[axis]


def without_rounding(joint, axis):
    """Score under the noise of `fit`, before fixed point adds what it rounds."""
    fitted = ccgen.fit(ccgen.load(joint))
    library, noise = score_library(fitted.joint), fitted.noise[axis]
    return score_with_noise_percent_rom(fitted.weights[axis], library, noise)


@pytest.mark.parametrize("objective", ["paper", "angles"])
@pytest.mark.parametrize("joint", [SHOULDER, WRIST], ids=lambda path: path.stem)
@pytest.mark.parametrize("estimator", ["direct", "equal", "wam", "noise-aware"])
def test_pasting_what_is_printed_gives_the_printed_score(tmp_path, joint, estimator, objective):
    if estimator == "direct":
        # That method takes no overlap.
        apart = printed(joint, "--method", "end-to-end")
        joint = pasted(tmp_path / "apart.toml", joint, apart)
    chosen = pasted(tmp_path / "chosen.toml", joint, {"estimator": {"method": estimator}})
    options = ["--method", "search", "--objective", objective, "--sensors", 3]
    expected = answer(chosen, *options)
    found = printed(chosen, *options)
    assert ("estimator" in found) == (estimator != expected["estimator"])
    pasted_joint = pasted(tmp_path / "pasted.toml", chosen, found)
    fitted = fit(pasted_joint)
    assert fitted["method"] == expected["estimator"]
    for axis, one in expected["axes"].items():
        assert fitted["axes"][axis]["spans"] == one["spans"]
        figures = fitted["axes"][axis]
        assert figures["score_percent_rom"] == pytest.approx(one["score_percent_rom"], rel=1e-9)
        expected_with_noise = one["score_with_noise_percent_rom"]
        assert without_rounding(pasted_joint, axis) == pytest.approx(expected_with_noise, rel=1e-9)
        # What fixed point rounds is independent noise, which makes a mean error a little larger.
        rounding = ccgen.fit(ccgen.load(pasted_joint)).model.axis(axis).rms_error_percent_rom
        added = figures["score_with_noise_percent_rom"] - expected_with_noise
        assert 0.0 <= added <= rounding


def test_an_estimator_that_the_scores_are_not_of_is_named(tmp_path):
    equal = tmp_path / "equal.toml"
    equal.write_text(SHOULDER.read_text().replace('method = "wam"', 'method = "equal"'))
    for objective, estimator in (("paper", "wam"), ("angles", "noise-aware")):
        result = run(equal, "--method", "heuristic", "--objective", objective)
        assert f"errors of {estimator}, not of the file's estimator equal" in result.stderr
        assert result.stdout.endswith(f'\n[estimator]\nmethod = "{estimator}"\n')
    paper = run(SHOULDER, "--method", "heuristic", "--objective", "paper")
    assert "estimator" not in paper.stdout


def test_table_fits_a_narrow_terminal_and_says_what_a_gap_is_worth():
    few = ["--sensors", 8, "--starts", 2, "--min-span", 4]
    lines = run(SHOULDER, *few, "--method", "search").stdout.splitlines()
    assert max(map(len, lines[: lines.index("[sensors]")])) <= 80
    assert any(" evaluations " in line for line in lines)
    assert any(" not proven " in line for line in lines)
    assert not any("gap" in line for line in lines)
    small = run(SHOULDER, "--sensors", 2, "--enumerate", 0, "--method", "search").stdout
    assert re.search(r" gap [1-8]\d % ", small)


def test_progress_of_each_method_is_reported(monkeypatch):
    reported = []

    @contextmanager
    def recorded():
        yield lambda *progress: reported.append(progress)

    monkeypatch.setattr(command, "progress_bars", recorded)
    answer(WRIST, *FEW, "--enumerate", 0)
    assert {what for what, _, _ in reported} == {
        f"{axis}: {method}" for axis in "uv" for method in ("evolutionary", "search")
    }
    last = {what: (done, total) for what, done, total in reported}
    assert all(done == total for done, total in last.values())


def test_spans_of_both_axes_are_drawn(tmp_path):
    plot = tmp_path / "spans.svg"
    assert run(WRIST, "--method", "heuristic", "--plot", plot).exit_code == 0
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")


def test_a_joint_file_with_a_byte_order_mark_is_placed_as_without(tmp_path):
    marked = tmp_path / "shoulder.toml"
    marked.write_bytes(b"\xef\xbb\xbf" + SHOULDER.read_bytes())
    options = ["--method", "end-to-end", "--json"]
    assert run(marked, *options).stdout == run(SHOULDER, *options).stdout != ""
