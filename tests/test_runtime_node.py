"""The joint's node: what goes out for what came in, and what the status says about it."""

import ctypes
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runtime_c import UNDEFINED, Frame, frame, junk, load
from test_runtime_estimator import sample_model

from ccgen.e2e import P01, P05, crc8_j1850

CRC, FORMAT, REPEATED, REORDERED, LOST, LATE, MISSING, STALE = (1 << bit for bit in range(8))
CYCLE = 10_000
BASE, ANGLES, TIP, STATUS = 0x300, 0x302, 0x30A, 0x30B
COUNTS = (100, -200, 300, 4000, -5000, 6000)


@dataclass(frozen=True)
class Status:
    counter: int
    samples: int
    missing: int
    faults: int
    age: int


class Node:
    """The sample joint's node in the shared port."""

    def __init__(self, fd: bool = False) -> None:
        flags = ("-O1", *UNDEFINED, "-DSAMPLE_FD=1") if fd else ("-O1", *UNDEFINED)
        self.c, self.fd = load(flags), fd
        self.profile = P05 if fd else P01
        self.state = junk(self.c.ccgen_shared_node_size())
        assert self.c.ccgen_shared_node_init(self.state) == 0

    def receive(self, sent: Frame, now: int) -> int:
        return self.c.ccgen_shared_node_receive(
            self.state, sent.id, int(sent.extended), int(sent.fd), ctypes.c_size_t(sent.length),
            sent.payload(), ctypes.c_uint32(now),
        )  # fmt: skip

    def send(self, number: int, counts: tuple[int, ...], now: int) -> int:
        """All LENGTHS frames; the last one's result."""
        share, length = (30, 16) if self.fd else (3, 8)
        turn, counter = (0, number) if self.fd else divmod(number, 15)
        result = 0
        for slot, first in enumerate(range(0, len(counts), share)):
            body = np.array(counts[first : first + share], "<i2").tobytes()
            header = bytes(3) if self.fd else bytes((0, turn << 4))
            data = self.profile.protect(BASE + slot, counter, (header + body).ljust(length, b"\0"))
            result = self.receive(frame(BASE + slot, data, fd=self.fd), now)
        return result

    def unsent(self) -> int:
        return self.c.ccgen_shared_node_unsent(self.state)

    def fetch(self, now: int, at_most: int = 1000) -> list[Frame]:
        """What the node sends, checked as a receiver does."""
        fetched: list[Frame] = []
        id_, flags, data = ctypes.c_uint32(), (ctypes.c_uint8 * 3)(), (ctypes.c_uint8 * 64)()
        parts = [ctypes.byref(flags, index) for index in range(3)]
        while len(fetched) < at_most:
            result = self.c.ccgen_shared_node_transmit(
                self.state, ctypes.c_uint32(now), ctypes.byref(id_), *parts, data
            )
            if result != 1:
                assert result == 0
                break
            got = frame(id_.value, bytes(data[: flags[2]]), fd=bool(flags[1]))
            lengths = (64, 12, 12) if self.fd else (8,) * 10
            length = lengths[got.id - BASE - (1 if self.fd else 2)]
            assert (bool(flags[0]), got.fd, got.length) == (False, self.fd, length)
            assert self.profile.check(got.id, got.payload()) is not None
            fetched.append(got)
        return fetched

    def number_of(self, got: Frame) -> int:
        """Of a snapshot; a STATUS frame's own counter."""
        return got.data[2] if self.fd else (got.data[1] & 0x0F) + 15 * (got.data[1] >> 4)

    def status_of(self, got: Frame) -> Status:
        start = 3 if self.fd else 2
        samples, missing = np.frombuffer(got.payload()[start : start + 4], "<u2").tolist()
        return Status(
            self.number_of(got), samples, missing, got.data[start + 4], got.data[start + 5]
        )

    def status(self, now: int) -> Status:
        """The last status of what is due."""
        index = 0x303 if self.fd else STATUS
        return [self.status_of(got) for got in self.fetch(now) if got.id == index][-1]

    def counters(self) -> dict[str, int]:
        names = (
            "snapshots", "corrupted", "malformed", "repeated", "reordered", "lost", "late",
            "estimates", "failures", "overruns",
        )  # fmt: skip
        values = (ctypes.c_uint32 * 10)()
        assert self.c.ccgen_shared_node_counters(self.state, values) == 0
        return {name: value for name, value in zip(names, values, strict=True) if value}


def signals(frames: list[Frame], header: int, total: int) -> list[int]:
    """Little-endian int16 signals of several frames as one list."""
    body = b"".join(got.payload()[header:] for got in frames)
    return np.frombuffer(body[: 2 * total], "<i2").tolist()


def expected_angles(counts: tuple[int, ...]) -> list[int]:
    u, v = sample_model(0), sample_model(1)
    return [*u.estimate(counts[:3]).tolist(), *v.estimate(counts[3:]).tolist()]


def test_a_snapshot_is_answered_by_angles_tip_and_status():
    node = Node()
    node.fetch(0)
    assert node.send(7, COUNTS, 100) == 1
    answer = node.fetch(200)
    assert [got.id for got in answer] == [*range(ANGLES, TIP), TIP, STATUS]
    assert {node.number_of(got) for got in answer[:-1]} == {7}
    assert signals(answer[:8], 2, 24) == expected_angles(COUNTS)
    assert node.status_of(answer[-1]) == Status(counter=1, samples=1, missing=0, faults=0, age=0)
    assert node.fetch(300) == []


@pytest.mark.parametrize("number", [0, 14, 15, 16, 200, 239])
def test_an_answer_repeats_the_number_of_its_snapshot_and_status_has_turn_0(number):
    node = Node()
    node.send(number, COUNTS, 0)
    *answer, status = node.fetch(0)
    assert {(got.data[1] >> 4, got.data[1] & 0x0F) for got in answer} == {divmod(number, 15)}
    assert (status.id, status.data[1] >> 4) == (STATUS, 0)


def test_fd_answers_in_frames_as_long_as_they_need_to_be_under_p05():
    node = Node(fd=True)
    node.fetch(0)
    assert node.send(200, COUNTS, 100) == 1
    answer = node.fetch(200)
    assert [got.id for got in answer] == [0x301, 0x302, 0x303]
    assert [node.number_of(got) for got in answer] == [200, 200, 1]
    assert signals(answer[:1], 3, 24) == expected_angles(COUNTS)
    assert answer[0].payload()[3 + 48 :] == bytes(13)
    assert node.status_of(answer[2]) == Status(counter=1, samples=1, missing=0, faults=0, age=0)


def test_the_tip_frame_holds_the_tip_position():
    node = Node()
    node.send(0, COUNTS, 0)
    answer = node.fetch(0)
    angles = np.array(signals(answer[:8], 2, 24), np.int16)
    positions, rotations = np.zeros((13, 3), np.float32), np.zeros((13, 3, 3), np.float32)
    arguments = [ctypes.c_void_p(a.ctypes.data) for a in (angles, positions, rotations)]
    load().ccgen_batch_poses(arguments[0], ctypes.c_size_t(1), *arguments[1:])
    raw = np.array(signals(answer[8:9], 2, 3))
    assert np.abs(raw - positions[12].astype(np.float64) * 2**16).max() <= 0.5
    assert raw[2] > 0.2 * 2**16


def test_a_missing_sensor_gives_no_angles_and_the_status_says_which():
    node = Node()
    node.send(0, COUNTS, 0)
    node.fetch(0)
    assert node.send(1, (100, -32768, 300, 1, 2, 20001), CYCLE) == -2
    answer = node.fetch(CYCLE)
    assert [node.number_of(got) for got in answer[:-1]] == [1] * 9
    assert signals(answer[:8], 2, 24) == [-32768] * 24
    assert signals(answer[8:9], 2, 3) == [-32768] * 3
    status = node.status_of(answer[-1])
    assert (status.missing, status.faults) == (0b10 | 0b100 << 8, MISSING)
    node.send(2, COUNTS, 2 * CYCLE)
    answer = node.fetch(2 * CYCLE)
    assert signals(answer[:8], 2, 24) == expected_angles(COUNTS)
    assert (node.status_of(answer[-1]).missing, node.status_of(answer[-1]).faults) == (0, 0)
    assert node.counters() == {"snapshots": 3, "estimates": 2, "failures": 1}


@pytest.mark.parametrize(
    ("counts", "missing"),
    [
        ((100, -32768, 300, 4000, -5000, 6000), 0b10),
        ((100, -200, 300, 4000, -5000, -32768), 0b100 << 8),
    ],
    ids=["u", "v"],
)
def test_a_sensor_missing_on_one_axis_alone_is_a_fault_too(counts, missing):
    node = Node()
    assert node.send(0, counts, 0) == -2
    status = node.status(0)
    assert (status.missing, status.faults) == (missing, MISSING)


@pytest.mark.parametrize(
    ("mishap", "fault"),
    [
        (lambda good: frame(BASE, good[:2] + b"\x7f" + good[3:]), CRC),
        (lambda good: frame(BASE, good[:5]), FORMAT),
        (lambda good: frame(BASE, good), REPEATED),
        (lambda good: frame(BASE, P01.protect(BASE, 2, bytes(8))), REORDERED),
        (lambda good: frame(BASE, P01.protect(BASE, 8, bytes(8))), LOST),
    ],
    ids=["corrupted", "malformed", "repeated", "reordered", "lost"],
)
def test_the_status_says_what_was_wrong_once(mishap, fault):
    node = Node()
    node.send(5, COUNTS, 0)
    node.fetch(0)
    good = P01.protect(BASE, 5, bytes(2) + np.array(COUNTS[:3], "<i2").tobytes())
    assert node.receive(mishap(good), 100) == 0
    assert node.status(2 * CYCLE).faults == fault
    assert node.status(3 * CYCLE).faults == 0


def test_a_status_that_could_not_be_sent_comes_again_with_all_its_faults():
    node = Node()
    node.send(5, COUNTS, 0)
    node.fetch(0)
    node.receive(frame(BASE, b"\1" * 8), 1)
    for k in range(3):
        (got,) = node.fetch(2 * CYCLE + k, at_most=1)
        assert node.status_of(got) == Status(1, 1, 0, CRC, 20)
        assert (node.unsent(), node.unsent()) == (1, 0)
        node.receive(frame(BASE, b"\1"), 2 * CYCLE + k) if k == 2 else None
    (got,) = node.fetch(2 * CYCLE + 3)
    assert node.status_of(got) == Status(1, 1, 0, CRC | FORMAT, 20)
    assert (node.unsent(), node.fetch(2 * CYCLE + 4)) == (0, [])
    assert node.status(3 * CYCLE + 3) == Status(2, 1, 0, STALE, 30)


def test_a_status_counts_as_sent_at_the_next_call_of_transmit():
    """What happens between the two is told by the next, the same fault again too."""
    node = Node()
    node.send(5, COUNTS, 0)
    node.fetch(0)
    node.receive(frame(BASE, b"\1" * 8), 1)
    (got,) = node.fetch(2 * CYCLE, at_most=1)
    assert node.status_of(got).faults == CRC
    node.receive(frame(BASE, b"\1" * 8), 2 * CYCLE + 1)
    assert node.status(3 * CYCLE).faults == CRC
    assert node.status(4 * CYCLE).faults == STALE


def test_a_sensor_that_goes_missing_while_a_status_is_on_its_way_is_told_by_the_next():
    node = Node()
    node.send(0, COUNTS, 0)
    node.fetch(0)
    (got,) = node.fetch(2 * CYCLE, at_most=1)
    assert node.status_of(got).faults == 0
    node.send(1, (100, -32768, 300, 4000, -5000, 6000), 2 * CYCLE + 1)
    assert node.status(2 * CYCLE + 1).faults == MISSING


@pytest.mark.parametrize("fd", [False, True])
def test_every_frame_of_an_answer_comes_again_as_often_as_it_is_taken_back(fd):
    node, twin = Node(fd), Node(fd)
    for one in (node, twin):
        one.fetch(0)
        one.receive(frame(BASE, b"\1", fd=fd), 50)
        one.send(77, COUNTS, 100)
    expected = [(got.id, got.payload()) for got in twin.fetch(200)]
    got = []
    while frames := node.fetch(200, at_most=1):
        again = [frames[0], *(node.fetch(200, at_most=1)[0] for _ in range(3) if node.unsent())]
        assert len({one.payload() for one in again}) == 1
        got.append((again[-1].id, again[-1].payload()))
    assert got == expected
    assert node.counters() == twin.counters()


def test_an_answer_that_a_newer_snapshot_replaced_does_not_come_again():
    node = Node()
    node.fetch(0)
    node.send(0, COUNTS, 0)
    node.fetch(0, at_most=4)
    node.send(1, (1, 2, 3, 4, 5, 6), CYCLE)
    assert node.unsent() == 0
    answer = node.fetch(CYCLE)
    assert [got.id for got in answer] == [*range(ANGLES, TIP), TIP, STATUS]
    assert {node.number_of(got) for got in answer[:-1]} == {1}


def test_a_status_taken_back_after_a_newer_snapshot_keeps_its_faults_and_its_counter():
    node = Node()
    node.fetch(0)
    node.receive(frame(BASE, b"\1" * 8), 1)
    node.send(0, COUNTS, 2)
    last = node.fetch(2, at_most=10)[-1]
    assert node.status_of(last) == Status(1, 1, 0, CRC, 0)
    node.send(1, COUNTS, CYCLE)
    assert node.unsent() == 1
    answer = node.fetch(CYCLE)
    assert [got.id for got in answer] == [*range(ANGLES, TIP), TIP, STATUS]
    assert node.status_of(answer[-1]) == Status(1, 2, 0, CRC, 0)
    assert node.counters()["snapshots"] == 2
    assert "overruns" not in node.counters()


def test_nothing_can_be_taken_back_where_nothing_was_handed_out():
    node = Node()
    assert node.unsent() == 0
    node.fetch(0)
    assert node.unsent() == 0  # the last call of transmit gave nothing


@pytest.mark.parametrize("start", [0, 2**32 - 400_000])
def test_stamps_that_lag_behind_the_loop_by_5_microseconds_do_no_harm(start):
    node, statuses = Node(), []
    node.fetch(start)
    for k in range(1, 1001):
        now = start + k * CYCLE
        statuses += [got for got in node.fetch(now) if got.id == STATUS]
        assert node.send(k % 240, COUNTS, now - 5) == 1
        statuses += [got for got in node.fetch(now - 5) if got.id == STATUS]
    assert node.counters() == {"snapshots": 1000, "estimates": 1000}
    assert len(statuses) >= 1000
    assert {node.status_of(got).faults for got in statuses} == {0}


def test_faults_of_several_kinds_accumulate():
    node = Node()
    node.send(5, COUNTS, 0)
    node.fetch(0)
    node.receive(frame(BASE, b"\1" * 8), 1)
    node.receive(frame(BASE, b"\1"), 2)
    node.receive(frame(BASE, P01.protect(BASE, 7, bytes(8))), 3)
    node.receive(frame(BASE + 1, P01.protect(BASE + 1, 7, bytes(8))), CYCLE + 4)
    assert node.status(2 * CYCLE).faults == CRC | FORMAT | LOST | LATE


def test_p01_frame_with_counter_15_is_malformed():
    node = Node()
    body = b"\x0f" + bytes(6)
    crc = crc8_j1850(BASE.to_bytes(2, "little") + body, start=0, xor=0)
    assert node.receive(frame(BASE, bytes([crc]) + body), 0) == 0
    assert node.counters() == {"malformed": 1}


def test_without_snapshots_a_status_goes_out_every_cycle():
    node = Node()
    sent = [now for now in range(0, 100_000, 500) for _ in node.fetch(now)]
    assert sent == list(range(0, 100_000, CYCLE))


def test_a_steady_sender_gets_one_status_a_snapshot_in_spite_of_jitter():
    node = Node()
    node.fetch(0)
    random = np.random.default_rng(5)
    due = [k * CYCLE + int(random.integers(-2000, 2000)) for k in range(1, 60)]
    statuses, k = 0, 0
    for now in range(0, 600_000, 250):
        if k < len(due) and now >= due[k]:
            assert node.send(k, COUNTS, now) == 1
            k += 1
        if k < len(due):
            statuses += sum(got.id == STATUS for got in node.fetch(now))
    assert abs(statuses - len(due)) <= 1


def test_a_snapshot_that_stays_away_brings_a_status_within_one_and_a_half_cycles():
    node = Node()
    node.send(0, COUNTS, 0)
    node.fetch(0)
    times = [now for now in range(100, 60_000, 100) for _ in node.fetch(now)]
    assert times == [15_000, 25_000, 35_000, 45_000, 55_000]


def test_silence_is_reported_as_stale_with_its_age():
    node = Node()
    node.send(0, COUNTS, 0)
    node.fetch(0)
    assert node.status(2 * CYCLE) == Status(1, 1, 0, 0, 20)
    assert node.status(4 * CYCLE) == Status(2, 1, 0, STALE, 40)
    assert node.status(30 * CYCLE) == Status(3, 1, 0, STALE, 255)


def test_status_counter_runs_through_all_values():
    node = Node()
    counters = [node.status(k * CYCLE).counter for k in range(32)]
    assert counters == [k % 15 for k in range(32)]


def test_an_estimate_that_was_not_fetched_is_replaced_and_counted():
    node = Node()
    node.fetch(0)
    node.send(0, COUNTS, 0)
    node.fetch(0, at_most=4)
    node.send(1, (1, 2, 3, 4, 5, 6), CYCLE)
    answer = node.fetch(CYCLE)
    assert signals(answer[:8], 2, 24) == expected_angles((1, 2, 3, 4, 5, 6))
    assert {node.number_of(got) for got in answer[:-1]} == {1}
    assert node.counters() == {"snapshots": 2, "estimates": 2, "overruns": 1}


def test_the_sample_counter_counts_complete_snapshots():
    node = Node(fd=True)
    for k in range(300):
        node.send(k % 256, COUNTS, k * CYCLE)
        node.fetch(k * CYCLE)
    assert node.status(301 * CYCLE).samples == 300


def test_a_node_can_widen_its_window():
    node = Node()
    late = frame(BASE + 1, P01.protect(BASE + 1, 0, bytes(8)))
    first = frame(BASE, P01.protect(BASE, 0, bytes(8)))
    assert node.c.ccgen_shared_node_set_window(node.state, 900_000) == 0
    assert (node.receive(first, 0), node.receive(late, 900_000)) == (0, 1)


def test_a_node_has_no_window_wider_than_100_cycles():
    node = Node()
    set_window = node.c.ccgen_shared_node_set_window
    assert set_window(node.state, 100 * CYCLE) == 0
    assert set_window(node.state, 100 * CYCLE + 1) == -1
    late = frame(BASE + 1, P01.protect(BASE + 1, 0, bytes(8)))
    first = frame(BASE, P01.protect(BASE, 0, bytes(8)))
    assert (node.receive(first, 0), node.receive(late, 100 * CYCLE)) == (0, 1)


def test_own_frames_heard_back_do_no_harm():
    node = Node()
    node.send(0, COUNTS, 0)
    before = node.counters()
    for got in node.fetch(0):
        assert node.receive(got, 0) == 0
    assert node.counters() == before


def test_null_pointers_are_refused():
    c, node = load(), Node()
    some = (ctypes.c_uint8 * 64)()
    assert c.ccgen_shared_node_init(None) == -1
    assert c.ccgen_shared_node_receive(None, 0, 0, 0, ctypes.c_size_t(0), some, 0) == -1
    assert c.ccgen_shared_node_receive(node.state, 0, 0, 0, ctypes.c_size_t(8), None, 0) == -1
    assert c.ccgen_shared_node_receive(node.state, 0, 0, 0, ctypes.c_size_t(65), some, 0) == -3
    assert c.ccgen_shared_node_transmit(node.state, 0, None, some, some, some, some) == -1
    assert c.ccgen_shared_node_counters(node.state, None) == -1
    assert c.ccgen_shared_node_set_window(None, 1) == -1
    assert c.ccgen_shared_node_unsent(None) == -1
    assert c.ccgen_shared_shape(None) == -1


def test_the_shared_port_tells_the_joints_shape():
    shape = (ctypes.c_int32 * 4)()
    assert load().ccgen_shared_shape(shape) == 0
    assert list(shape) == [12, 6, 24, 16]


def test_batch_jacobians_are_laid_out_row_by_row():
    """The sample's Jacobian at the straight pose: hinges at the base of each 20 mm segment."""
    angles = np.zeros((2, 24), np.int16)
    jacobians = np.zeros((2, 6, 24), np.float32)
    arguments = [ctypes.c_void_p(a.ctypes.data) for a in (angles, jacobians)]
    assert load().ccgen_batch_jacobians(arguments[0], ctypes.c_size_t(2), arguments[1]) == 0
    arms = 0.24 - 0.02 * np.arange(12)
    expected = np.zeros((6, 24))
    expected[1, :12], expected[3, :12] = -arms, 1
    expected[0, 12:], expected[4, 12:] = arms, 1
    np.testing.assert_allclose(jacobians, [expected] * 2, atol=1e-6)


@pytest.mark.parametrize(
    ("position", "shift", "signal"),
    [
        (0, 1, 0), (1, 1, 1), (-1, 1, 0), (-2, 1, -1), (-3, 1, -1), (3, 2, 1), (1, 2, 0), (2, 2, 1),
        (-2, 2, 0), (-3, 2, -1), (32767 << 10, 10, 32767), ((32767 << 10) + 511, 10, 32767),
        ((32767 << 10) + 512, 10, 32767), (2**31 - 1, 10, 32767), (2**31 - 1, 16, 32767),
        (2**31 - 1, 31, 1), (-(2**31), 31, -1), (2**30, 31, 1), (-(2**30), 31, 0),
        (-(2**31), 16, -32767), (-(2**31), 10, -32767), (-(32767 << 10), 10, -32767),
        (-(32767 << 10) - 513, 10, -32767),
    ],
)  # fmt: skip
def test_tip_coordinates_are_rounded_and_clipped(position, shift, signal):
    assert load().ccgen_tip_signal(position, shift) == signal


@given(st.integers(-(2**31), 2**31 - 1), st.integers(1, 31))
def test_a_tip_coordinate_is_the_nearest_and_halves_go_up(position, shift):
    steps = (position + (1 << (shift - 1))) >> shift
    assert load().ccgen_tip_signal(position, shift) == max(-32767, min(32767, steps))
