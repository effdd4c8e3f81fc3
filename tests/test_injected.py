"""Faults that are put into counts: what they do, and what is refused."""

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.errors import ArgumentError
from ccgen.sensing.injected import read_fault, with_faults

NONE = -(2**15)
TIMES = np.arange(10) / 10.0


@pytest.fixture(scope="module")
def joint():
    return ccgen.parse(joint_text())


def counts():
    return np.arange(60).reshape(10, 6) * 10


def faulty(joint, *texts, sent=None):
    faults = [read_fault(text, joint) for text in texts]
    return with_faults(joint, counts() if sent is None else sent, TIMES, faults, NONE)


def changed(found):
    """Sensor and first row of what is not as it was."""
    rows, columns = np.nonzero(found != counts())
    return {int(j): int(rows[columns == j].min()) for j in set(columns)}


def test_a_lost_sensor_has_no_reading_from_its_moment_on(joint):
    found = faulty(joint, "u1=lost@0.45")
    assert changed(found) == {1: 5}
    assert (found[5:, 1] == NONE).all()


def test_a_stuck_sensor_stays_where_it_was(joint):
    found = faulty(joint, "v2=stuck@0.3")
    assert changed(found) == {5: 4}
    assert (found[3:, 5] == counts()[3, 5]).all()


@pytest.mark.parametrize("metres", [0.001, -0.001])
def test_an_offset_is_told_in_metres(joint, metres):
    found = faulty(joint, f"u0=offset:{metres}@0")
    assert (found[:, 0] - counts()[:, 0] == round(metres / 2e-6)).all()
    assert changed(found) == {0: 0}


def test_an_offset_of_a_falling_transducer_lowers_its_counts():
    joint = ccgen.parse(joint_text(step=-2.0e-6))
    assert (faulty(joint, "u0=offset:0.001@0")[:, 0] == counts()[:, 0] - 500).all()


def test_counts_do_not_leave_the_transducer(joint):
    assert (faulty(joint, "u0=offset:9e9@0")[:, 0] == 2**15 - 1).all()
    assert (faulty(joint, "u0=offset:-9e9@0")[:, 0] == -(2**15) + 1).all()


def test_an_offset_gives_no_reading_to_a_sensor_that_has_none(joint):
    sent = counts()
    sent[7, 0] = NONE
    assert faulty(joint, "u0=offset:0.001@0", sent=sent)[7, 0] == NONE


def test_of_one_sensor_the_later_fault_acts_on_what_is_there(joint):
    found = faulty(joint, "u0=lost@0.8", "u0=stuck@0.5", "u0=offset:0.001@0.2")
    assert found[:, 0].tolist() == [
        0,
        60,
        *[60 * k + 500 for k in (2, 3, 4)],
        *[800] * 3,
        NONE,
        NONE,
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("u0", "u0: is not of the form SENSOR=stuck@SECONDS, SENSOR=lost@SECONDS or SENSOR=offset"),
        ("u0=stuck", "is not of the form"),
        ("", "is not of the form"),
        ("u9=stuck@1", "no sensor is called 'u9'; give one of u0, u1, u2, v0, v1, v2"),
        ("=stuck@1", "no sensor is called ''"),
        ("u0=broken@1", "'broken' is no fault; write SENSOR=stuck"),
        ("u0=stuck:1@1", "'stuck:1' is no fault"),
        ("u0=offset@1", "'offset' is no fault"),
        ("u0=offset:@1", "'' is no number of metres"),
        ("u0=offset:nan@1", "'nan' is no number of metres"),
        ("u0=offset:1mm@1", "'1mm' is no number of metres"),
        ("u0=offset:9e-7@1", "is less than half a count; give at least 1e-06 m"),
        ("u0=lost@", "'' is no number of seconds"),
        ("u0=lost@inf", "'inf' is no number of seconds"),
        ("u0=lost@-1", "begins 1 s before the first snapshot; give seconds from 0"),
    ],
)
def test_what_is_no_fault_is_refused_with_what_would_be(joint, text, said):
    with pytest.raises(ArgumentError) as refused:
        read_fault(text, joint)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_fault_after_the_last_snapshot_is_refused(joint):
    with pytest.raises(ArgumentError, match=r"u0=lost@2: begins after the last snapshot, at 0.9 s"):
        faulty(joint, "u0=lost@2")
