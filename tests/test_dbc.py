"""The generated DBC as cantools reads it back: every signal, its place, scale and raw values."""

from dataclasses import replace
from types import SimpleNamespace

import cantools
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccgen.can.layout import FrameLayout
from ccgen.export.dbc import dbc_text

CLASSIC = FrameLayout(
    "shoulder", 0x300, False, False, ("u0", "u1", "u2", "v0", "v1", "v2"), (12, 12, 0), 2, 2, 10, 17
)
WIDE = tuple(f"{axis}{j}" for axis, number in (("u", 6), ("v", 8)) for j in range(number))
LAYOUTS = {
    "classic": CLASSIC,
    "without turn": replace(CLASSIC, turn=False),
    "wide": replace(CLASSIC, rows=(48, 48, 0), sensors=WIDE, count_bytes=4, angle_bytes=4),
    "24-bit": replace(CLASSIC, count_bytes=3, angle_bytes=4),
    "fd": replace(CLASSIC, fd=True),
    "extended": replace(CLASSIC, base_id=0x18FF0000, extended=True),
    "fd extended": replace(
        CLASSIC, base_id=0x18FF0000, extended=True, fd=True, count_bytes=3, angle_bytes=4
    ),
}


def text_of(layout):
    steps = {"u": 2e-6, "v": 3.1e-7}
    sensors = [
        SimpleNamespace(name=name, metres_per_count=steps[name[0]]) for name in layout.sensors
    ]
    joint = SimpleNamespace(sensors=sensors, can=SimpleNamespace(bitrate=1_000_000))
    axes = {"u": SimpleNamespace(fraction_bits=18), "v": SimpleNamespace(fraction_bits=33)}
    readings = SimpleNamespace(zero=np.zeros(len(sensors), dtype=np.int64))
    return dbc_text(layout, joint, SimpleNamespace(axes=axes, readings=readings))


DATABASES = {
    name: cantools.database.load_string(text_of(layout), "dbc", strict=True)
    for name, layout in LAYOUTS.items()
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_cantools_reads_every_frame_and_signal_back(name):
    layout, database = LAYOUTS[name], DATABASES[name]
    assert len(database.messages) == len(layout.used_frames)
    for frame in layout.used_frames:
        message = database.get_message_by_name(frame.name)
        assert message.frame_id == frame.id
        assert message.is_extended_frame == layout.extended
        assert message.is_fd == layout.fd
        assert message.length == frame.length
        own = {"health": 100, "command": 0}
        assert message.cycle_time == own.get(frame.kind, layout.cycle_ms)
        assert message.dbc.attributes["E2EDataId"].value == frame.data_id
        assert message.dbc.attributes["E2EProfile"].value == ("P05" if layout.fd else "P01")
        read = [(s.name, s.start, s.length, s.is_signed, s.byte_order) for s in message.signals]
        assert read == [(s.name, s.start, s.bits, s.signed, "little_endian") for s in frame.signals]


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_signal_tells_its_least_and_greatest_value(name):
    for frame in LAYOUTS[name].used_frames:
        for signal in DATABASES[name].get_message_by_name(frame.name).signals:
            raw = (-(2 ** (signal.length - 1)), 2 ** (signal.length - 1) - 1)
            if not signal.is_signed:
                raw = (0, 2**signal.length - 1)
            told = (signal.minimum / signal.scale, signal.maximum / signal.scale)
            assert told == pytest.approx(raw, rel=1e-12), signal.name


def test_scales_are_si_and_exact():
    message = DATABASES["classic"].get_message_by_name
    scales = {
        signal.name: (signal.scale, signal.unit)
        for frame in CLASSIC.used_frames
        for signal in message(frame.name).signals
    }
    assert scales["length_u0"] == (2e-6, "m")
    assert scales["length_v2"] == (3.1e-7, "m")
    assert scales["angle_u11"] == (2.0**-18, "rad")
    assert scales["angle_v0"] == (2.0**-33, "rad")
    assert scales["tip_z"] == (2.0**-17, "m")
    assert scales["age"] == (0.001, "s")
    assert scales["faults"] == (1, None)


def test_a_frame_decodes_to_physical_values():
    tip = DATABASES["classic"].get_message_by_name("SHOULDER_TIP")
    data = (
        bytes((0, 0xE3)) + (2**15).to_bytes(2, "little") + (0x4000).to_bytes(2, "little") + b"\1\0"
    )
    assert tip.decode(data) == {
        "crc": 0, "counter": 3, "turn": 14,
        "tip_x": "no reading", "tip_y": 0.125, "tip_z": 2.0**-17,
    }  # fmt: skip


@pytest.mark.parametrize("name", LAYOUTS)
@given(data=st.data())
def test_raw_values_pass_unchanged_at_their_extremes(name, data):
    layout, database = LAYOUTS[name], DATABASES[name]
    frame = data.draw(st.sampled_from(layout.used_frames))
    values = {
        s.name: data.draw(
            st.integers(-(1 << s.bits - 1), (1 << s.bits - 1) - 1)
            if s.signed
            else st.integers(0, (1 << s.bits) - 1)
        )
        for s in frame.signals
    }
    message = database.get_message_by_name(frame.name)
    encoded = message.encode(values, scaling=False)
    assert message.decode(encoded, scaling=False, decode_choices=False) == values
    for s in frame.signals:
        field = int.from_bytes(encoded, "little") >> s.start & ((1 << s.bits) - 1)
        assert field == values[s.name] % (1 << s.bits)


def test_senders_and_receivers_are_named():
    database = DATABASES["classic"]
    assert [node.name for node in database.nodes] == ["SHOULDER_SENSORS", "SHOULDER_JOINT", "HOST"]
    lengths = database.get_message_by_name("SHOULDER_LENGTHS_0")
    angles = database.get_message_by_name("SHOULDER_ANGLES_0")
    assert (lengths.senders, lengths.receivers) == (["SHOULDER_SENSORS"], {"SHOULDER_JOINT"})
    assert (angles.senders, angles.receivers) == (["SHOULDER_JOINT"], {"HOST"})


def test_comments_say_what_no_reading_looks_like():
    classic, wide = DATABASES["classic"], DATABASES["wide"]
    angle = classic.get_message_by_name("SHOULDER_ANGLES_0").get_signal_by_name("angle_u0")
    assert angle.comment == "Bending about local x; raw -32768: no reading"
    angle = wide.get_message_by_name("SHOULDER_ANGLES_95").get_signal_by_name("angle_v47")
    assert angle.comment == "Bending about local y; raw -2147483648: no reading"


def test_the_same_joint_gives_the_same_text():
    for layout in LAYOUTS.values():
        assert text_of(layout) == text_of(layout)
