"""`ccgen fit`: scores against the paper's order and reference values, figure 8, bad input."""

import json
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.cli.choices import Method
from ccgen.cli.main import main
from ccgen.estimation import FIT_METHODS, fit_joint
from ccgen.figures.case_study import case_study_figure, methods
from ccgen.figures.curves import planar_curve
from ccgen.fixedpoint import fit as fit_of
from ccgen.joint.file import parse_joint, read_joint
from ccgen.kinematics import chain
from ccgen.shapes import single_shape

EXAMPLES = Path(__file__).parent.parent / "examples"
SHOULDER = EXAMPLES / "shoulder.toml"
WRIST = EXAMPLES / "wrist.toml"


def ccgen(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def fitted(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict:
    assert ccgen("fit", *arguments, "--json") == 0
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out)


def test_the_option_knows_every_method():
    assert tuple(Method) == FIT_METHODS


@pytest.mark.parametrize(
    ("placement", "method", "score"),
    [
        ('"single"', "direct", 17.465),
        ('"end-to-end"\ncount = 3', "direct", 5.789),
        ('"heuristic"\ncount = 3', "equal", 4.430),
        ('"heuristic"\ncount = 3', "wam", 0.0105),
    ],
)
def test_scores_of_twelve_segments_agree_with_the_reference(
    capsys, tmp_path, placement, method, score
):
    file = tmp_path / "shoulder.toml"
    text = SHOULDER.read_text()
    file.write_text(text.replace('"heuristic"\ncount = 3', placement))
    result = fitted(capsys, str(file), "--method", method)
    assert result["method"] == method
    for axis in ("u", "v"):
        assert result["axes"][axis]["score_percent_rom"] == pytest.approx(score, rel=0.01)


def test_json_holds_the_weights_and_how_well_they_do(capsys):
    result = fitted(capsys, str(WRIST))
    weights = fit_joint(read_joint(WRIST))
    assert result["method"] == "wam"
    assert set(result["axes"]) == {"u", "v"}
    for axis, figures in result["axes"].items():
        matrix = np.array(figures["weights"])
        np.testing.assert_array_equal(matrix, weights[axis].matrix)
        assert figures["spans"] == [list(span) for span in weights[axis].spans]
        assert figures["weights_range"] == [matrix.min(), matrix.max()]
        gain = np.sqrt(np.mean(np.sum(matrix**2, axis=1)))
        assert figures["noise_gain"] == pytest.approx(gain, rel=1e-12)
        assert figures["score_with_noise_percent_rom"] > figures["score_percent_rom"] > 0
    assert [len(figures["spans"]) for figures in result["axes"].values()] == [4, 2]


def test_the_score_with_noise_needs_the_noise(capsys, tmp_path):
    file = tmp_path / "shoulder.toml"
    file.write_text(SHOULDER.read_text().replace("noise =", "# noise ="))
    assert fitted(capsys, str(file))["axes"]["u"]["score_with_noise_percent_rom"] is None
    assert ccgen("fit", str(file)) == 0
    assert "not known" in capsys.readouterr().out
    assert ccgen("fit", str(file), "--method", "noise-aware") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"ccgen: error: {file}: ")
    assert err.count("\n") == 1


def test_the_table_shows_both_axes(capsys):
    assert ccgen("fit", str(WRIST)) == 0
    out = capsys.readouterr().out
    assert "wrist: wam" in out
    assert "0-2 1-4 3-6 5-7" in out
    assert "0-3 4-7" in out


def test_a_missing_file_is_named(capsys):
    assert ccgen("fit", "nowhere.toml", "--json") == 2
    assert capsys.readouterr() == (
        "",
        "ccgen: error: nowhere.toml: no such file; `ccgen init NAME` writes one that works\n",
    )


@pytest.mark.parametrize("name", ["cases.svg", "cases.png"])
def test_the_plot_is_the_same_bytes_each_time(capsys, tmp_path, name):
    files = [tmp_path / "a" / name, tmp_path / "b" / name]
    for file in files:
        assert ccgen("fit", str(SHOULDER), "--plot", str(file)) == 0
        assert capsys.readouterr().err.startswith(f"ccgen: wrote {file}\n")
    data = files[0].read_bytes()
    assert data == files[1].read_bytes()
    assert data.startswith(b"<?xml" if name.endswith("svg") else b"\x89PNG")


def noisy_joint(tables=""):
    return parse_joint(joint_text(transducer="noise = 1e-4", tables=tables), "x.toml")


def test_distances_with_noise_in_the_plot_are_those_of_readings_with_noise():
    joint = noisy_joint()
    estimator = dict(methods(fit_of(joint), "u"))["wam"]
    shape = single_shape(12, "uniform", 0.05)
    straight = planar_curve(estimator.angles(shape), 0.02)
    rng = np.random.default_rng(0)
    square = 0.0
    for noise in rng.normal(size=(2000, 3)) * estimator.noise(shape):
        read = estimator.read(shape) + noise
        moved = planar_curve(estimator.weights.estimate(read), 0.02)
        square = square + np.square(np.subtract(moved, straight)).sum(axis=0) / 2000
    told = estimator.spread(shape, 0.02)
    np.testing.assert_allclose(np.sqrt(square)[1:], told[1:], rtol=0.06)


def test_the_plot_shows_distances_with_noise_and_without_where_noise_is_stated():
    shown = case_study_figure(fit_of(noisy_joint()))
    assert shown.legends[0].get_title().get_text() == (
        "distances: RMS with sensor noise and the step of the counts; thin: without them"
    )
    for axes in shown.axes[3:]:
        thin, thick = ([x for x in axes.lines if x.get_linewidth() == w] for w in (0.6, 1.2))
        assert len(thin) == len(thick) == 3
        for without, noisy in zip(thin, thick, strict=True):
            assert np.all(noisy.get_ydata() > without.get_ydata())
    silent = case_study_figure(fit_of(parse_joint(joint_text(), "x.toml")))
    assert silent.legends[0].get_title().get_text() == ""
    assert all(len(axes.lines) == 3 for axes in silent.axes[3:])


def test_a_joint_that_is_fitted_to_loads_alone_is_drawn_under_the_cases_that_it_reaches():
    tables = "[loads]\nactuation = [-9.0, 9.0]\nsamples = 10\n[shapes]\ncases = []"
    assert len(case_study_figure(fit_of(noisy_joint(tables))).axes) == 6
    steep = parse_joint(joint_text(range_of_motion=80.0, tables=tables), "x.toml")
    titles = [axes.get_title() for axes in case_study_figure(fit_of(steep)).axes]
    assert titles[:2] == ["End force", "Uniform load"]


def test_a_curve_passes_through_the_ends_of_the_segments():
    angles = single_shape(12, "end-force", 0.05)
    deflection, height = planar_curve(angles, 0.02)
    ends = chain(angles, np.zeros(12), 0.02)[:, :3, 3]
    np.testing.assert_allclose(deflection[::8][1:], -ends[:, 1], atol=1e-15)
    np.testing.assert_allclose(height[::8][1:], ends[:, 2], atol=1e-15)
    assert (deflection[0], height[0]) == (0.0, 0.0)


def test_the_case_study_draws_figure_8():
    figure = case_study_figure(fit_of(read_joint(SHOULDER)))
    curves, errors = figure.axes[:3], figure.axes[3:]
    titles = [axes.get_title() for axes in curves]
    assert titles == ["End force", "Uniform load", "End force and moment"]
    names = ["actual", "DEM (end to end)", "E-WAM", "WAM"]
    tips = {}
    for panel, distances in zip(curves, errors, strict=True):
        assert [line.get_label() for line in panel.lines] == names
        thin = [line for line in distances.lines if line.get_linewidth() < 1.0]
        last = [float(line.get_ydata()[-1]) for line in thin]
        assert last[2] < 1e-5 < last[0] < last[1]
        tips[panel.get_title()] = float(panel.lines[0].get_xdata()[-1])
    assert tips["End force"] > tips["Uniform load"] > 0.03
    assert abs(tips["End force and moment"]) < 2e-3  # its tip stays on the unbent axis


def test_the_case_study_adds_another_method_and_knows_other_cases():
    joint = parse_joint(
        SHOULDER.read_text().replace(
            '["end-force", "uniform", "s-shape", "constant-curvature"]', '["constant-curvature"]'
        ),
        "shoulder.toml",
    )
    figure = case_study_figure(fit_of(joint, "noise-aware"))
    assert [axes.get_title() for axes in figure.axes] == ["Constant curvature", ""]
    assert [line.get_label() for line in figure.axes[0].lines][-1] == "noise-aware"


def test_the_case_study_leaves_out_dem_where_sensors_outnumber_segments():
    text = SHOULDER.read_text().replace("segments = 12", "segments = 2")
    spans = "spans = [[0, 0], [0, 1], [1, 1]]"
    joint = parse_joint(text.replace('placement = "heuristic"\ncount = 3', spans), "x.toml")
    figure = case_study_figure(fit_of(joint))
    assert [line.get_label() for line in figure.axes[0].lines] == ["actual", "E-WAM", "WAM"]


ROUND = """
name = "round"
[geometry]
segments = 6
length = 0.12
range_of_motion = 5.0
elongation = [0.0, 0.04]
[sensors.transducer]
metres_per_count = 2e-6
noise = 5e-5
[estimator]
method = "noise-aware"
"""
STRING = '[[sensor]]\nname = "s{angle}"\nspan = [0, 5]\nangle = {angle}\nradius = 0.03\n'


def test_sensors_around_the_joint_are_fitted_for_each_axis_and_elongation(capsys, tmp_path):
    file = tmp_path / "round.toml"
    file.write_text(ROUND + "".join(STRING.format(angle=angle) for angle in (90, 210, 330)))
    result = fitted(capsys, str(file))
    assert not any("cannot tell" in warning for warning in result["warnings"])
    shapes = {axis: np.array(one["weights"]).shape for axis, one in result["axes"].items()}
    assert shapes == {"u": (6, 3), "v": (6, 3), "h": (1, 3)}
    assert result["axes"]["u"]["elongation_adds_percent_rom"] == 0.0
    assert result["axes"]["h"]["rms_percent"] < result["axes"]["h"]["rms_with_noise_percent"]
    assert [row["elongation_rms_percent"] for row in result["errors"][:2]] == [
        result["axes"]["h"][key] for key in ("rms_percent", "rms_with_noise_percent")
    ]
    drawing = tmp_path / "round.svg"
    assert ccgen("fit", str(file), "--plot", str(drawing)) == 0
    out = capsys.readouterr().out
    assert "RMS / % of length" in out
    assert "│ spans" not in out
    assert drawing.stat().st_size > 1000


def test_elongation_that_sensors_on_one_side_cannot_tell_is_said(capsys, tmp_path):
    file = tmp_path / "sides.toml"
    file.write_text(ROUND + "".join(STRING.format(angle=angle) for angle in (90, 180)))
    assert ccgen("fit", str(file), "--json") == 0
    out, err = capsys.readouterr()
    assert err == ""
    (warning,) = [text for text in json.loads(out)["warnings"] if "cannot tell" in text]
    assert ccgen("fit", str(file)) == 0
    assert f"ccgen: warning: {warning}" in capsys.readouterr().err
    assert "the sensors cannot tell elongation from bending: each 1 % of it adds " in warning


def test_a_joint_that_states_no_elongation_is_told_what_it_would_add(capsys):
    axes = fitted(capsys, str(SHOULDER))["axes"]
    assert axes["u"]["elongation_adds_percent_rom"] == pytest.approx(7.639, abs=1e-3)
    assert ccgen("fit", str(SHOULDER)) == 0
    out, err = capsys.readouterr()
    assert "1 % elongation adds" in out
    assert "cannot tell" not in err


def test_the_plot_of_fit_shows_errors_along_the_joint_by_source():
    fitted = fit_of(noisy_joint())
    figure = case_study_figure(fitted, along=True)
    last = figure.axes[-1]
    assert last.get_xlabel() == "along the joint / m"
    noisy = [row for row in fitted.errors if row.noise]
    assert all(row.rms_deg["u"] == pytest.approx(row.rms_deg["v"], rel=1e-6) for row in noisy)
    told = {(row.source, "u and v"): row.rms_deg["u"] for row in noisy}
    drawn = {tuple(line.get_label().split(", ")): line.get_ydata() for line in last.lines}
    assert drawn.keys() == told.keys()
    for key, values in drawn.items():
        assert np.sqrt(np.mean(np.square(values))) == pytest.approx(told[key])
