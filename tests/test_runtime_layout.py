"""Frames and signals as a layout places them, the impossible ones too.

Undefined behaviour ends the run.
"""

import ctypes

import pytest
from runtime_c import Frame, Layout, completed, frame, frame_length, load
from test_runtime_snapshot import CLASSIC, FD

LENGTHS, ANGLES, TIP, STATUS, HEALTH, COMMAND, FOREIGN = range(7)
LAYOUTS = {"classic": CLASSIC, "fd": FD}
KINDS = {
    "classic": [LENGTHS] * 3 + [ANGLES] * 8 + [TIP, STATUS, HEALTH, COMMAND],
    "fd": [LENGTHS] * 2 + [ANGLES] * 7 + [TIP, STATUS, HEALTH, COMMAND],
}
"""Of 7 counts and 24 angles of 2 bytes, 3 a frame; of 16 and 96 of 4 bytes, 15 a frame."""


def kind_of(layout: Layout, id_: int, extended: bool) -> tuple[int, int]:
    """What a frame is, and which of its kind; 99 where the slot is not written."""
    slot = ctypes.c_uint16(99)
    sent = ctypes.byref(frame(id_, b"", extended=extended))
    kind = load().ccgen_layout_kind(ctypes.byref(layout), sent, ctypes.byref(slot))
    assert load().ccgen_layout_kind(ctypes.byref(layout), sent, None) == kind
    return kind, slot.value


@pytest.mark.parametrize("name", LAYOUTS)
def test_the_identifiers_from_lengths_to_command_are_the_joints_and_their_neighbours_foreign(name):
    layout, kinds = LAYOUTS[name], KINDS[name]
    for index, kind in enumerate(kinds):
        found = kind_of(layout, layout.base_id + index, layout.extended)
        assert found == (kind, index - kinds.index(kind))
    for foreign in (-2, -1, len(kinds), len(kinds) + 1, 1000):
        assert kind_of(layout, layout.base_id + foreign, layout.extended) == (FOREIGN, 99)


@pytest.mark.parametrize("name", LAYOUTS)
def test_an_identifier_of_the_other_length_is_foreign_whatever_its_number(name):
    layout = LAYOUTS[name]
    for index in range(len(KINDS[name])):
        assert kind_of(layout, layout.base_id + index, not layout.extended) == (FOREIGN, 99)


@pytest.mark.parametrize("rate_switch", [False, True])
@pytest.mark.parametrize("name", LAYOUTS)
def test_a_frame_begins_anew_whatever_it_held(name, rate_switch):
    """Frame 5 is one of ANGLES, and not the last of them."""
    layout = completed(LAYOUTS[name], rate_switch=rate_switch)
    begun = Frame.from_buffer_copy(b"\1" * ctypes.sizeof(Frame))
    load().ccgen_layout_begin(ctypes.byref(layout), ctypes.c_uint16(5), ctypes.byref(begun))
    assert begun.id == layout.base_id + 5
    assert (begun.extended, begun.fd) == (layout.extended, layout.fd)
    assert (begun.remote, begun.rate_switch) == (False, layout.fd and rate_switch)
    assert begun.payload() == bytes(64 if layout.fd else 8)


@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("sensors", (1, 16)),
        ("count_bytes", (2, 4)), ("angle_bytes", (2, 2)), ("angle_bytes", (4, 4)),
        ("cycle_us", (500, 300_000_000)), ("window_us", (1, 1_000_000)),
        ("base_id", (0, 0x7FF - 14)),
    ],
)  # fmt: skip
def test_a_field_is_valid_up_to_both_its_ends_and_no_further(name, ends):
    """The cycle's shorter end is that whose widest window is still the layout's own."""
    origin = completed(CLASSIC, cycle_us=10_000, window_us=50_000)

    def valid(value: int) -> bool:
        layout = completed(origin, **{name: value})
        return bool(load().ccgen_layout_valid(ctypes.byref(layout)))

    assert all(map(valid, ends))
    assert not any(map(valid, (ends[0] - 1, ends[1] + 1)))


@pytest.mark.parametrize(
    ("rows", "valid"),
    [
        ((64, 0, 0), True), ((0, 64, 0), True), ((0, 0, 64), True), ((64, 64, 64), True),
        ((65, 0, 0), False), ((1, 65, 0), False), ((1, 1, 65), False), ((65, 65, 1), False),
        ((0, 0, 1), True), ((0, 0, 0), False),
    ],
)  # fmt: skip
def test_an_axis_has_up_to_64_rows_and_some_axis_has_one(rows, valid):
    layout = completed(CLASSIC, rows=rows)
    assert bool(load().ccgen_layout_valid(ctypes.byref(layout))) == valid


@pytest.mark.parametrize("publish", [*range(16), 255])
@pytest.mark.parametrize("name", LAYOUTS)
def test_angles_tip_status_and_health_are_published_each_by_its_own_bit(name, publish):
    layout, kinds = completed(LAYOUTS[name], publish=publish), KINDS[name]
    bits = {ANGLES: 1, TIP: 2, STATUS: 4, HEALTH: 8}
    for index, kind in enumerate(kinds):
        if kind in bits:
            found = load().ccgen_layout_publishes(ctypes.byref(layout), ctypes.c_uint16(index))
            assert bool(found) == (bits[kind] & publish != 0)


@pytest.mark.parametrize(("extended", "last"), [(False, 0x7FF), (True, 0x1FFFFFFF)])
def test_the_last_frame_may_have_the_last_identifier_that_there_is(extended, last):
    for base, fits in ((last - 14, True), (last - 13, False), (last, False), (last + 1, False)):
        layout = completed(CLASSIC, extended=extended, base_id=base)
        assert bool(load().ccgen_layout_valid(ctypes.byref(layout))) == fits


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("numbers", 15), ("values", 23), ("values", 25), ("counts_per_frame", 2),
        ("counts_per_frame", 4), ("counts_per_frame", 0), ("angles_per_frame", 4),
        ("lengths_frames", 2), ("lengths_frames", 4), ("angles_frames", 7), ("angles_frames", 9),
        ("frame_bytes", 7), ("frame_bytes", 64), ("last_lengths_bytes", 3),
        ("last_lengths_bytes", 9), ("last_angles_bytes", 7), ("last_angles_bytes", 64),
        ("single_bytes", 7), ("single_bytes", 12), ("keys", None),
    ],
)  # fmt: skip
def test_what_does_not_follow_from_the_rest_is_refused(name, value):
    """Of 7 counts the last frame has one: 4 bytes would do, and 3 do not."""
    layout = Layout.from_buffer_copy(CLASSIC)
    setattr(layout, name, value)
    assert not load().ccgen_layout_valid(ctypes.byref(layout))


def test_every_frame_of_a_list_holds_its_signals_and_not_the_last_one_alone():
    """Two frames of six counts, of which the last has one: 12 bytes do not go into a frame."""
    layout = completed(CLASSIC, counts_per_frame=6, lengths_frames=2)
    layout.counts_per_frame, layout.lengths_frames = 6, 2
    layout.last_lengths_bytes = 8
    assert not load().ccgen_layout_valid(ctypes.byref(layout))


def test_on_can_fd_what_does_not_hold_the_signals_is_refused():
    assert load().ccgen_layout_valid(ctypes.byref(completed(FD, keys=None)))
    for name, least in (("last_lengths_bytes", 7), ("last_angles_bytes", 27), ("single_bytes", 9)):
        for value, holds in ((least - 1, False), (least, True), (64, True), (65, False)):
            layout = Layout.from_buffer_copy(FD)
            setattr(layout, name, value)
            assert bool(load().ccgen_layout_valid(ctypes.byref(layout))) == holds


def test_a_number_of_256_is_no_turn_of_can_fd():
    for numbers in (240, 15, 255):
        layout = Layout.from_buffer_copy(FD)
        layout.numbers = numbers
        assert not load().ccgen_layout_valid(ctypes.byref(layout))


@pytest.mark.parametrize("values", range(1, 32))
def test_frames_of_can_fd_are_as_long_as_their_signals_need(values):
    """15 angles of 4 bytes, or 20 counts of 3, fill a frame of 64."""
    layout = completed(FD, rows=(values, 0, 0), sensors=min(values, 16), count_bytes=3)
    angles = frame_length(True, 4 * ((values - 1) % 15 + 1))
    kinds = [LENGTHS] + [ANGLES] * -(-values // 15) + [TIP, STATUS, HEALTH, COMMAND]
    wanted = {LENGTHS: frame_length(True, 3 * min(values, 16)), ANGLES: 64}
    found = [
        load().ccgen_layout_frame_length(ctypes.byref(layout), ctypes.c_uint16(index))
        for index in range(len(kinds))
    ]
    expected = [wanted.get(kind, 12) for kind in kinds]
    expected[len(kinds) - 5] = angles
    assert found == expected


@pytest.mark.parametrize("width", [2, 3, 4])
def test_a_count_is_read_as_it_was_written_and_the_most_negative_is_no_reading(width):
    top = 2 ** (8 * width - 1)
    for value in (0, 1, -1, 0x1234, -0x1234, top - 1, 1 - top, -top):
        data = ctypes.create_string_buffer(8)
        load().ccgen_put_signed(data, ctypes.c_uint8(width), ctypes.c_int32(value))
        assert data.raw == value.to_bytes(width, "little", signed=True) + bytes(8 - width)
        read = load().ccgen_get_count(data, ctypes.c_uint8(width))
        assert read == (-(2**31) if value == -top else value)


@pytest.mark.parametrize(("bits", "kind"), [(16, ctypes.c_int16), (32, ctypes.c_int32)])
def test_a_signal_is_written_low_byte_first(bits, kind):
    put = getattr(load(), f"ccgen_put{bits}")
    for value in (0, 1, -1, 0x1234, 2 ** (bits - 1) - 1, -(2 ** (bits - 1))):
        data = ctypes.create_string_buffer(8)
        put(data, kind(value))
        assert data.raw == value.to_bytes(bits // 8, "little", signed=True) + bytes(8 - bits // 8)
