"""Where signals lie in frames: counts of frames, identifiers, sizes, and what is refused."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_files import joint_text

from ccgen.can.layout import FrameLayout, layout_for, tip_fraction_bits
from ccgen.errors import InputError
from ccgen.joint.file import parse_joint

JOINT = parse_joint(joint_text(), "shoulder.toml")


def ranges(lowest, highest):
    return SimpleNamespace(minimum=[lowest] * 6, maximum=[highest] * 6)


def names(u, v):
    return tuple(f"u{j}" for j in range(u)) + tuple(f"v{j}" for j in range(v))


NARROW = ranges(-20000, 20000)
LAYOUT = layout_for(JOINT, NARROW)

layouts = st.builds(
    FrameLayout,
    name=st.just("joint"),
    base_id=st.integers(0, 0x700),
    extended=st.booleans(),
    fd=st.booleans(),
    sensors=st.builds(names, st.integers(1, 8), st.integers(1, 8)),
    rows=st.tuples(st.integers(1, 64), st.integers(0, 64), st.integers(0, 64)),
    count_bytes=st.sampled_from((2, 3, 4)),
    angle_bytes=st.sampled_from((2, 4)),
    cycle_ms=st.integers(1, 1000),
    tip_fraction_bits=st.integers(0, 20),
    turn=st.booleans(),
    publish=st.sampled_from(((), ("tip", "status"), ("angles", "tip", "status", "health"))),
    commands=st.booleans(),
)


def test_twelve_segments_with_three_sensors_take_two_frames_in_and_ten_out():
    assert [frame.name for frame in LAYOUT.frames] == [
        "SHOULDER_LENGTHS_0",
        "SHOULDER_LENGTHS_1",
        *(f"SHOULDER_ANGLES_{k}" for k in range(8)),
        "SHOULDER_TIP",
        "SHOULDER_STATUS",
        "SHOULDER_HEALTH",
        "SHOULDER_COMMAND",
    ]
    assert [frame.id for frame in LAYOUT.frames] == list(range(0x300, 0x30E))
    assert (LAYOUT.lengths_frames, LAYOUT.answer_frames, LAYOUT.last_id) == (2, 10, 0x30D)


@pytest.mark.parametrize("published", [(), ("tip",), ("angles", "health"), ("status",)])
def test_what_is_left_out_keeps_its_identifier(published):
    layout = replace(LAYOUT, publish=published, commands=True)
    assert [(f.id, f.name) for f in layout.frames] == [(f.id, f.name) for f in LAYOUT.frames]
    kinds = {frame.kind for frame in layout.used_frames}
    assert kinds == {"lengths", "command", *published}
    assert layout.numbered_frames == 8 * ("angles" in published) + ("tip" in published)
    assert layout.answer_frames == layout.numbered_frames + ("status" in published)


def test_a_command_is_no_frame_of_a_joint_that_obeys_none():
    assert [frame.kind for frame in LAYOUT.used_frames[-2:]] == ["status", "health"]


def test_health_lies_in_six_bytes_as_the_runtime_writes_it():
    places = {s.name: (s.start, s.bits) for s in LAYOUT.frames_of("health")[0].payload}
    assert places == {
        "fingerprint": (16, 16),
        "suspected_sensors": (32, 16),
        "axis_u": (48, 2),
        "axis_v": (50, 2),
        "axis_h": (52, 2),
        "zero": (54, 2),
        "last_command": (56, 4),
        "result": (60, 4),
    }


def test_a_command_lies_as_the_runtime_reads_it():
    places = {s.name: (s.start, s.bits) for s in LAYOUT.frames_of("command")[0].payload}
    assert places == {"number": (16, 4), "command": (20, 4), "snapshots": (24, 8)}


def test_u_comes_before_v_in_one_list_across_frames():
    found = [signal.name for frame in LAYOUT.frames_of("angles") for signal in frame.payload]
    assert found == [f"angle_{axis}{i}" for axis in "uv" for i in range(12)]
    uneven = replace(LAYOUT, sensors=names(2, 3))
    found = [[s.name for s in frame.payload] for frame in uneven.frames_of("lengths")]
    assert found == [["length_u0", "length_u1", "length_v0"], ["length_v1", "length_v2"]]


def test_elongations_follow_the_angles_and_a_planar_joint_leaves_an_axis_out():
    layout = replace(LAYOUT, rows=(0, 3, 2))
    found = [signal.name for frame in layout.frames_of("angles") for signal in frame.payload]
    assert found == ["angle_v0", "angle_v1", "angle_v2", "elongation_h0", "elongation_h1"]


def test_missing_sensors_of_the_papers_sets_have_eight_bits_each_and_others_one_after_the_other():
    assert LAYOUT.missing_bits == (0, 1, 2, 8, 9, 10)
    assert replace(LAYOUT, own_sets=False).missing_bits == (0, 1, 2, 3, 4, 5)


def test_status_lies_as_the_runtime_writes_it():
    places = {s.name: (s.start, s.bits) for s in LAYOUT.frames_of("status")[0].signals}
    assert places == {
        "crc": (0, 8),
        "counter": (8, 4),
        "sample_counter": (16, 16),
        "missing_sensors": (32, 16),
        "faults": (48, 8),
        "age": (56, 8),
    }


def test_can_fd_puts_the_same_status_behind_three_header_bytes():
    places = {s.name: s.start for s in replace(LAYOUT, fd=True).frames_of("status")[0].signals}
    assert places == {
        "crc": 0, "counter": 16, "sample_counter": 24, "missing_sensors": 40, "faults": 56,
        "age": 64,
    }  # fmt: skip


def test_can_fd_holds_thirty_angles_a_frame():
    fd = replace(LAYOUT, fd=True)
    assert fd.angles_per_frame == 30
    assert [frame.kind for frame in fd.frames] == [
        "lengths", "angles", "tip", "status", "health", "command",
    ]  # fmt: skip


def test_the_turn_stands_beside_the_counter_of_snapshots_and_their_answers():
    places = {
        frame.kind: {s.name: (s.start, s.bits) for s in frame.signals} for frame in LAYOUT.frames
    }
    assert all(places[kind]["turn"] == (12, 4) for kind in ("lengths", "angles", "tip"))
    assert not any("turn" in places[kind] for kind in ("status", "health", "command"))
    for layout in (replace(LAYOUT, turn=False), replace(LAYOUT, fd=True)):
        assert not any(s.name == "turn" for frame in layout.frames for s in frame.signals)


@pytest.mark.parametrize(
    ("fd", "turn", "numbers", "latest", "window"),
    [(False, True, 240, 120, 100), (False, False, 15, 8, 6), (True, True, 256, 128, 100)],
)
def test_a_late_frame_and_a_window_fit_into_the_numbers(fd, turn, numbers, latest, window):
    layout = replace(LAYOUT, fd=fd, turn=turn)
    assert (layout.numbers, layout.latest_cycles, layout.window_cycles) == (numbers, latest, window)
    assert layout.seen_cycles < numbers
    assert layout.window_max_us == window * layout.cycle_us


@given(layouts)
def test_signals_never_overlap_and_stay_within_the_frame(layout):
    for frame in layout.frames:
        bits = [b for s in frame.signals for b in range(s.start, s.start + s.bits)]
        assert len(bits) == len(set(bits))
        assert max(bits) < 8 * layout.frame_bytes


@given(layouts)
def test_frames_number_what_the_counts_say(layout):
    kinds = [frame.kind for frame in layout.frames]
    assert kinds.count("lengths") == layout.lengths_frames
    assert kinds.count("angles") == layout.angles_frames
    assert layout.frames[-1].id == layout.last_id
    payload = [s for frame in layout.frames_of("angles") for s in frame.payload]
    assert len(payload) == layout.values


def test_data_id_is_the_low_half_of_the_identifier():
    extended = replace(LAYOUT, base_id=0x18FF0000, extended=True)
    assert extended.frames[3].data_id == 0x0003


def test_precision_16_counts_take_two_bytes():
    assert (LAYOUT.count_bytes, LAYOUT.angle_bytes) == (2, 2)


@pytest.mark.parametrize(
    ("lowest", "highest", "size"),
    [
        (-(2**23) + 1, 2**23 - 1, 3),
        (-(2**23), 2**23 - 1, 4),
        (0, 2**23, 4),
        (-(2**31) + 1, 2**31 - 1, 4),
    ],
)
def test_precision_32_takes_three_bytes_where_24_bits_and_no_reading_fit(lowest, highest, size):
    layout = layout_for(replace(JOINT, precision=32), ranges(lowest, highest))
    assert (layout.count_bytes, layout.angle_bytes) == (size, 4)


@pytest.mark.parametrize(("length", "bits"), [(0.24, 17), (32767.0, 0), (1.0, 14), (2e-5, 30)])
def test_tip_scale_is_the_finest_that_holds_the_joint(length, bits):
    assert tip_fraction_bits(length) == bits
    assert length * 2.0**bits <= 32767 < length * 2.0 ** (bits + 1) or bits == 30


def test_tip_scale_stays_within_what_the_runtime_takes():
    assert tip_fraction_bits(1e-9) == 30
    assert tip_fraction_bits(1e9) == 0


def test_identifiers_beyond_the_bus_are_refused_with_the_highest_base():
    joint = replace(JOINT, can=replace(JOINT.can, base_id=0x7F3))
    with pytest.raises(InputError) as refused:
        layout_for(joint, NARROW)
    assert str(refused.value) == (
        "shoulder.toml: can.base_id: 14 frames from 0x7f3 on exceed the last identifier 0x7ff; "
        "at most 0x7f2 would fit"
    )
    assert layout_for(replace(JOINT, can=replace(JOINT.can, base_id=0x7F2)), NARROW)


@given(layouts)
def test_a_frame_is_as_short_as_its_signals_allow(layout):
    """8 bytes on classic CAN; on CAN FD the shortest length of 12 and more that holds them."""
    for frame in layout.frames:
        needed = max(s.start + s.bits for s in frame.signals) / 8
        shorter = [n for n in (12, 16, 20, 24, 32, 48, 64) if n < frame.length]
        if layout.fd:
            assert needed <= frame.length
            assert frame.length in (12, 16, 20, 24, 32, 48, 64)
            assert all(n < needed for n in shorter)
        else:
            assert needed <= frame.length == 8
