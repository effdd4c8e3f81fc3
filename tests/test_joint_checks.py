"""The checks of a whole joint: keys, what is told by `fit`, and what `place` shows of faults."""

import json

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.cli.main import main
from ccgen.errors import InputError
from ccgen.fixedpoint.consistency import NOBODY

LOADS = """\
[loads]
samples = 300
stiffness = 0.4
stiffness_tolerance = 0.1
actuation = [-36.0, 36.0]
mass = 0.2
payload = [0.0, 0.25]
tip_force = [0.0, 4.0]
tip_moment = [0.0, 0.2]
contact = [0.0, 6.0]
contact_from = 0.05
"""
NOISE = "noise = 3.14e-5\ngain_tolerance = 0.005"


def loaded(estimator="false_alarms = 1e-4", loads=LOADS, **changes):
    tables = f'{loads}[estimator]\nmethod = "noise-aware"\n{estimator}'
    return joint_text(**{"count": 8, "transducer": NOISE, "tables": tables} | changes)


@pytest.fixture(scope="module")
def fit():
    return ccgen.fit(ccgen.parse(loaded()))


def read_by(fit, count, seed):
    """Lengths of a sound joint, of the shapes that its loads give."""
    from ccgen.estimation.consistency.population import sound_readings

    sound = sound_readings(fit.joint, fit.shapes)
    random = np.random.default_rng(seed)
    rows = random.choice(len(sound.weight), size=count, p=sound.weight)
    noise = random.normal(size=(count, sound.sensors)) * np.sqrt(sound.variance[rows])
    return sound.lengths[rows] + noise


def counted(fit, lengths):
    step = np.array([sensor.metres_per_count for sensor in fit.joint.sensors])
    return np.rint(lengths / step).astype(np.int64)


def test_false_alarms_of_a_joint_with_loads_come_at_the_stated_rate(fit):
    alarms = 0
    for seed in range(5):
        counts = counted(fit, read_by(fit, 200_000, seed))
        found = [group.verdicts(counts[:, group.own])[0] for group in fit.checks.groups]
        alarms += int(np.any(found, axis=0).sum())
    assert 0.5e-4 <= alarms / 1_000_000 <= 2e-4


def test_faults_are_seen_at_the_told_size_and_named_where_they_are_told_isolable(fit):
    lengths = read_by(fit, 20_000, seed=9)
    assert any(row.isolable for row in fit.checks.sensors)
    for group in fit.checks.groups:
        for j in range(group.sensors):
            row = fit.checks.sensors[group.first + j]
            for sign in (-1, 1):
                faulty = lengths[:, group.own].copy()
                faulty[:, j] += sign * row.detectable_m
                alarm, named = group.verdicts(np.rint(faulty / 2e-6).astype(np.int64))
                assert alarm.mean() >= 0.98
                if row.isolable:
                    assert np.mean(named == j) >= 0.95
                assert np.mean((named != j) & (named != NOBODY)) <= 0.06


def test_two_axes_are_two_groups_of_their_own_sensors(fit):
    assert [group.own for group in fit.checks.groups] == [slice(0, 8), slice(8, 16)]
    assert [row.sensor for row in fit.checks.sensors[:2]] == ["u0", "u1"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (loaded(loads=""), "the load cases alone do not show"),
        (joint_text(tables=LOADS), "the noise of sensor u0 is not stated"),
        (loaded(count=2, estimator=""), "sensors u0, u1 are not checked: they are too few"),
    ],
)
def test_what_cannot_be_checked_is_left_out_and_said(text, why):
    checks = ccgen.fit(ccgen.parse(text)).checks
    assert checks.groups == ()
    assert why in checks.notes[0]


def test_a_check_that_is_not_wanted_is_left_out_in_silence():
    checks = ccgen.fit(ccgen.parse(loaded("check = false"))).checks
    assert (checks.groups, checks.sensors, checks.notes) == ((), (), ())


def test_keys_of_the_estimator_have_their_defaults():
    joint = ccgen.parse(joint_text())
    assert (joint.fallback, joint.check, joint.false_alarms) == (True, True, 1e-6)


@pytest.mark.parametrize(
    "line", ["false_alarms = 0.0", "false_alarms = 1.0", 'check = "yes"', "fallback = 2"]
)
def test_other_values_are_refused_by_their_key(line):
    with pytest.raises(InputError, match=rf"estimator\.{line.split()[0]}"):
        ccgen.parse(joint_text(tables=f"[estimator]\n{line}"))


def run(capsys, tmp_path, command, text, *options):
    file = tmp_path / "joint.toml"
    file.write_text(text)
    with pytest.raises(SystemExit) as end:
        main([command, str(file), *options])
    assert not end.value.code
    return capsys.readouterr()


def test_fit_tells_the_faults_of_each_sensor(capsys, tmp_path):
    text = loaded(count=6)
    told = json.loads(run(capsys, tmp_path, "fit", text, "--json").out)
    assert [row["sensor"] for row in told["checks"]] == [f"{a}{j}" for a in "uv" for j in range(6)]
    assert all(row["detectable_m"] > 0 for row in told["checks"])
    assert all(isinstance(row["isolable"], bool) for row in told["checks"])
    shown = run(capsys, tmp_path, "fit", text).out
    assert "Faults that are seen, at 0.0001 false alarms a snapshot" in shown


def test_fit_says_why_nothing_is_checked(capsys, tmp_path):
    told = run(capsys, tmp_path, "fit", joint_text(transducer=NOISE), "--json")
    assert json.loads(told.out)["checks"] == []
    assert "load cases alone" in json.loads(told.out)["unchecked"][0]
    assert told.err == ""
    shown = run(capsys, tmp_path, "fit", joint_text(transducer=NOISE))
    assert "the sensors are not checked: the load cases alone" in shown.out
    assert "not checked" not in shown.err


def test_place_shows_that_overlap_makes_faults_visible(capsys, tmp_path):
    text = loaded(count=6, transducer="noise = 3.77e-5", estimator="false_alarms = 1e-6")
    seen = {}
    for method in ("heuristic", "end-to-end"):
        told = run(capsys, tmp_path, "place", text, "--method", method, "--json").out
        seen[method] = json.loads(told)["visible_faults_percent"]
    assert max(seen["heuristic"]) < 16
    assert min(seen["end-to-end"]) > min(seen["heuristic"])
    assert max(seen["end-to-end"]) > 21
