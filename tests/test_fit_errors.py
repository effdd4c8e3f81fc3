"""Errors that are told of weights, against drawn noise; advice; what a lost sensor leaves."""

import json
import re

import numpy as np
import pytest
from joint_files import joint_text
from test_fit_sources import anywhere, drawn, paper

from ccgen.cli.main import main
from ccgen.estimation import score_percent_rom, score_with_noise_percent_rom
from ccgen.estimation.axes import estimated
from ccgen.estimation.errors import deviations, errors_of, missed, tips
from ccgen.estimation.fallback import fallback
from ccgen.estimation.sources import Source, ideal_readings
from ccgen.fixedpoint import fit
from ccgen.joint.file import parse_joint
from ccgen.kinematics import tip_pose
from ccgen.sensing.noise import told_noise
from ccgen.shapes import Shapes, score_library


def errors(fitted, source, noise):
    return next(r for r in fitted.errors if r.source == source and r.noise == noise)


def test_the_cases_row_is_the_papers_score():
    joint = paper()
    fitted = fit(joint)
    fitted.__dict__["rounding"] = {}  # the paper's score knows no fixed point
    library = score_library(joint)
    for axis, weights in fitted.weights.items():
        score = score_percent_rom(weights, library)
        noise = told_noise(joint, axis)
        noisy = score_with_noise_percent_rom(weights, library, noise)
        assert errors(fitted, "cases", False).mean_percent_rom[axis] == pytest.approx(score)
        assert errors(fitted, "cases", True).mean_percent_rom[axis] == pytest.approx(noisy)


def test_errors_with_noise_are_those_of_drawn_noise():
    joint = anywhere("[fixed_point]\nprecision = 16")
    tolerant = parse_joint(
        joint_text(transducer="noise = 2e-4\ngain_tolerance = 0.05", count=4), "shoulder.toml"
    )
    for one in (joint, tolerant):
        weights = fit(one, "noise-aware").weights
        shapes = drawn(one, 30)
        if "h" not in one.axes:
            shapes = Shapes(shapes.u, shapes.v, 0 * shapes.h, shapes.source)
        told = errors_of("drawn", missed(one, weights, shapes, True), True, False)
        random = np.random.default_rng(0)
        many = 400
        deviation = deviations(one, shapes.state)
        noise = deviation * random.standard_normal((many, *deviation.shape))
        estimate = estimated(one, weights, ideal_readings(one, shapes) + noise)
        error = estimate - shapes.state
        rom = one.geometry.range_of_motion
        for axis in ("u", "v"):
            own = error[..., one.rows(axis)]
            mean = 100 * np.abs(own).mean() / rom
            assert told.mean_percent_rom[axis] == pytest.approx(mean, rel=0.02)
            rms = np.degrees(np.sqrt((own**2).mean()))
            assert told.rms_deg[axis] == pytest.approx(rms, rel=0.02)
            bend = np.degrees(np.sqrt((own.sum(axis=-1) ** 2).mean()))
            assert told.total_bend_rms_deg[axis] == pytest.approx(bend, rel=0.03)
        off = np.linalg.norm(tips(one, estimate) - tips(one, shapes.state), axis=-1)
        assert told.tip_rms_m == pytest.approx(np.sqrt((off**2).mean()), rel=0.03)
        assert told.tip_max_m > np.percentile(off, 99)
        if "h" in one.axes:
            share = 100 * np.sqrt((error[..., 24] ** 2).mean())
            assert told.elongation_rms_percent == pytest.approx(share, rel=0.03)
        else:
            assert told.elongation_rms_percent is None


def test_a_gain_known_to_a_tolerance_errs_with_the_length():
    text = joint_text(transducer="noise = 1e-9\ngain_tolerance = 0.02", step=1e-9, bits=16)
    joint = parse_joint(text, "shoulder.toml")
    shapes = drawn(joint, 5)
    lengths = ideal_readings(joint, shapes)
    np.testing.assert_allclose(
        deviations(joint, shapes.state), 0.02 * np.abs(lengths), rtol=1e-3, atol=1e-7
    )


def test_the_tip_of_a_stretched_joint_is_that_of_the_chain():
    joint = anywhere()
    shapes = drawn(joint, 4)
    stretched = joint.geometry.segment_length * (1 + np.repeat(shapes.h, 12, axis=1))
    expected = tip_pose(shapes.u, shapes.v, stretched)[:, :3, 3]
    np.testing.assert_allclose(tips(joint, shapes.state), expected, atol=1e-15)


def test_rounding_is_part_of_errors_with_noise_alone():
    coarse = fit(
        parse_joint(joint_text(step=1e-3, bits=8, transducer="noise = 1e-9"), "coarse.toml")
    )
    assert set(coarse.rounding) == {"u", "v"}
    shapes = coarse.stated.shapes
    with_it = errors_of("", coarse.missed(Source("drawn", shapes, 0.0), True), True, False)
    bare = errors_of("", missed(coarse.joint, coarse.weights, shapes, True), True, False)
    expected = np.hypot(bare.rms_deg["u"], np.degrees(coarse.rounding["u"]))
    assert with_it.rms_deg["u"] == pytest.approx(expected)


def ccgen_fit(capsys, tmp_path, text, *arguments):
    file = tmp_path / "joint.toml"
    file.write_text(text)
    with pytest.raises(SystemExit) as end:
        main(["fit", str(file), *arguments])
    assert not end.value.code
    return capsys.readouterr()


def test_weights_of_the_cases_alone_are_told_to_be_wrong_elsewhere(capsys, tmp_path):
    text = joint_text(segments=12, count=3, range_of_motion=3.0)
    found = json.loads(ccgen_fit(capsys, tmp_path, text, "--json").out)
    rows = {(row["source"], row["noise"]): row for row in found["errors"]}
    assert set(rows) == {(s, n) for s in ("cases", "other loads") for n in (False, True)}
    for axis in ("u", "v"):
        assert 2.0 < rows["other loads", False]["mean_percent_rom"][axis] < 9.0
        assert rows["cases", False]["mean_percent_rom"][axis] < 0.02
    assert any("fitted to the load cases alone" in warning for warning in found["warnings"])
    assert [row["sensor"] for row in found["without"]] == ["u0", "u1", "u2", "v0", "v1", "v2"]


def test_tables_and_warnings_are_printed_apart(capsys, tmp_path):
    printed = ccgen_fit(capsys, tmp_path, joint_text())
    assert "other loads (held out)" in printed.out
    assert "With one sensor lost, on cases, with noise" in printed.out
    whole, *lost = re.findall(r"^│ (none|[uv]\d) +│ (.*) │ .* │ .* │$", printed.out, re.MULTILINE)
    assert [sensor for sensor, _ in lost] == ["u0", "u1", "u2", "v0", "v1", "v2"]
    assert whole[0] == "none"
    assert float(whole[1]) < 0.1 * float(lost[0][1])
    assert printed.err.startswith("ccgen: warning: the weights are fitted to the load cases alone")


def test_another_method_is_named_where_it_does_better(capsys, tmp_path):
    text = joint_text(count=6, transducer="noise = 5e-5", tables='[estimator]\nmethod = "wam"')
    warnings = json.loads(ccgen_fit(capsys, tmp_path, text, "--json").out)["warnings"]
    assert any('write method = "noise-aware"' in warning for warning in warnings)
    better = text.replace('"wam"', '"noise-aware"')
    warnings = json.loads(ccgen_fit(capsys, tmp_path, better, "--json").out)["warnings"]
    assert not any("write method" in warning for warning in warnings)


def test_a_sensor_that_adds_nothing_is_named():
    noisy = parse_joint(joint_text(count=6, transducer="noise = 5e-4"), "shoulder.toml")
    assert any("more sensors would not help" in text for text in fit(noisy, "wam").warnings)
    needed = parse_joint(joint_text(count=2, transducer="noise = 1e-5"), "shoulder.toml")
    assert not any("more sensors" in text for text in fit(needed, "wam").warnings)


def test_weights_worse_than_zero_are_told():
    noisy = parse_joint(joint_text(count=4, transducer="noise = 0.1"), "shoulder.toml")
    assert any("answering zero" in text for text in fit(noisy, "wam").warnings)
    assert not any("answering zero" in text for text in fit(noisy, "noise-aware").warnings)


def test_elongation_that_is_stated_but_not_estimated_is_warned_of():
    blind = parse_joint(
        joint_text(tables='[estimator]\naxes = ["u", "v"]').replace(
            "[sensors]", "elongation = [0.0, 0.03]\n[sensors]", 1
        ),
        "shoulder.toml",
    )
    assert any("cannot tell elongation from bending" in text for text in fit(blind).warnings)


def test_a_lost_sensor_costs_what_is_told():
    joint = paper()
    fitted = fit(joint, "noise-aware")
    row = fitted.without[4]
    assert row.sensor == "v1"
    weights = {**fitted.weights, "v": fallback(fitted.task, "v", "noise-aware", 1)}
    shapes = fitted.stated.shapes
    told = errors_of("", missed(joint, weights, shapes, True), True, False)
    assert row.rms_deg["v"] == pytest.approx(told.rms_deg["v"], rel=1e-4)
    assert row.rms_deg["u"] == errors(fitted, "cases", True).rms_deg["u"]
    assert row.rms_deg["v"] > 2 * errors(fitted, "cases", True).rms_deg["v"]


def test_an_axis_without_sensors_left_is_lost():
    row = fit(paper(count=1)).without[0]
    assert row.rms_deg["u"] is None
    assert row.rms_deg["v"] is not None
    assert row.tip_rms_m is None
