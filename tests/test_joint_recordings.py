"""What [[recordings]] of a joint file may hold, and what is said of one that is wrong."""

import math
from pathlib import Path

import pytest
from joint_files import joint_text

from ccgen.errors import InputError
from ccgen.joint.file import parse_joint, read_joint

WHOLE = """
[[recordings]]
file = "runs/run1.csv.gz"
counts = "run1.BLF"
dbc = "finger.dbc"
use = "score"
stations = { mid = 0.12, tip = 0.24 }
straight = [0, 2.0]
zero_from = [3.5, 4]
base = ["m0", "m1"]
position_noise = 2e-4
orientation_noise = 0.5
delay = -0.02
rows = [10, 999]
"""


def recording(text):
    return parse_joint(joint_text(tables=text), "finger.toml").recordings[0]


def with_keys(*lines):
    return "\n".join(['[[recordings]]\nfile = "a.csv"', *lines])


def test_every_key_is_read():
    it = recording(WHOLE)
    assert (it.file, it.counts, it.dbc, it.use) == (
        "runs/run1.csv.gz",
        "run1.BLF",
        "finger.dbc",
        "score",
    )
    assert it.stations == (("mid", 0.12), ("tip", 0.24))
    assert (it.straight, it.zero_from, it.rows) == ((0.0, 2.0), (3.5, 4.0), (10, 999))
    assert it.base == ("m0", "m1")
    assert it.position_noise == 2e-4
    assert it.orientation_noise == pytest.approx(math.radians(0.5))
    assert it.delay == -0.02


def test_a_file_alone_is_enough():
    it = recording(with_keys())
    assert it.use == "fit"
    assert it.stations == ()
    assert (it.counts, it.dbc, it.straight, it.zero_from, it.base) == (None,) * 5
    assert (it.position_noise, it.orientation_noise, it.delay, it.rows) == (None,) * 4


def test_a_delay_may_be_left_to_be_estimated():
    assert recording(with_keys('delay = "estimate"')).delay is None


def test_recordings_keep_their_order_and_a_joint_may_have_none():
    text = joint_text(tables=with_keys() + '\n[[recordings]]\nfile = "b.csv"\n')
    assert [it.file for it in parse_joint(text, "x").recordings] == ["a.csv", "b.csv"]
    assert parse_joint(joint_text(), "x").recordings == ()


def test_paths_lead_from_the_folder_of_the_joint_file(tmp_path):
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "finger.toml").write_text(joint_text(tables=WHOLE))
    it = read_joint(folder / "finger.toml").recordings[0]
    assert it.path(it.file) == folder / "runs" / "run1.csv.gz"
    assert it.path("/logs/run1.blf") == Path("/logs/run1.blf")


def test_where_a_joint_file_lies_does_not_change_the_joint(tmp_path):
    text = joint_text(tables=WHOLE)
    assert parse_joint(text, "a", tmp_path) == parse_joint(text, "b")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "[[recordings]]\nuse = 'fit'",
            'recordings[0].file: missing; write file = "run1.csv" (the path of a CSV file, '
            "relative to the joint file)",
        ),
        (
            with_keys("straigth = [0.0, 1.0]"),
            "recordings[0].straigth: unknown key; did you mean straight?",
        ),
        (
            with_keys("radius = 1.0"),
            "recordings[0].radius: unknown key here; write it in [sensors]",
        ),
        (
            with_keys('use = "scores"'),
            'recordings[0].use: "scores" is unknown; did you mean "score"?',
        ),
        (
            with_keys("stations = 0.12"),
            "recordings[0].stations: 0.12 is a decimal number; write metres from the base along "
            "the neutral axis, for each body or marker, such as { mid = 0.12, tip = 0.24 }",
        ),
        (
            with_keys('stations = { tip = "0.12" }'),
            'recordings[0].stations.tip: "0.12" is a string; write metres from the base along '
            "the neutral axis, for each body or marker, such as { mid = 0.12, tip = 0.24 }",
        ),
        (
            with_keys("stations = { tip = 240 }"),
            "recordings[0].stations.tip: 240.0 m lies outside the joint; write metres from 0 at "
            "the base to 0.24 at the tip (geometry.length)",
        ),
        (
            with_keys("stations = { tip = -0.1 }"),
            "recordings[0].stations.tip: -0.1 is too small; write metres from the base along "
            "the neutral axis, for each body or marker, such as { mid = 0.12, tip = 0.24 }",
        ),
        (
            with_keys("straight = [2.0, 0.5]"),
            "recordings[0].straight: [2.0, 0.5] is reversed; write the earlier time first, in "
            "seconds",
        ),
        (
            with_keys("zero_from = [2, 2]"),
            "recordings[0].zero_from: [2.0, 2.0] is empty; write the earlier time first, in "
            "seconds",
        ),
        (
            with_keys("straight = [2.0]"),
            "recordings[0].straight: [2.0] has 1 item; write the seconds from which to which the "
            "joint was straight, such as straight = [0.0, 2.0]",
        ),
        (with_keys("rows = [9, 3]"), "recordings[0].rows: [9, 3] is reversed; write [3, 9]"),
        (
            with_keys("rows = [-1, 3]"),
            "recordings[0].rows[0]: -1 is too small; write the first and the last row to use, "
            "counted from 0 behind the header, such as rows = [0, 999]",
        ),
        (
            with_keys('base = ["m0", "m0"]'),
            'recordings[0].base: ["m0", "m0"] is one marker; write two, such as ["m0", "m1"]',
        ),
        (
            with_keys("position_noise = 0"),
            "recordings[0].position_noise: 0 is too small; write one standard deviation of a "
            "coordinate in metres, from 1e-9 to 1, such as position_noise = 0.0002",
        ),
        (
            with_keys('delay = "none"'),
            'recordings[0].delay: "none" is a string; write seconds by which the sensors lag, or '
            '"estimate", such as delay = 0.05',
        ),
        (
            with_keys("delay = nan"),
            "recordings[0].delay: nan is not finite; write seconds by which the sensors lag, or "
            '"estimate", such as delay = 0.05',
        ),
        (
            with_keys('counts = "a.blf"'),
            "recordings[0].dbc: missing, but counts is a CAN log; write the DBC file that "
            'describes it, such as dbc = "finger.dbc"',
        ),
        (
            with_keys('counts = "b.csv"', 'dbc = "a.dbc"'),
            "recordings[0].dbc: describes CAN logs, but counts is none; write a file that ends in "
            ".blf, .asc, .log there, or remove dbc",
        ),
        (
            '[[recordings]]\nfile = "a.asc"',
            'recordings[0].file: "a.asc" is a CAN log; write the CSV file of the reference there, '
            "and the log as counts",
        ),
        (
            '[recordings]\nfile = "a.csv"',
            "recordings: is a table; write at most 100 tables, such as [[recordings]]",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text, says):
    with pytest.raises(InputError) as error:
        recording(text)
    assert str(error.value) == f"finger.toml: {says}"


def test_a_key_of_a_recording_elsewhere_is_sent_home():
    text = joint_text(tables="[estimator]\norientation_noise = 1.0")
    with pytest.raises(InputError, match=r"unknown key here; write it in \[\[recordings\]\]$"):
        parse_joint(text, "x.toml")
