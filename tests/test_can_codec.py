"""Counts to frames and frames to values through the generated DBC, with every refusal counted."""

from dataclasses import replace
from types import SimpleNamespace

import can
import cantools
import e2e.p01
import e2e.p05
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccgen.can.codec import Codec, Status, read_database, status_of
from ccgen.can.layout import FrameLayout
from ccgen.errors import InputError
from ccgen.export.dbc import dbc_text

CLASSIC = FrameLayout(
    "shoulder", 0x300, False, False, ("u0", "u1", "u2", "v0", "v1", "v2"), (12, 12, 0), 2, 2, 10, 17
)
WIDE = tuple(f"{axis}{j}" for axis, number in (("u", 6), ("v", 8)) for j in range(number))
LAYOUTS = {
    "classic": CLASSIC,
    "without turn": replace(CLASSIC, turn=False),
    "32-bit": replace(CLASSIC, rows=(48, 48, 0), sensors=WIDE, count_bytes=4, angle_bytes=4),
    "24-bit": replace(CLASSIC, count_bytes=3, angle_bytes=4),
    "fd": replace(CLASSIC, fd=True),
    "extended": replace(CLASSIC, base_id=0x18FF0000, extended=True),
}


def text_of(layout):
    axis = SimpleNamespace(fraction_bits=18)
    sensors = [SimpleNamespace(name=name, metres_per_count=2e-6) for name in layout.sensors]
    joint = SimpleNamespace(sensors=sensors, can=SimpleNamespace(bitrate=1_000_000))
    readings = SimpleNamespace(zero=np.zeros(len(sensors), dtype=np.int64))
    model = SimpleNamespace(axes={"u": axis, "v": axis}, readings=readings)
    return dbc_text(layout, joint, model)


def codec_for(layout):
    return Codec(layout, cantools.database.load_string(text_of(layout), "dbc"))


CODECS = {name: codec_for(layout) for name, layout in LAYOUTS.items()}


@pytest.fixture
def codec():
    return codec_for(CLASSIC)


@pytest.mark.parametrize("name", LAYOUTS)
@given(data=st.data())
def test_counts_come_back_from_their_frames(name, data):
    layout, codec = LAYOUTS[name], CODECS[name]
    limit = 1 << (8 * layout.count_bytes - 1)
    number = len(layout.sensors)
    counts = data.draw(st.lists(st.integers(-limit, limit - 1), min_size=number, max_size=number))
    sent = data.draw(st.integers(0, layout.numbers - 1))
    frames = codec.encode(counts, sent)
    decoded = [codec.decode(frame) for frame in frames]
    assert [value for d in decoded for value in d.values] == counts
    assert [(d.kind, d.index, d.number) for d in decoded] == [
        ("lengths", k, sent) for k in range(layout.lengths_frames)
    ]


@pytest.mark.parametrize("name", ["classic", "without turn", "fd"])
def test_another_implementation_accepts_the_protection_of_every_number(name):
    check = e2e.p05.e2e_p05_check if LAYOUTS[name].fd else e2e.p01.e2e_p01_check
    for number in range(LAYOUTS[name].numbers):
        for frame in CODECS[name].encode([1, -2, 3, -4, 5, -6], number):
            assert check(bytearray(frame.data), frame.arbitration_id)
            assert len(frame.data) == (16 if LAYOUTS[name].fd else 8)


def test_the_turn_lies_beside_the_counter_in_frames_of_snapshots_alone(codec):
    for kind in ("lengths", "angles", "tip"):
        frame = codec.encode_frame(kind, 0, [1, 2, 3], 14 * 15 + 3)
        assert frame.data[1] == 0xE3
        assert codec.decode(frame).number == 14 * 15 + 3
    status = codec.encode_frame("status", 0, [1, 2, 3, 4], 14)
    assert (status.data[1], codec.decode(status).number) == (0x0E, 14)


def test_without_the_turn_what_a_sender_leaves_beside_the_counter_is_not_read():
    frame = CODECS["classic"].encode([1, 2, 3, 4, 5, 6], 14 * 15 + 3)[0]
    decoded = CODECS["without turn"].decode(frame)
    assert (decoded.number, decoded.values) == (3, (1, 2, 3))


@pytest.mark.parametrize(
    ("name", "kind", "number"),
    [
        ("classic", "tip", 240), ("classic", "tip", -1), ("classic", "status", 15),
        ("without turn", "tip", 15), ("fd", "tip", 256), ("fd", "status", -1),
    ],
)  # fmt: skip
def test_a_number_that_there_is_not_is_refused(name, kind, number):
    with pytest.raises(ValueError, match=f"SHOULDER_{kind.upper()}"):
        CODECS[name].encode_frame(kind, 0, [1, 2, 3] + [4] * (kind == "status"), number)


def test_counts_lie_little_endian_behind_the_header(codec):
    first, second = codec.encode([1, -2, 3, -4, 5, -32768], 7)
    assert bytes(first.data[1:]) == bytes((7, 1, 0, 0xFE, 0xFF, 3, 0))
    assert bytes(second.data[1:]) == bytes((7, 0xFC, 0xFF, 5, 0, 0x00, 0x80))
    assert (first.arbitration_id, second.arbitration_id) == (0x300, 0x301)


def test_the_most_negative_value_says_no_reading(codec):
    frame = codec.encode_frame("angles", 2, [-32768] * 3, 1)
    assert codec.decode(frame).values == (CLASSIC.frames[0].payload[0].no_reading,) * 3


def test_status_gives_its_fields(codec):
    decoded = codec.decode(codec.encode_frame("status", 0, [513, 0x0201, 0x40, 255], 3))
    assert status_of(decoded) == Status(
        sample_counter=513, missing_sensors=0x0201, faults=0x40, age_ms=255
    )


@pytest.mark.parametrize("counts", [[0] * 5, [0] * 7])
def test_a_wrong_number_of_counts_is_refused(codec, counts):
    with pytest.raises(ValueError, match="counts for 2 LENGTHS frames"):
        codec.encode(counts, 0)


@pytest.mark.parametrize("count", [32768, -32769])
def test_a_count_that_does_not_fit_its_signal_is_refused(codec, count):
    with pytest.raises(ValueError, match="SHOULDER_LENGTHS_1"):
        codec.encode([0, 0, 0, 0, count, 0], 0)


@given(bit=st.integers(0, 63))
def test_a_flipped_bit_is_refused_and_counted(bit):
    codec = CODECS["classic"]
    codec.errors.clear()
    frame = codec.encode_frame("tip", 0, [1, 2, 3], 4)
    frame.data[bit // 8] ^= 1 << bit % 8
    assert codec.decode(frame) is None
    assert codec.errors == {"crc": 1}


@pytest.mark.parametrize(
    "change",
    [
        {"data": bytes(7), "dlc": 7},
        {"is_fd": True},
    ],
)
def test_a_frame_of_another_form_is_refused_and_counted(codec, change):
    good = {"arbitration_id": 0x302, "is_extended_id": False, "data": bytes(8), "dlc": 8}
    assert codec.decode(can.Message(**(good | change))) is None
    assert codec.errors == {"format": 1}


@pytest.mark.parametrize("kind", ["is_remote_frame", "is_error_frame"])
def test_requests_and_errors_of_the_bus_are_nobodys_data(codec, kind):
    message = can.Message(arbitration_id=0x302, is_extended_id=False, dlc=8, **{kind: True})
    assert codec.decode(message) is None
    assert not codec.errors


@pytest.mark.parametrize("frame_id", [(0x2FF, False), (0x30D, False), (0x300, True)])
def test_frames_of_others_are_none_of_ours(codec, frame_id):
    number, extended = frame_id
    message = can.Message(arbitration_id=number, is_extended_id=extended, data=bytes(8))
    assert codec.decode(message) is None
    assert not codec.errors


def test_a_dbc_of_another_joint_is_refused():
    database = cantools.database.load_string(text_of(CLASSIC), "dbc")
    with pytest.raises(InputError, match="the DBC lacks the frame ELBOW_LENGTHS_0"):
        Codec(replace(CLASSIC, name="elbow"), database)
    with pytest.raises(InputError, match="the DBC describes SHOULDER_LENGTHS_0 otherwise"):
        Codec(replace(CLASSIC, base_id=0x400), database)


def test_a_dbc_file_is_read_or_refused_in_one_line(tmp_path):
    path = tmp_path / "shoulder.dbc"
    with pytest.raises(InputError, match="No such file"):
        read_database(path)
    path.write_text("BO_ 1 nonsense", encoding="utf-8")
    with pytest.raises(InputError, match="damaged"):
        read_database(path)
    path.write_text(text_of(CLASSIC), encoding="utf-8", newline="")
    assert len(read_database(path).messages) == 13
