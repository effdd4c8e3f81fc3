"""Counts from logs of the bus, written by python-can and described by a DBC."""

import can
import numpy as np
import pytest

from ccgen.e2e import P01
from ccgen.errors import InputError
from ccgen.recordings.can_log import read_can_log

DBC = """\
VERSION ""
BU_: SENSORS JOINT
BO_ 768 FINGER_LENGTHS_0: 8 SENSORS
 SG_ crc : 0|8@1+ (1,0) [0|255] "" JOINT
 SG_ counter : 8|4@1+ (1,0) [0|14] "" JOINT
 SG_ length_near : 16|16@1- (2e-06,0) [-0.06|0.06] "m" JOINT
 SG_ length_far : 32|16@1- (2e-06,0) [-0.06|0.06] "m" JOINT
BO_ 769 FINGER_LENGTHS_1: 8 SENSORS
 SG_ crc : 0|8@1+ (1,0) [0|255] "" JOINT
 SG_ counter : 8|4@1+ (1,0) [0|14] "" JOINT
 SG_ length_side : 16|16@1+ (2e-06,0) [0|0.13] "m" JOINT
BA_DEF_ BO_ "E2EProfile" STRING ;
BA_DEF_ BO_ "E2EDataId" INT 0 65535;
BA_DEF_DEF_ "E2EProfile" "";
BA_DEF_DEF_ "E2EDataId" 0;
BA_ "E2EProfile" BO_ 768 "P01";
BA_ "E2EDataId" BO_ 768 768;
BA_ "E2EProfile" BO_ 769 "P01";
BA_ "E2EDataId" BO_ 769 769;
"""
PLAIN = DBC[: DBC.index("BA_DEF_")]
SENSORS = ("far", "side", "near")
ENDINGS = [".blf", ".asc", ".log"]
START = 1_700_000_000.0


def frame(identifier, counter, *values, t=0.0):
    payload = b"".join(int(value).to_bytes(2, "little", signed=value < 0) for value in values)
    data = bytes(2) + payload.ljust(6, b"\0")
    return can.Message(
        arbitration_id=identifier,
        is_extended_id=False,
        data=P01.protect(identifier, counter, data),
        timestamp=START + t,
    )


def sample(i):
    """Both frames of sample i, a hundredth of a second apart, the second a little later."""
    t = 0.01 * i
    return [
        frame(768, i % 15, 10 * i, -7 * i, t=t),
        frame(769, i % 15, 60_000 + i, t=t + 0.0004),
    ]


def messages(count=40):
    return [message for i in range(count) for message in sample(i)]


def read(folder, logged, ending=".blf", dbc=DBC, sensors=SENSORS):
    path, described = folder / f"run{ending}", folder / "finger.dbc"
    described.write_text(dbc)
    with can.Logger(path) as log:
        for message in logged:
            log.on_message_received(message)
    return read_can_log(path, described, sensors)


@pytest.mark.parametrize("ending", ENDINGS)
def test_frames_of_one_counter_are_one_sample(tmp_path, ending):
    log = read(tmp_path, messages(), ending)
    i = np.arange(40)
    np.testing.assert_array_equal(log.counts, np.stack([-7 * i, 60_000 + i, 10 * i], axis=1))
    np.testing.assert_allclose(log.t, 0.01 * i, atol=1e-6)
    assert log.damaged == 0


def test_a_damaged_frame_is_left_out_and_counted(tmp_path):
    logged = messages()
    logged[7].data[4] ^= 1
    log = read(tmp_path, logged)
    assert log.damaged == 1
    assert np.argwhere(np.isnan(log.counts)).tolist() == [[3, 1]]


def test_a_lost_frame_leaves_its_sensors_without_a_reading(tmp_path):
    logged = messages()
    del logged[6]
    log = read(tmp_path, logged)
    assert np.argwhere(np.isnan(log.counts)).tolist() == [[3, 0], [3, 2]]
    assert len(log.t) == 40


def test_the_most_negative_count_is_no_reading(tmp_path):
    logged = [frame(768, i % 15, i, -32768 if i == 5 else i, t=0.01 * i) for i in range(20)]
    log = read(tmp_path, logged, sensors=("near", "far"))
    assert np.argwhere(np.isnan(log.counts)).tolist() == [[5, 1]]


def test_without_a_profile_a_sample_ends_where_a_frame_comes_again(tmp_path):
    logged = messages()
    for message in logged:
        message.data[:2] = b"\0\0"
    log = read(tmp_path, logged, dbc=PLAIN)
    assert len(log.t) == 40
    assert not np.isnan(log.counts).any()
    assert log.damaged == 0


def test_other_frames_on_the_bus_do_not_matter(tmp_path):
    others = [
        can.Message(arbitration_id=0x300, is_extended_id=True, data=bytes(8), timestamp=START),
        can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\1", timestamp=START),
        can.Message(
            arbitration_id=768, is_extended_id=False, is_remote_frame=True, timestamp=START
        ),
    ]
    np.testing.assert_array_equal(
        read(tmp_path, others + messages()).counts, read(tmp_path, messages()).counts
    )


def test_a_sensor_may_be_called_by_its_name_alone(tmp_path):
    named = DBC.replace("length_near", "near").replace("length_far", "count_far")
    log = read(tmp_path, messages(), dbc=named)
    np.testing.assert_array_equal(log.counts, read(tmp_path, messages()).counts)


def test_a_sensor_that_the_dbc_does_not_know_has_no_counts(tmp_path):
    log = read(tmp_path, messages(), sensors=("far", "top"))
    assert np.isnan(log.counts).all(axis=0).tolist() == [False, True]


@pytest.mark.parametrize(
    ("logged", "changes", "says"),
    [
        (
            messages(),
            {"sensors": ("u0", "u1")},
            "finger.dbc: describes no signal of the sensors; it needs length_u0, length_u1, ...",
        ),
        (
            messages(),
            {"dbc": "BO_ 1 A 8"},
            "finger.dbc: is no DBC file",
        ),
        (
            messages(),
            {"dbc": DBC.replace("length_side", "length_far")},
            "finger.dbc: signal length_far is in FINGER_LENGTHS_0 and in FINGER_LENGTHS_1; keep "
            "the messages of one joint",
        ),
        (
            [frame(0x123, 0, 1)],
            {},
            "run.blf: holds no frame of the sensors; finger.dbc describes 0x300, 0x301: name the "
            "log and the DBC of one joint",
        ),
        (
            messages(),
            {"dbc": DBC.replace("768 768;", "768 5;").replace("769 769;", "769 5;")},
            "run.blf: holds no frame of the sensors (80 failed their check); finger.dbc describes "
            "0x300, 0x301: name the log and the DBC of one joint",
        ),
        (
            [*messages(), *sample(3)],
            {},
            "run.blf: time runs back after 0.390000 s; export the log in order of time",
        ),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, logged, changes, says):
    with pytest.raises(InputError) as error:
        read(tmp_path, logged, **changes)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(f"{tmp_path}/{says}")


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_log_that_is_cut_off_or_no_log_is_named(tmp_path, ending):
    path, dbc = tmp_path / f"run{ending}", tmp_path / "finger.dbc"
    dbc.write_text(DBC)
    path.write_bytes(b"\x93\x00\xff nothing of the kind " * 20)
    with pytest.raises(InputError) as error:
        read_can_log(path, dbc, SENSORS)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_a_missing_log_and_a_missing_dbc_are_named(tmp_path):
    with pytest.raises(InputError, match=r"run\.blf: no such file"):
        read_can_log(tmp_path / "run.blf", tmp_path / "finger.dbc", SENSORS)
    (tmp_path / "run.blf").write_bytes(b"")
    with pytest.raises(InputError, match=r"finger\.dbc: no such file"):
        read_can_log(tmp_path / "run.blf", tmp_path / "finger.dbc", SENSORS)
