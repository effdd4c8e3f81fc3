"""Frames and signals as a layout places them, the impossible ones too.

Undefined behaviour ends the run.
"""

import ctypes

import pytest
from runtime_c import Frame, Layout, frame, load
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
    layout = Layout.from_buffer_copy(LAYOUTS[name])
    layout.rate_switch = rate_switch
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
    layout = Layout.from_buffer_copy(CLASSIC)
    layout.cycle_us, layout.window_us = 10_000, 50_000

    def valid(value: int) -> bool:
        setattr(layout, name, value)
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
    layout = Layout.from_buffer_copy(CLASSIC)
    layout.rows[:] = rows
    assert bool(load().ccgen_layout_valid(ctypes.byref(layout))) == valid


@pytest.mark.parametrize("publish", [*range(16), 255])
@pytest.mark.parametrize("name", LAYOUTS)
def test_angles_tip_status_and_health_are_published_each_by_its_own_bit(name, publish):
    layout, kinds = Layout.from_buffer_copy(LAYOUTS[name]), KINDS[name]
    layout.publish = publish
    published = [
        bool(load().ccgen_layout_publishes(ctypes.byref(layout), ctypes.c_uint16(index)))
        for index in range(len(kinds) + 2)
    ]
    bits = {ANGLES: 1, TIP: 2, STATUS: 4, HEALTH: 8}
    assert published == [bits.get(kind, 0) & publish != 0 for kind in [*kinds, FOREIGN, FOREIGN]]


@pytest.mark.parametrize(("extended", "last"), [(False, 0x7FF), (True, 0x1FFFFFFF)])
def test_the_last_frame_may_have_the_last_identifier_that_there_is(extended, last):
    layout = Layout.from_buffer_copy(CLASSIC)
    layout.extended = extended
    for base, fits in ((last - 14, True), (last - 13, False), (last, False), (last + 1, False)):
        layout.base_id = base
        assert bool(load().ccgen_layout_valid(ctypes.byref(layout))) == fits


def read_signed(data: bytes, width: int) -> int:
    return int(load().ccgen_get_signed(ctypes.c_char_p(data), ctypes.c_uint8(width)))


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_a_signal_is_read_back_as_it_was_written(width):
    top = 2 ** (8 * width - 1)
    for value in (0, 1, -1, top - 1, 1 - top, -top):
        data = ctypes.create_string_buffer(8)
        load().ccgen_put_signed(data, ctypes.c_uint8(width), ctypes.c_int32(value))
        assert data.raw == value.to_bytes(width, "little", signed=True) + bytes(8 - width)
        assert read_signed(data.raw, width) == value
    assert load().ccgen_no_reading(ctypes.c_uint8(width)) == -top


@pytest.mark.parametrize("width", [0, 5, 8, 255])
def test_a_signal_of_an_impossible_width_is_zero(width):
    assert read_signed(b"\xff" * 255, width) == 0
    assert load().ccgen_no_reading(ctypes.c_uint8(width)) == 0
