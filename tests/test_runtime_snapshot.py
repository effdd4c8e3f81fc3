"""Snapshots of counts: coherent whatever happens to the frames, and every mishap counted."""

import ctypes
from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime_c import NO_READING, Frame, Layout, completed, frame, frame_length, junk, load

from ccgen.e2e import P01, P05, Profile

CRC, FORMAT, REPEATED, REORDERED, LOST, LATE, MISSING, STALE = (1 << bit for bit in range(8))
CYCLE = 10_000
WINDOW = 4_000
NUMBERS = 240
NAMES = ("snapshots", "corrupted", "malformed", "repeated", "reordered", "lost", "late")

CLASSIC = completed(Layout(
    base_id=0x300, extended=False, fd=False, turn=True, sensors=7, rows=(12, 12, 0),
    count_bytes=2, angle_bytes=2, cycle_us=CYCLE, window_us=WINDOW, publish=7,
))  # fmt: skip
FD = completed(Layout(
    base_id=0x18000, extended=True, fd=True, turn=False, sensors=16, rows=(48, 48, 0),
    count_bytes=4, angle_bytes=4, cycle_us=CYCLE, window_us=WINDOW, publish=7,
))  # fmt: skip


class Snapshot:
    """The C state, fed with frames."""

    def __init__(self, layout: Layout = CLASSIC) -> None:
        self.c = load()
        self.layout = layout
        self.state = junk(self.c.probe_size(3))
        assert self.c.ccgen_snapshot_init(ctypes.byref(layout), self.state) == 0

    def receive(self, sent: Frame, now: int) -> int:
        return self.c.ccgen_snapshot_receive(
            ctypes.byref(self.layout), self.state, ctypes.byref(sent), ctypes.c_uint32(now)
        )

    def tick(self, now: int) -> None:
        c_now = ctypes.c_uint32(now)
        assert self.c.ccgen_snapshot_tick(ctypes.byref(self.layout), self.state, c_now) == 0

    def age(self, now: int) -> int:
        return self.c.ccgen_snapshot_age_ms(self.state, ctypes.c_uint32(now))

    @property
    def counts(self) -> list[int]:
        return list((ctypes.c_int32 * self.layout.sensors).from_buffer(self.state))

    @property
    def counters(self) -> dict[str, int]:
        """What is not zero."""
        return {name: value for name, value in zip(NAMES, self._numbers(), strict=False) if value}

    @property
    def number(self) -> int:
        return self._numbers()[7]

    def faults(self) -> int:
        """The accumulated faults, which this clears."""
        return self.c.probe_take_faults(self.state)

    def _numbers(self) -> list[int]:
        numbers = (ctypes.c_uint32 * 9)()
        self.c.probe_snapshot(self.state, numbers)
        return list(numbers)


def profile_of(layout: Layout) -> Profile:
    return P05 if layout.fd else P01


def signals(layout: Layout) -> int:
    """Counts in a frame."""
    return 61 // layout.count_bytes if layout.fd else 6 // layout.count_bytes


def frames_of(layout: Layout, number: int, counts: list[int]) -> list[Frame]:
    """The LENGTHS frames of one snapshot, as a sender makes them."""
    turn, counter = (0, number) if layout.fd else divmod(number, 15)
    share = signals(layout)
    made = []
    for slot, first in enumerate(range(0, len(counts), share)):
        body = b"".join(
            count.to_bytes(layout.count_bytes, "little", signed=True)
            for count in counts[first : first + share]
        )
        header = bytes(3) if layout.fd else bytes((0, turn << 4))
        length = frame_length(layout.fd, len(body))
        id_ = layout.base_id + slot
        data = profile_of(layout).protect(
            id_ & 0xFFFF, counter, (header + body).ljust(length, b"\0")
        )
        made.append(frame(id_, data, fd=layout.fd, extended=layout.extended))
    return made


def numbered(k: int) -> list[int]:
    """Counts that tell which snapshot they belong to, in every sensor."""
    return [10 * k + j for j in range(7)]


def send(snapshot: Snapshot, k: int, now: int, slots: tuple[int, ...] = (0, 1, 2)) -> list[int]:
    """Some frames of snapshot number k, at once."""
    frames = frames_of(CLASSIC, k % NUMBERS, numbered(k))
    return [snapshot.receive(frames[slot], now) for slot in slots]


def test_complete_snapshots_come_out_whole():
    snapshot = Snapshot()
    for k in range(500):  # the numbers come round twice
        assert send(snapshot, k, k * CYCLE) == [0, 0, 1]
        assert snapshot.counts == numbered(k)
        assert snapshot.number == k % NUMBERS
    assert snapshot.counters == {"snapshots": 500}
    assert snapshot.faults() == 0


def test_without_the_turn_numbers_are_the_counter_whatever_the_nibble_beside_it_holds():
    layout = completed(CLASSIC, turn=False)
    snapshot = Snapshot(layout)
    for k in range(40):
        frames = frames_of(layout, k % 15 + 15 * (k % 3), numbered(k))
        assert [snapshot.receive(f, k * CYCLE) for f in frames] == [0, 0, 1]
        assert (snapshot.counts, snapshot.number) == (numbered(k), k % 15)
    assert snapshot.counters == {"snapshots": 40}


def test_frames_of_one_counter_but_different_turns_are_of_different_snapshots():
    snapshot = Snapshot()
    assert send(snapshot, 7, 0, (0, 1)) == [0, 0]
    assert send(snapshot, 7 + 15, CYCLE // 4, (2,)) == [0]
    assert send(snapshot, 7 + 15, CYCLE // 4, (0, 1)) == [0, 1]
    assert snapshot.counts == numbered(7 + 15)


def test_fd_counter_wraps_at_256():
    snapshot = Snapshot(FD)
    for k in range(520):
        counts = [k * 1000 - 250_000 + j for j in range(16)]
        results = [snapshot.receive(f, k * CYCLE) for f in frames_of(FD, k % 256, counts)]
        assert results == [0, 1]
        assert snapshot.counts == counts
    assert snapshot.counters == {"snapshots": 520}


def test_frames_of_a_snapshot_may_come_in_any_order():
    snapshot = Snapshot()
    assert send(snapshot, 0, 0, (2, 0, 1)) == [0, 0, 1]
    assert snapshot.counts == numbered(0)


def test_nothing_is_published_before_the_set_is_complete():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    send(snapshot, 1, CYCLE, (0, 2))
    assert snapshot.counts == numbered(0)
    assert snapshot.number == 0


def test_a_missing_frame_loses_its_snapshot_and_no_other():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    assert send(snapshot, 1, CYCLE, (0, 2)) == [0, 0]
    assert send(snapshot, 2, 2 * CYCLE) == [0, 0, 1]
    assert snapshot.counts == numbered(2)
    assert snapshot.counters == {"snapshots": 2, "lost": 1}
    assert snapshot.faults() == LOST


def test_skipped_numbers_are_lost_each():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    send(snapshot, 1, CYCLE, (0,))
    assert send(snapshot, 5, 2 * CYCLE) == [0, 0, 1]
    assert snapshot.counters == {"snapshots": 2, "lost": 4}
    assert snapshot.faults() == LOST


def test_repeated_frames_are_counted_and_change_nothing():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    first, second, third = frames_of(CLASSIC, 1, numbered(1))
    results = [snapshot.receive(f, CYCLE) for f in (first, first, second, third, second)]
    assert results == [0, 0, 0, 1, 0]
    assert snapshot.counts == numbered(1)
    assert snapshot.counters == {"snapshots": 2, "repeated": 2}
    assert snapshot.faults() == REPEATED


def test_other_counts_in_a_taken_place_begin_a_new_snapshot():
    """A sender that started anew, with the number that its former self had just used."""
    snapshot = Snapshot()
    old, new = frames_of(CLASSIC, 1, numbered(1)), frames_of(CLASSIC, 1, numbered(9))
    assert [snapshot.receive(f, 0) for f in old[:2]] == [0, 0]
    assert [snapshot.receive(f, 1) for f in new] == [0, 0, 1]
    assert snapshot.counts == numbered(9)
    assert snapshot.counters == {"snapshots": 1, "lost": 1}
    assert snapshot.faults() == LOST


@pytest.mark.parametrize("sensor", range(3))
def test_one_other_count_is_enough_to_tell_two_sendings_apart(sensor):
    snapshot = Snapshot()
    send(snapshot, 1, 0)
    counts = numbered(1)
    counts[sensor] += 1
    new = frames_of(CLASSIC, 1, counts)
    assert [snapshot.receive(f, CYCLE) for f in new] == [0, 0, 1]
    assert snapshot.counts == counts


def test_other_counts_after_a_complete_snapshot_begin_a_new_one_of_its_number():
    snapshot = Snapshot()
    send(snapshot, 1, 0)
    new = frames_of(CLASSIC, 1, numbered(9))
    assert [snapshot.receive(f, CYCLE) for f in new] == [0, 0, 1]
    assert snapshot.counts == numbered(9)
    assert snapshot.counters == {"snapshots": 2}


def test_other_counts_in_a_taken_place_bring_a_late_snapshots_number_back():
    snapshot, late = Snapshot(), WINDOW + 1
    old, new = frames_of(CLASSIC, 1, numbered(1)), frames_of(CLASSIC, 1, numbered(9))
    assert snapshot.receive(old[0], 0) == 0
    assert [snapshot.receive(f, late) for f in old[1:]] == [0, 0]
    assert snapshot.receive(new[1], late) == 0  # its place is free: still of the late one
    assert [snapshot.receive(f, late) for f in new] == [0, 0, 1]
    assert snapshot.counts == numbered(9)
    assert snapshot.counters == {"snapshots": 1, "late": 1}


def test_the_window_of_a_snapshot_that_other_counts_began_starts_anew():
    snapshot = Snapshot()
    old, new = frames_of(CLASSIC, 1, numbered(1)), frames_of(CLASSIC, 1, numbered(9))
    assert snapshot.receive(old[0], 0) == 0
    assert [snapshot.receive(f, WINDOW) for f in new[:2]] == [0, 0]
    assert snapshot.receive(new[2], 2 * WINDOW) == 1
    assert snapshot.counts == numbered(9)


def test_frames_from_the_past_are_ignored_even_amid_a_new_snapshot():
    snapshot = Snapshot()
    send(snapshot, 3, 0)
    send(snapshot, 4, CYCLE, (0,))
    assert send(snapshot, 3, CYCLE, (1,)) == [0]
    assert send(snapshot, 4, CYCLE, (1, 2)) == [0, 1]
    assert snapshot.counts == numbered(4)
    assert snapshot.counters == {"snapshots": 2, "reordered": 1}
    assert snapshot.faults() == REORDERED


@pytest.mark.parametrize(
    ("turn", "ahead", "newer"),
    [
        (True, 1, True), (True, 15, True), (True, 119, True), (True, 120, False),
        (True, 239, False), (False, 7, True), (False, 8, False), (False, 14, False),
    ],
)  # fmt: skip
def test_half_the_numbers_are_the_future_and_half_the_past(turn, ahead, newer):
    layout = completed(CLASSIC, turn=turn)
    snapshot = Snapshot(layout)
    send(snapshot, 5, 0)
    numbers = NUMBERS if turn else 15
    frames = frames_of(layout, (5 + ahead) % numbers, numbered(1))
    assert [snapshot.receive(f, CYCLE) for f in frames][-1] == int(newer)
    assert snapshot.counters.get("reordered", 0) == (0 if newer else 3)
    assert snapshot.counters.get("lost", 0) == (ahead - 1 if newer else 0)


def test_corrupted_frames_are_counted_and_ignored():
    snapshot = Snapshot()
    frames = frames_of(CLASSIC, 0, numbered(0))
    for byte in range(8):
        for bit in range(8):
            spoilt = frame(frames[0].id, frames[0].payload())
            spoilt.data[byte] ^= 1 << bit
            assert snapshot.receive(spoilt, 0) == 0
    assert [snapshot.receive(f, 0) for f in frames] == [0, 0, 1]
    assert snapshot.counts == numbered(0)
    assert snapshot.counters == {"snapshots": 1, "corrupted": 64}
    assert snapshot.faults() == CRC


def test_frames_swapped_between_identifiers_are_corrupted():
    """The identifier enters the check value, so slots cannot be exchanged."""
    snapshot = Snapshot()
    first, second, _ = frames_of(CLASSIC, 0, numbered(0))
    first.id, second.id = second.id, first.id
    assert (snapshot.receive(first, 0), snapshot.receive(second, 0)) == (0, 0)
    assert snapshot.counters == {"corrupted": 2}


def test_frames_of_the_wrong_kind_are_malformed():
    snapshot = Snapshot()
    good = frames_of(CLASSIC, 0, numbered(0))[0]
    remote = frame(good.id, good.payload(), remote=True)
    as_fd = frame(good.id, good.payload(), fd=True)
    short = frame(good.id, good.payload()[:7])
    empty = frame(good.id, b"")
    impossible = frame(good.id, good.payload())
    impossible.data[1] |= 0x0F
    impossible.data[0] = good_crc_of(impossible)
    for sent in (remote, as_fd, short, empty, impossible):
        assert snapshot.receive(sent, 0) == 0
    assert snapshot.counters == {"malformed": 5}
    assert snapshot.faults() == FORMAT


def good_crc_of(sent: Frame) -> int:
    from ccgen.e2e import crc8_j1850

    covered = sent.id.to_bytes(2, "little") + sent.payload()[1:]
    return crc8_j1850(covered, start=0, xor=0)


def test_other_frames_of_the_bus_are_none_of_our_business():
    snapshot = Snapshot()
    good = frames_of(CLASSIC, 0, numbered(0))[0]
    extended = frame(good.id, good.payload(), extended=True)
    assert snapshot.receive(extended, 0) == 0
    for id_ in (0, 0x2FF, 0x303, 0x30C, 0x7FF):
        assert snapshot.receive(frame(id_, b"\xff" * 8), 0) == 0
    assert snapshot.counters == {}
    assert snapshot.faults() == 0


def test_a_snapshot_that_takes_longer_than_the_window_is_dropped_whole():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    send(snapshot, 1, CYCLE, (0,))
    assert send(snapshot, 1, CYCLE + WINDOW + 1, (1, 2)) == [0, 0]
    assert snapshot.counts == numbered(0)
    assert snapshot.counters == {"snapshots": 1, "late": 1}
    assert snapshot.faults() == LATE
    assert send(snapshot, 2, 2 * CYCLE) == [0, 0, 1]
    assert snapshot.counters == {"snapshots": 2, "late": 1}


def test_the_window_includes_its_end_and_can_be_widened():
    snapshot = Snapshot()
    send(snapshot, 0, 0, (0, 1))
    assert send(snapshot, 0, WINDOW, (2,)) == [1]
    assert snapshot.c.ccgen_snapshot_set_window(snapshot.state, 500_000) == 0
    send(snapshot, 1, CYCLE, (0, 1))
    assert send(snapshot, 1, CYCLE + 500_000, (2,)) == [1]
    assert snapshot.counters == {"snapshots": 2}


@pytest.mark.parametrize(
    ("fd", "turn", "cycle_us", "widest"),
    [
        (False, True, CYCLE, 100 * CYCLE), (True, False, CYCLE, 100 * CYCLE),
        (False, False, CYCLE, 6 * CYCLE), (False, True, 1, 100), (False, False, 1, 6),
        (False, True, 3_000_000, 300_000_000), (False, True, 3_000_001, 300_000_000),
        (False, True, 300_000_000, 300_000_000), (False, False, 300_000_000, 300_000_000),
    ],
)  # fmt: skip
def test_a_window_wider_than_the_numbers_allow_is_refused(fd, turn, cycle_us, widest):
    origin = FD if fd else CLASSIC
    layout = completed(origin, turn=turn, cycle_us=cycle_us, window_us=cycle_us)
    assert load().ccgen_layout_window_max_us(ctypes.byref(layout)) == widest
    snapshot = Snapshot(layout)
    set_window = snapshot.c.ccgen_snapshot_set_window
    assert set_window(snapshot.state, ctypes.c_uint32(widest)) == 0
    before = snapshot.state.raw
    for refused in (widest + 1, 2**31, 2**32 - 1, 0):
        assert set_window(snapshot.state, ctypes.c_uint32(refused)) == -1
    assert snapshot.state.raw == before
    layout.window_us = widest
    assert load().ccgen_layout_valid(ctypes.byref(layout))
    layout.window_us = widest + 1
    assert not load().ccgen_layout_valid(ctypes.byref(layout))


@pytest.mark.parametrize(
    ("fd", "turn", "numbers"), [(0, 1, 240), (0, 0, 15), (1, 0, 256), (1, 1, 256)]
)
def test_numbers_are_as_many_as_counter_and_turn_give(fd, turn, numbers):
    layout = completed(FD if fd else CLASSIC, turn=bool(turn))
    assert load().ccgen_layout_valid(ctypes.byref(layout))
    assert layout.numbers == numbers
    sent = frames_of(layout, 3, [0] * layout.sensors)[0]
    protect, check = load().ccgen_layout_protect, load().ccgen_layout_check
    for number in range(256):
        result = protect(ctypes.byref(layout), ctypes.c_uint8(number), ctypes.byref(sent))
        assert result == (0 if number < numbers else -1)
        if number < numbers:
            assert check(ctypes.byref(layout), ctypes.byref(sent)) == number
            assert profile_of(layout).check(layout.base_id & 0xFFFF, sent.payload()) == (
                number % (256 if fd else 15)
            )


def test_a_sender_that_restarts_is_heard_after_three_cycles_of_silence():
    snapshot = Snapshot()
    send(snapshot, 9, 0)
    assert send(snapshot, 2, 3 * CYCLE) == [0, 0, 0]  # still within: from the past
    assert send(snapshot, 2, 3 * CYCLE + 1) == [0, 0, 1]
    assert snapshot.counts == numbered(2)
    assert snapshot.counters == {"snapshots": 2, "reordered": 3}
    assert snapshot.faults() == REORDERED | STALE


@pytest.mark.parametrize("told", ["by the layout", "by a call"])
def test_silence_is_as_long_as_a_window_that_is_wider_than_three_cycles(told):
    wide = 20 * CYCLE
    if told == "by the layout":
        snapshot = Snapshot(completed(CLASSIC, window_us=wide))
    else:
        snapshot = Snapshot()
        assert snapshot.c.ccgen_snapshot_set_window(snapshot.state, ctypes.c_uint32(wide)) == 0
    send(snapshot, 9, 0)
    assert send(snapshot, 2, wide) == [0, 0, 0]
    assert send(snapshot, 2, wide + 1) == [0, 0, 1]
    assert snapshot.counters == {"snapshots": 2, "reordered": 3}


def test_frames_from_the_past_do_not_keep_a_restarted_sender_out():
    """It goes on sending at its cycle, and is taken up once three cycles have passed."""
    snapshot = Snapshot()
    send(snapshot, 5, 0)
    results = [send(snapshot, k, (k + 1) * CYCLE)[-1] for k in range(6)]
    assert results == [0, 0, 0, 1, 1, 1]


def test_a_sender_that_repeats_one_snapshot_for_ever_is_not_believed():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    for cycle in range(1, 20):
        assert send(snapshot, 0, cycle * CYCLE) == [0, 0, 0]
    assert snapshot.counters == {"snapshots": 1, "repeated": 57}
    assert snapshot.faults() == REPEATED | STALE


def test_an_incomplete_snapshot_before_silence_is_lost():
    snapshot = Snapshot()
    send(snapshot, 0, 0)
    send(snapshot, 1, CYCLE, (0, 1))
    snapshot.tick(5 * CYCLE)
    assert snapshot.counters == {"snapshots": 1, "lost": 1}
    assert send(snapshot, 1, 5 * CYCLE, (2,)) == [0]  # must not complete the forgotten one
    assert snapshot.counts == numbered(0)


def test_silence_is_stale_until_a_snapshot_is_complete():
    snapshot = Snapshot()
    snapshot.tick(7)
    snapshot.tick(7 + 3 * CYCLE)
    assert snapshot.faults() == 0
    snapshot.tick(8 + 3 * CYCLE)
    assert snapshot.faults() == STALE
    snapshot.tick(9 + 3 * CYCLE)
    assert snapshot.faults() == STALE
    send(snapshot, 0, 10 + 3 * CYCLE)
    snapshot.faults()
    snapshot.tick(11 + 3 * CYCLE)
    assert snapshot.faults() == 0


@pytest.mark.parametrize("start", [0, 2**31, 2**32 - 30])
def test_a_time_that_steps_back_counts_as_the_latest(start):
    """Two queues whose stamps are 5 us out of order, over the clock's wrap too."""
    snapshot = Snapshot()
    for k in range(1000):
        now = start + k * CYCLE
        snapshot.tick(now)
        assert send(snapshot, k, now - 5) == [0, 0, 1]
        snapshot.tick(now - 7)
        assert (snapshot.age(now - 8), snapshot.faults()) == (0, 0)
    assert snapshot.counters == {"snapshots": 1000}


@pytest.mark.parametrize(("behind", "late"), [(1, False), (2**31, False), (2**31 + 1, True)])
def test_less_than_half_the_clock_is_behind_and_more_is_ahead(behind, late):
    snapshot = Snapshot()
    send(snapshot, 0, 0, (0, 1))
    assert send(snapshot, 0, -behind, (2,)) == [int(not late)]


def test_age_counts_milliseconds_up_to_255_and_stays_there():
    snapshot = Snapshot()
    assert snapshot.age(0) == 255
    start = 2**32 - 1500  # the clock wraps on the way
    send(snapshot, 0, start)
    for ms in (0, 1, 2, 100, 254):
        snapshot.tick(start + 1000 * ms)
        assert snapshot.age(start + 1000 * ms) == ms
    for ms in (255, 256, 10_000):
        snapshot.tick(start + 1000 * ms)
        assert snapshot.age(start + 1000 * ms) == 255
    for quarter in range(1, 5):  # the clock comes round to where the snapshot was
        snapshot.tick(start + quarter * 2**30)
    assert snapshot.age(start + 2**32 + 1000) == 255


def test_an_age_may_be_asked_for_at_a_time_that_nothing_has_told_yet():
    snapshot = Snapshot()
    send(snapshot, 0, 7000)
    assert [snapshot.age(7000 + 1000 * ms) for ms in (0, 254, 255, 256, 511)] == [
        0, 254, 255, 255, 255,
    ]  # fmt: skip


@pytest.mark.parametrize("width", [2, 3, 4])
def test_counts_of_every_width_keep_their_sign_and_no_reading(width):
    top = 2 ** (8 * width - 1)
    layout = completed(CLASSIC, count_bytes=width)
    snapshot = Snapshot(layout)
    counts = [0, 1, -1, top - 1, 1 - top, -top, 12345]
    results = [snapshot.receive(f, 0) for f in frames_of(layout, 0, counts)]
    assert results[-1] == 1
    assert snapshot.counts == [0, 1, -1, top - 1, 1 - top, NO_READING, 12345]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sensors", 0), ("sensors", 17), ("rows", (0, 0, 0)), ("rows", (65, 0, 0)),
        ("rows", (12, 65, 0)), ("rows", (12, 12, 65)), ("count_bytes", 1), ("count_bytes", 5),
        ("angle_bytes", 3), ("cycle_us", 0), ("window_us", 0),
        ("cycle_us", 300_000_001), ("window_us", 100 * CYCLE + 1), ("base_id", 0x7FF),
    ],
)  # fmt: skip
def test_impossible_layouts_are_refused(name, value):
    layout = completed(CLASSIC, **{name: value})
    state = ctypes.create_string_buffer(load().probe_size(3))
    assert load().ccgen_snapshot_init(ctypes.byref(layout), state) == -1
    assert not load().ccgen_layout_valid(ctypes.byref(layout))
    assert state.raw == bytes(len(state))


def test_null_pointers_are_refused():
    snapshot, c = Snapshot(), load()
    layout, sent = ctypes.byref(CLASSIC), ctypes.byref(frame(0x300, b""))
    assert c.ccgen_snapshot_init(layout, None) == -1
    assert c.ccgen_snapshot_init(None, snapshot.state) == -1
    assert c.ccgen_snapshot_receive(None, snapshot.state, sent, 0) == -1
    assert c.ccgen_snapshot_receive(layout, None, sent, 0) == -1
    assert c.ccgen_snapshot_receive(layout, snapshot.state, None, 0) == -1
    assert c.ccgen_snapshot_tick(layout, None, 0) == -1
    assert c.ccgen_snapshot_tick(None, snapshot.state, 0) == -1
    assert c.ccgen_snapshot_age_ms(None, 0) == 255
    assert c.ccgen_snapshot_set_window(None, 5) == -1
    assert c.ccgen_snapshot_set_window(snapshot.state, 0) == -1


@dataclass
class Model:
    """The rules of snapshot.h, said again without bits, bytes or C, on sendings of any number."""

    slots: int = 3
    numbers: int = NUMBERS
    newest: int | None = None
    phase: str = "pending"
    placed: dict[int, int] = field(default_factory=dict)
    first: int = 0
    heard: int = 0
    published: list[int] = field(default_factory=list)
    counters: dict[str, int] = field(default_factory=dict)

    def count(self, name: str, by: int = 1) -> None:
        if by:
            self.counters[name] = self.counters.get(name, 0) + by

    def notice_silence(self, now: int) -> None:
        if self.newest is not None and now - self.heard > 3 * CYCLE:
            self.count("lost", int(self.phase == "pending"))
            self.newest = None

    def begin(self, number: int, now: int) -> None:
        self.newest, self.phase, self.placed, self.first = number, "pending", {}, now

    def receive(self, sending: int, number: int, slot: int, now: int) -> bool:
        """A sound frame; whether it completes a snapshot."""
        self.notice_silence(now)
        ahead = 0 if self.newest is None else (number - self.newest) % self.numbers
        if ahead >= (self.numbers + 1) // 2:
            self.count("reordered")
            return False
        self.heard = now
        interrupted = self.phase == "pending"
        if self.newest is None:
            self.begin(number, now)
        elif ahead > 0:
            self.count("lost", ahead - 1 + int(interrupted))
            self.begin(number, now)
        elif self.placed.get(slot, sending) != sending:
            self.count("lost", int(interrupted))
            self.begin(number, now)
        return self.store(sending, slot, now)

    def store(self, sending: int, slot: int, now: int) -> bool:
        if self.phase != "pending":
            self.count("repeated", int(self.phase == "complete"))
        elif now - self.first > WINDOW:
            self.count("late")
            self.phase = "late"
        elif slot in self.placed:
            self.count("repeated")
        else:
            self.placed[slot] = sending
            if len(self.placed) == self.slots:
                self.count("snapshots")
                self.published = [self.placed[i] for i in range(self.slots)]
                self.phase = "complete"
                return True
        return False


jitter = st.sampled_from([0, 1, 100, 900, 1500, WINDOW, WINDOW + 1, CYCLE, 3 * CYCLE + 1])
events = st.tuples(
    st.sampled_from(["next", "next", "next", "skip", "back", "restart", "again", "corrupt"]),
    st.lists(st.integers(0, 2), min_size=0, max_size=5),
    st.booleans(),
    jitter,
    jitter,
)


@settings(max_examples=300)
@given(st.lists(events, max_size=25), st.integers(0, 2**32 - 1))
def test_any_sequence_of_mishaps_follows_the_rules(sequence, start):
    """Sendings differ in their counts; some take a number that another has just used."""
    snapshot, model = Snapshot(), Model()
    sending, number, now, used = 0, 100, start, {0: 100}
    for kind, extra, whole, pause, spread in sequence:
        if kind == "back":  # frames of an earlier sending
            sent = max(0, sending - 2)
        else:
            sending += 1
            number += {"skip": 3, "restart": 77, "again": 0}.get(kind, 1)
            used[sending], sent = number % NUMBERS, sending
        now += pause
        for slot in [*extra, *((0, 1, 2) if whole else ())]:
            now += spread // 3
            frame_ = frames_of(CLASSIC, used[sent], numbered(sent))[slot]
            if kind == "corrupt":
                frame_.data[3] ^= 0x10
                model.notice_silence(now)
                model.count("corrupted")
                expected = False
            else:
                expected = model.receive(sent, used[sent], slot, now)
            assert snapshot.receive(frame_, now) == int(expected)
            assert snapshot.counters == model.counters
            if expected:
                assert len({used[one] for one in model.published}) == 1
                share = [model.published[j // 3] for j in range(7)]
                assert snapshot.counts == [numbered(one)[j] for j, one in enumerate(share)]
