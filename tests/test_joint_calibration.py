"""What a calibration file changes of a joint, and what is said of one that is not the joint's."""

import re
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_files import joint_text

import ccgen
from ccgen.errors import InputError
from ccgen.export.package import export
from ccgen.joint.calibration import Calibration, SensorCalibration, sensors_fingerprint
from ccgen.joint.calibration_file import calibration_text, parse_calibration, uncalibrated
from ccgen.joint.file import parse_joint, read_joint
from ccgen.targets.exported import open_exported

FILE = "finger.calibration.toml"
FOUND = SensorCalibration("u0", 2.05e-6, 1.5e-8, 11.6, 0.25, 4.0e-5, 1.0e-6)


def text(key=f'calibration = "{FILE}"', **changes):
    return f"{key}\n" + joint_text(name="finger", **changes)


def stated(**changes):
    return parse_joint(text(**changes), "finger.toml", calibrations=uncalibrated)


def calibration(sensors=(FOUND,), **changes):
    return Calibration("finger", sensors_fingerprint(stated(**changes)), sensors)


def refusal(joint, found):
    with pytest.raises(InputError) as error:
        parse_joint(joint, "finger.toml", calibrations=lambda _: calibration_text(found).encode())
    said = str(error.value)
    assert "\n" not in said
    return said


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "finger.toml").write_text(text())
    (tmp_path / FILE).write_text(calibration_text(calibration()))
    return tmp_path


def test_a_file_says_what_was_found_to_twelve_digits():
    whole = Calibration(
        "finger",
        "00ff",
        (replace(FOUND, metres_per_count=-1 / 3e5), SensorCalibration("v0", zero=-3.0)),
        -0.0125,
        1e-3,
        (('a "b" é.csv', "12"),),
    )
    back = parse_calibration(calibration_text(whole).encode(), FILE)
    assert back.sensors[0].metres_per_count == pytest.approx(-1 / 3e5, rel=1e-12)
    assert replace(back, sensors=()) == replace(whole, sensors=())
    assert back.sensors[1] == whole.sensors[1]


def test_gain_zero_and_noise_replace_those_of_the_joint_file(folder):
    joint, plain = ccgen.load(folder / "finger.toml"), stated()
    assert joint.sensors[0] == replace(
        plain.sensors[0], metres_per_count=2.05e-6, zero=12, noise=4.0e-5
    )
    assert joint.sensors[1:] == plain.sensors[1:]
    assert (joint.u.transducer, joint.v) == (None, plain.v)
    assert joint.calibration == FILE
    assert ccgen.parse(text(), folder) == joint


def test_what_was_not_found_stays_as_the_joint_file_states_it():
    changes = {"transducer": "zero = 5\nnoise = 1e-5\ngain_tolerance = 0.02"}
    found = calibration((SensorCalibration("v1", zero=-7.2),), **changes)
    joint = parse_joint(
        text(**changes), "x.toml", calibrations=lambda _: calibration_text(found).encode()
    )
    assert joint.sensors[4] == replace(stated(**changes).sensors[4], zero=-7)
    assert joint.sensors[0].zero == 5


def test_noise_that_was_found_is_enough_to_weigh_by():
    tables = '[estimator]\nmethod = "noise-aware"'
    with pytest.raises(InputError, match=r"sensors\.transducer\.noise: missing"):
        parse_joint(text(key="", tables=tables), "finger.toml")
    names = [f"{axis}{j}" for axis in "uv" for j in range(3)]
    found = Calibration(
        "finger",
        sensors_fingerprint(parse_joint(text(key=""), "finger.toml")),
        tuple(SensorCalibration(name, noise=2e-5) for name in names),
    )
    data = calibration_text(found).encode()
    joint = parse_joint(text(tables=tables), "finger.toml", calibrations=lambda _: data)
    assert {sensor.noise for sensor in joint.sensors} == {2e-5}
    assert joint.u.transducer.noise == 2e-5


@pytest.mark.parametrize(
    "changes", [{"radius": 0.051}, {"count": 4}, {"step": 2.1e-6}, {"length": 0.25}, {"bits": 15}]
)
def test_a_calibration_of_other_sensors_is_refused(changes):
    assert refusal(text(**changes), calibration()) == (
        "finger.toml: calibration: is older than the sensors, which the joint file states "
        "otherwise now; run `ccgen calibrate finger.toml` again, or remove the key"
    )


@pytest.mark.parametrize(
    "transducer", ["zero = 7", "noise = 1e-3", "gain_tolerance = 0.1", "range = [-9000, 9000]"]
)
def test_keys_that_it_replaces_or_does_not_concern_do_not_outdate_it(transducer):
    data = calibration_text(calibration()).encode()
    joint = parse_joint(text(transducer=transducer), "x.toml", calibrations=lambda _: data)
    assert joint.sensors[0].zero == 12


def test_a_calibration_of_another_joint_is_refused():
    assert refusal(text(), replace(calibration(), joint="wrist")) == (
        'finger.toml: calibration: is of joint "wrist", this one is "finger"; name the file of '
        "this joint, or run `ccgen calibrate finger.toml` again"
    )


@pytest.mark.parametrize(
    ("found", "says"),
    [
        (SensorCalibration("w0", zero=1.0), 'the joint has no sensor "w0"'),
        (SensorCalibration("u1", zero=4e4), r'zero 40000 of sensor "u1" is no count from -32767'),
    ],
)
def test_values_that_the_sensors_cannot_have_are_refused(found, says):
    assert re.match(f"finger.toml: calibration: {says}", refusal(text(), calibration((found,))))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("format = 1", "format = 2", f"{FILE}: format: 2 is too large; write 1, such as"),
        ("noise = 4e-05", "noise = -1.0", rf"{FILE}: sensor\[0\]\.noise: -1\.0 is too small"),
        ("metres_per_count = 2.05e-06", "metres_per_count = 0.0", r".*metres_per_count: 0\.0 is"),
        ("metres_per_count = 2.05e-06", "gain = 1.0", r".*gain: unknown key"),
        ("zero = 11.6", "zero = nan", r".*zero: nan is not finite"),
        ("[[sensor]]", "[[sensor]", r".*line 8"),
        ('joint = "finger"', "", rf"{FILE}: joint: missing"),
    ],
)
def test_damaged_files_are_one_line_with_the_remedy(folder, old, new, says):
    file = folder / FILE
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(InputError) as error:
        read_joint(folder / "finger.toml")
    assert re.match(f"{folder}/finger.toml: calibration: {says}", str(error.value))
    assert "\n" not in str(error.value)


def test_a_sensor_stands_in_the_file_once():
    said = refusal(text(), calibration((FOUND, FOUND)))
    assert 'sensor[0].name: "u0" stands there twice' in said


def test_a_missing_file_is_told_with_the_key(folder):
    (folder / FILE).unlink()
    with pytest.raises(InputError) as error:
        ccgen.load(folder / "finger.toml")
    assert str(error.value) == (
        f"{folder}/finger.toml: calibration: {folder}/{FILE}: no such file; "
        "`ccgen calibrate JOINT` writes one"
    )


def test_an_exported_folder_holds_the_calibration_and_works_without_it(folder):
    alike = tuple(
        replace(FOUND, name=f"{axis}{j}", zero=None, zero_std=None)
        for axis in "uv"
        for j in range(3)
    )
    (folder / FILE).write_text(calibration_text(calibration(alike)))
    joint = ccgen.load(folder / "finger.toml")
    export(joint, folder / "out")
    (folder / FILE).unlink()
    (folder / "finger.toml").unlink()
    exported = open_exported(folder / "out")
    assert exported.joint == joint
    assert exported.changed == ()
    assert read_joint(folder / "out" / "joint.toml") == joint
    (folder / "out" / FILE).unlink()
    assert open_exported(folder / "out").joint.sensors == stated().sensors
    assert open_exported(folder / "out").changed == (FILE,)


WHOLE = calibration_text(
    Calibration("finger", "00ff", (FOUND, SensorCalibration("v0", zero=3.0)), 0.01, 1e-3)
)


@settings(max_examples=200)
@given(st.integers(0, len(WHOLE)), st.text(max_size=4), st.integers(0, 10))
def test_damaged_text_is_a_calibration_or_one_line(place, inserted, removed):
    data = (WHOLE[:place] + inserted + WHOLE[place + removed :]).encode("utf-8", "replace")
    try:
        parse_calibration(data, FILE)
        said = f"{FILE}: sound"
    except InputError as error:
        said = str(error)
    assert re.fullmatch(rf"{FILE}: [^\n\r]+", said)
