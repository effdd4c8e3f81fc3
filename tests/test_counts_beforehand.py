"""Counts that run out: said before recordings are learned from, with a remedy that can be done."""

import json
import re

import numpy as np
import pytest
from joint_files import joint_text
from test_fit_recordings import ROWS, STEP, angle_columns, bends, counted, table

import ccgen
from ccgen.cli.main import main
from ccgen.errors import FormatError, InputError
from ccgen.fixedpoint import fitted
from ccgen.fixedpoint.beforehand import check_counts
from ccgen.joint.calibration import Calibration, SensorCalibration, sensors_fingerprint
from ccgen.joint.calibration_file import calibration_text, uncalibrated
from ccgen.joint.file import parse_joint

FILE = "shoulder.calibration.toml"
NAMES = ("u0", "u1", "u2", "v0", "v1", "v2")
ZERO = 900
"""Recorded; the sensor in the middle moves by 785 counts to either side."""
STRAIGHT = "straight = [0.0, 0.9]"


def written(folder, transducer, zeros=None, gain=1.0, recorded="", step=STEP):
    """A joint file of raw counts of 11 bits, 0 to 2047, and its recording.

    Args:
        transducer: more keys of the transducer.
        zeros: of a calibration file, by sensor; none without.
        gain: of the recorded counts.
        recorded: keys of the recording.
        step: metres per count, as stated.
    """
    u, v = bends(4, size=1.0), bends(5, size=1.0)
    u[:50] = v[:50] = 0.0
    columns = counted(ccgen.parse(joint_text(step=STEP)), u, v, gain, 0.0)
    columns = {name: count + ZERO for name, count in columns.items()}
    run = {"t": np.arange(ROWS) * 0.02} | columns | angle_columns(u, v)
    (folder / "run.csv").write_text(table(run))
    key = "" if zeros is None else f'calibration = "{FILE}"\n'
    text = key + joint_text(
        bits=11, step=step, transducer=f"signed = false\n{transducer}",
        tables=f'[[recordings]]\nfile = "run.csv"\n{recorded}\n',
    )  # fmt: skip
    if zeros is not None:
        plain = parse_joint(text, "shoulder.toml", folder, calibrations=uncalibrated)
        found = tuple(SensorCalibration(name, STEP, zero=zeros.get(name, 1024)) for name in NAMES)
        whole = Calibration("shoulder", sensors_fingerprint(plain), found)
        (folder / FILE).write_text(calibration_text(whole))
    path = folder / "shoulder.toml"
    path.write_text(text)
    return path


@pytest.fixture
def learned(monkeypatch):
    """How often recordings were learned from."""
    calls, learn = [], fitted.recorded

    def counted_calls(*args, **options):
        calls.append(args)
        return learn(*args, **options)

    monkeypatch.setattr(fitted, "recorded", counted_calls)
    return calls


def run(*words):
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return int(end.value.code or 0)


def test_a_calibrated_zero_is_refused_before_recordings_are_learned_from(tmp_path, learned):
    path = written(tmp_path, "zero = 1024", zeros={"v1": 100})
    with pytest.raises(FormatError) as refused:
        ccgen.export(path, tmp_path / "out")
    assert not learned
    said = re.match(
        rf"(.*)shoulder\.toml: calibration: sensor 1 of axis v \(span .*\) would run out of counts "
        rf"over the range of motion with its zero at 100, as {re.escape(FILE)} tells; set the "
        r"sensor so that it counts (\d+) to (\d+) where the joint is straight and run "
        r"`ccgen calibrate .*shoulder\.toml` again, or lower geometry\.range_of_motion$",
        str(refused.value),
    )
    low, high = int(said[2]), int(said[3])
    assert check_counts(ccgen.load(written(tmp_path, "", zeros={"v1": low, "u2": high}))) == ()
    with pytest.raises(FormatError, match=rf"its zero at {low - 1}"):
        check_counts(ccgen.load(written(tmp_path, "", zeros={"v1": low - 1})))


def test_what_is_refused_beforehand_is_what_would_be_afterwards(tmp_path):
    joint = ccgen.load(written(tmp_path, "", zeros={"v1": 100}))
    with pytest.raises(FormatError) as before:
        check_counts(joint)
    with pytest.raises(FormatError) as after:
        _ = ccgen.fit(joint).model
    assert str(before.value) == str(after.value)


def test_a_stated_zero_is_refused_beforehand_where_nothing_is_learned_of_sensors(tmp_path, learned):
    path = written(tmp_path, "zero = 100", recorded='use = "score"')
    with pytest.raises(FormatError, match=r"transducer\.zero: .* at 100; write a zero from \d+ to"):
        ccgen.export(path, tmp_path / "out")
    assert not learned


def test_a_zero_of_a_recording_is_to_be_recorded_again(tmp_path):
    narrow = written(tmp_path, "range = [150, 2047]", recorded=STRAIGHT)
    joint = ccgen.load(narrow)
    assert check_counts(joint) == ()
    with pytest.raises(FormatError) as refused:
        _ = ccgen.fit(joint).model
    assert re.search(
        r"shoulder\.toml: recordings: sensor \d of axis u \(span .*\) would run out of counts over "
        r"the range of motion with its zero at 900, as the recordings tell; set the sensor so that "
        r"it counts \d+ to \d+ where the joint is straight and record it again, or lower "
        r"geometry\.range_of_motion$",
        str(refused.value),
    )


def _refuse(*_, **__):
    raise InputError("not learned from")


def test_too_few_counts_by_the_stated_gain_are_told_at_once(tmp_path, monkeypatch, capsys):
    path = written(tmp_path, "", step=STEP / 8.0, recorded=STRAIGHT)
    (said,) = check_counts(ccgen.load(path))
    assert re.search(
        r"needs \d+ counts over the range of motion and has 2047; .*; no fixed point can be "
        r"exported unless recordings tell other gains$",
        said,
    )
    monkeypatch.setattr(fitted, "recorded", _refuse)
    for words in (("fit", path, "--json"), ("export", path, "-o", tmp_path / "out")):
        assert run(*words) == 2
        told = capsys.readouterr().err
        assert 0 <= told.find(f"warning: {said}") < told.find("not learned from")


def test_too_few_counts_by_the_stated_gain_are_no_hindrance_where_the_recorded_one_suits(tmp_path):
    path = written(tmp_path, "", step=STEP / 4.0, recorded=STRAIGHT)
    joint = ccgen.load(path)
    assert check_counts(joint)
    done = ccgen.export(joint, tmp_path / "out")
    assert (done.model.readings.zero == ZERO).all()


def test_fit_warns_once_of_what_it_said_before(tmp_path, capsys):
    path = written(tmp_path, "", zeros={"v1": 100})
    assert run("fit", path) == 0
    assert capsys.readouterr().err.count("would run out of counts") == 1
    assert run("fit", path, "--json") == 0
    shown = capsys.readouterr()
    told = [one for one in json.loads(shown.out)["warnings"] if "run out of counts" in one]
    assert len(told) == 1
    assert f"warning: {told[0]}" in shown.err
    assert told[0].endswith("as it is, no fixed point can be exported")


def test_a_fit_that_cannot_be_kept_is_refused_before_it_is_learned(tmp_path, learned, capsys):
    path = written(tmp_path, "", zeros={"v1": 100})
    assert run("fit", path, "--write") == 2
    assert "would run out of counts" in capsys.readouterr().err
    assert not learned


def test_load_cases_alone_may_bend_less_than_the_range_of_motion(tmp_path):
    path = written(tmp_path, "zero = 600", recorded='use = "score"')
    with pytest.raises(FormatError):
        check_counts(ccgen.load(path))
    path.write_text(path.read_text() + '[shapes]\ncases = ["end-force"]\n')
    joint = ccgen.load(path)
    assert check_counts(joint) == ()
    assert ccgen.fit(joint).model
