"""Weights from markers and counts, judged at the markers on blocks that were held out."""

import json
import tomllib

import numpy as np
import pytest
from test_recordings_bodies import KEYS, STATIONS, STRAIGHT, M, joint, written

import ccgen
from ccgen.cli.fit_output import show_fit
from ccgen.estimation.fit import fit_task
from ccgen.fixedpoint.kept import kept_fit, rounded, write_fit
from ccgen.kinematics.stations import places, seen_from_base


def read(folder, method, keys=KEYS + STRAIGHT):
    text = joint(("run.csv", keys), folder=folder).content.decode()
    noise = "[sensors.transducer]\nnoise = 5e-5\ngain_tolerance = 0.03"
    text = text.replace("[sensors.transducer]", noise) + f'[estimator]\nmethod = "{method}"\n'
    path = folder / "finger.toml"
    path.write_text(text)
    return ccgen.load(path)


@pytest.fixture(scope="module")
def counted(tmp_path_factory):
    """True states, and the fit to markers and counts."""
    folder = tmp_path_factory.mktemp("counted")
    state = written(folder, rows=240)
    return state, ccgen.fit(read(folder, "noise-aware"))


def held_out(fitted, method):
    """Estimates of every row by weights that do not know its block, shape (N, 2 M + 1)."""
    recorded = fitted.recorded
    truth = recorded.whole.found.references[0]
    found = recorded.judged(0, True, lambda block: fit_task(block.task, method))
    return np.concatenate([part.estimate for part in found.parts]), truth, found


def rms(values):
    return float(np.sqrt(np.nanmean(np.square(values))))


@pytest.mark.parametrize("method", ["noise-aware", "wam"])
def test_what_is_told_at_the_stations_of_held_out_blocks_is_what_the_truth_shows(counted, method):
    state, fitted = counted
    estimate, truth, found = held_out(fitted, method)
    for axis in ("u", "v"):
        rows = fitted.joint.rows(axis)
        assert rms(estimate[:, rows] - state[:, rows]) < np.radians(0.5)
        assert not np.isnan(found.known(axis)).all()
    at = places(list(STATIONS.values()), (M,), 0.24 / M)
    wide = [np.pad(one, ((0, 0), (0, 1))) for one in (estimate, state)]
    apart = np.linalg.norm(np.subtract(*(seen_from_base(x, at).position for x in wide)), axis=2)
    for b, told in enumerate(truth.stations(estimate).values()):
        known = rms(apart[:, b])
        slack = 1e-4  # half of the markers' own noise, which is taken off
        assert known / 1.3 - slack < told.position_rms_m < 1.3 * known + slack


def test_a_recording_of_markers_tells_its_stations(counted):
    _, fitted = counted
    (row,) = (row for row in fitted.errors if row.source == "recording:run.csv")
    assert row.noise
    assert row.held_out
    record = row.record()
    assert list(record["stations"]) == list(STATIONS)
    assert set(record["stations"]["tip"]) == {
        "position_rms_m", "bend_rms_deg", "arc_length_rms_m",
    }  # fmt: skip
    assert 0 < record["stations"]["tip"]["position_rms_m"] < 5e-3
    json.dumps(record, allow_nan=False)
    assert any("hold the most probable shapes for true" in said for said in fitted.warnings)


def test_the_tip_of_a_joint_that_twists_is_told_where_it_is(tmp_path):
    written(tmp_path, rows=240, twist=0.2)
    (row,) = (
        row
        for row in ccgen.fit(read(tmp_path, "noise-aware")).errors
        if row.source == "recording:run.csv"
    )
    measured = row.stations["tip"].position_rms_m
    assert measured > 2e-3
    assert row.tip_rms_m == pytest.approx(measured, rel=0.1)


def test_gains_from_markers_and_counts_go_into_the_exported_weights(counted):
    _, fitted = counted
    reference = fitted.found.references[0]
    for j, (sensor, stated) in enumerate(zip(fitted.sensors, fitted.joint.sensors, strict=True)):
        gain = stated.metres_per_count / sensor.metres_per_count
        assert gain == pytest.approx(reference.gain[j])
        assert sensor.zero == round(reference.zero[j] / stated.metres_per_count)
    np.testing.assert_array_equal(
        fitted.model.readings.zero, [sensor.zero for sensor in fitted.sensors]
    )


def test_markers_tell_where_the_joint_is_stiff(counted, capsys):
    _, fitted = counted
    told = fitted.found.stiffness
    assert np.mean(told.profile) == pytest.approx(1.0)
    assert len(told.profile) == len(told.std)
    first = len(told.profile) // M  # the first of M segments is twice as stiff as the others
    assert np.mean(told.profile[:first]) > 1.2 * np.mean(told.profile[first:-first])
    line, sure = told.lines
    values = tomllib.loads(line)["stiffness_profile"]
    assert values == pytest.approx(told.profile, abs=0.006)
    assert sure.count(",") == len(values) - 1
    show_fit(fitted, {})
    assert "shapes alone do not tell loads.stiffness" in capsys.readouterr().out


def test_the_stiffness_profile_is_kept_with_the_fit(counted):
    _, fitted = counted
    kept = json.loads(write_fit(rounded(fitted)).read_text())["stiffness_profile"]
    assert kept["profile"] == pytest.approx(fitted.found.stiffness.profile, rel=1e-11)
    assert kept["std"] == pytest.approx(fitted.found.stiffness.std, rel=1e-11)


def test_stations_are_kept_with_the_fit(counted):
    _, fitted = counted
    write_fit(rounded(fitted))
    kept = kept_fit(fitted.joint).fit
    told = {row.source: row.record() for row in kept.errors}["recording:run.csv"]["stations"]
    assert told.keys() == STATIONS.keys()
    first = {row.source: row for row in fitted.errors}["recording:run.csv"].stations["tip"]
    assert told["tip"]["position_rms_m"] == pytest.approx(first.position_rms_m, rel=1e-6)


def test_markers_alone_tell_shapes_on_which_readings_are_simulated(tmp_path):
    written(tmp_path, counts=False, rows=100)
    fitted = ccgen.fit(read(tmp_path, "wam"))
    rows = [row for row in fitted.errors if row.source == "recording:run.csv"]
    assert [row.noise for row in rows] == [False, True]
    assert list(rows[0].stations) == list(STATIONS)
    assert fitted.sensors[0].metres_per_count == fitted.joint.sensors[0].metres_per_count
    assert rows[1].rms_deg["u"] < 1.5
