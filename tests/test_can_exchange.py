"""Snapshots and answers: matched, timed out, counted; against a node written in Python."""

from collections import deque
from dataclasses import replace
from types import SimpleNamespace

import cantools
import numpy as np
import pytest

from ccgen.can.codec import Codec
from ccgen.can.exchange import Pace, exchange, fresh_start
from ccgen.can.layout import FrameLayout
from ccgen.export.dbc import dbc_text

LAYOUT = FrameLayout(
    "shoulder", 0x300, False, False, ("u0", "u1", "u2", "v0", "v1", "v2"), (4, 4, 0), 2, 2, 10, 17
)
PER_SNAPSHOT = LAYOUT.angles_frames + 1
CYCLE = LAYOUT.cycle_ms / 1000
FRAME = 1e-4
TIMEOUT = Pace().timeout


def codec_for(layout):
    axis = SimpleNamespace(fraction_bits=18)
    sensors = [SimpleNamespace(name=name, metres_per_count=2e-6) for name in layout.sensors]
    joint = SimpleNamespace(sensors=sensors, can=SimpleNamespace(bitrate=1_000_000))
    readings = SimpleNamespace(zero=np.zeros(len(sensors), dtype=np.int64))
    model = SimpleNamespace(axes={"u": axis, "v": axis}, readings=readings)
    return Codec(layout, cantools.database.load_string(dbc_text(layout, joint, model), "dbc"))


def expected(counts):
    """The stand-in's answer: sums over the counts, different in every angle."""
    counts = np.asarray(counts)
    weights = np.arange(1, LAYOUT.values + 1)
    return counts.sum(axis=-1)[..., None] // weights


class PythonNode:
    """A bus with a node on it that answers every complete snapshot, and the clock of both.

    Time passes with each frame that is received and while nobody has anything to say, so nothing
    depends on the machine. `spoil` may replace each list of frames that answers a snapshot, and
    the first status comes when it is due.
    """

    def __init__(self):
        self.codec, self.spoil = codec_for(LAYOUT), lambda sample, frames: frames
        self.now = self.status_due = 0.0
        self.samples = self.statuses = 0
        self.parts, self.outgoing = {}, deque()
        self.heard = []  # (time, number) of every LENGTHS frame

    def perf_counter(self):
        return self.now

    monotonic = perf_counter

    def send(self, message, timeout=None):
        decoded = self.codec.decode(message)
        self.heard.append((self.now, decoded.number))
        self.parts.setdefault(decoded.number, {})[decoded.index] = decoded.values
        self.outgoing.extend(self.answer(decoded.number))

    def recv(self, timeout):
        if not self.outgoing and self.status_due <= self.now + timeout:
            self.now = max(self.now, self.status_due)
            self.status_due = self.now + CYCLE
            self.outgoing.append(self.status())
        self.now += FRAME if self.outgoing else max(timeout, FRAME)
        return self.outgoing.popleft() if self.outgoing else None

    def status(self):
        self.statuses += 1
        values = [self.samples % 2**16, 0, 0, 0]
        return self.codec.encode_frame("status", 0, values, (self.statuses - 1) % 15)

    def answer(self, number):
        parts = self.parts[number]
        if len(parts) < LAYOUT.lengths_frames:
            return []
        del self.parts[number]
        self.samples += 1
        self.status_due = self.now + CYCLE
        angles = expected([c for k in sorted(parts) for c in parts[k]]).tolist()
        frames = [
            self.codec.encode_frame("angles", k, angles[3 * k : 3 * k + 3], number)
            if k < 2
            else self.codec.encode_frame("angles", k, angles[6:], number)
            for k in range(LAYOUT.angles_frames)
        ]
        tip = self.codec.encode_frame("tip", 0, [self.samples, 0, -1], number)
        return self.spoil(self.samples, [*frames, tip, self.status()])


def snapshots(number):
    return np.random.default_rng(1).integers(-1000, 1000, (number, 6))


@pytest.fixture
def node(monkeypatch):
    node = PythonNode()
    monkeypatch.setattr("ccgen.can.exchange.time", node)
    return node


def run(node, counts, spoil=None, pace=None, on_answer=None):
    node.spoil = spoil or node.spoil
    return exchange(node, codec_for(LAYOUT), counts, pace, on_answer)


@pytest.mark.parametrize("in_flight", [1, 4, 14])
def test_every_answer_finds_its_snapshot(node, in_flight):
    counts = snapshots(60)
    result = run(node, counts, pace=Pace(in_flight=in_flight))
    np.testing.assert_array_equal(result.angles, expected(counts))
    np.testing.assert_array_equal(result.tips[:, 0], np.arange(1, 61))
    assert result.complete.all()
    assert (result.snapshots, result.lost_frames, result.corrupted, result.unexpected) == (
        60, 0, 0, 0,
    )  # fmt: skip
    assert result.statuses[-1].sample_counter == 60
    assert result.rate_hz > 0


def test_answers_are_told_as_they_come(node):
    told = []
    counts = snapshots(5)
    run(node, counts, on_answer=told.append)
    assert [(answer.index, list(answer.angles)) for answer in told] == list(
        enumerate(expected(counts).tolist())
    )
    assert [answer.tip for answer in told] == [(k, 0, -1) for k in range(1, 6)]
    assert told[-1].lost_frames == 0
    assert told[-1].status is not None


def test_numbers_come_round_after_240(node):
    counts = snapshots(500)
    result = run(node, counts, pace=Pace(first=235))
    np.testing.assert_array_equal(result.angles, expected(counts))
    assert [number for _, number in node.heard[::2]] == [(235 + k) % 240 for k in range(500)]
    assert result.lost_frames == 0


@pytest.mark.parametrize(("silence", "least"), [(None, CYCLE), (0.5, 0.5), (0.0, 0.0)])
def test_a_sender_keeps_silent_before_its_first_frame(node, silence, least):
    """A window of the layout unless told otherwise, and for a status in any case."""
    node.now = 3.0
    run(node, snapshots(5), pace=Pace(silence=silence))
    assert least <= node.heard[0][0] - 3.0 < least + 2 * CYCLE


@pytest.mark.parametrize("turn", [True, False])
def test_a_sender_that_starts_again_begins_with_a_number_that_was_not_just_seen(turn, node):
    """Runs with pauses of any length between them, none faster than a snapshot a cycle."""
    layout = replace(LAYOUT, turn=turn)
    node.codec, heard = codec_for(layout), []
    for pause in (0.0, 1e-4, CYCLE, 0.3, 2.37, 2.4, 2.41, 1000.0, 0.0):
        node.now += pause
        pace = fresh_start(layout, Pace(rate_hz=1 / CYCLE, in_flight=14))
        exchange(node, node.codec, snapshots(7), pace)
        heard, node.heard = [*heard, *node.heard[::2]], []
    assert len(heard) == 63
    for k, (now, number) in enumerate(heard):
        recent = {n for at, n in heard[:k] if now - at < CYCLE * layout.seen_cycles}
        assert number not in recent


def test_a_sender_faster_than_the_cycle_keeps_silent_for_the_widest_window(node):
    for pace in (Pace(), Pace(rate_hz=1.01 / CYCLE)):
        begin, node.heard = node.now, []
        run(node, snapshots(5), pace=fresh_start(LAYOUT, pace))
        assert 0.999 < (node.heard[0][0] - begin) / (100 * CYCLE) < 1.02


def test_snapshots_leave_at_the_rate_asked_for(node):
    result = run(node, snapshots(21), pace=Pace(rate_hz=100.0))
    assert result.complete.all()
    assert 0.2 <= result.seconds < 0.21


@pytest.mark.parametrize("victim", range(PER_SNAPSHOT))
def test_one_lost_frame_is_one_lost_frame(node, victim):
    def spoil(sample, frames):
        return frames[:victim] + frames[victim + 1 :] if sample == 7 else frames

    counts = snapshots(20)
    result = run(node, counts, spoil)
    assert result.lost_frames == 1
    assert np.flatnonzero(~result.complete).tolist() == [6]
    others = result.complete
    np.testing.assert_array_equal(result.angles[others], expected(counts)[others])


def test_a_frame_lost_from_the_last_answer_is_counted(node):
    result = run(node, snapshots(9), lambda s, f: f[1:] if s == 9 else f)
    assert (result.lost_frames, np.count_nonzero(~result.complete)) == (1, 1)


def test_a_lost_status_is_counted_by_its_counter(node):
    result = run(node, snapshots(20), lambda s, f: f[:-1] if s == 8 else f)
    assert (result.lost_frames, result.complete.all()) == (1, True)


def test_a_corrupted_frame_is_counted_and_lost(node):
    def spoil(sample, frames):
        if sample == 5:
            frames[1].data[4] ^= 0x10
        return frames

    result = run(node, snapshots(10), spoil)
    assert (result.corrupted, result.lost_frames) == (1, 1)


def test_a_repeated_frame_is_unexpected_but_nothing_is_lost(node):
    result = run(node, snapshots(10), lambda s, f: [f[0], *f])
    assert (result.unexpected, result.lost_frames) == (10, 0)


def test_a_node_that_falls_silent_loses_all_the_rest_in_bounded_time(node):
    result = run(node, snapshots(500), lambda s, f: f if s <= 50 else [])
    assert np.count_nonzero(result.complete) == 50
    assert result.lost_frames >= 450 * PER_SNAPSHOT
    assert node.now < 5 * TIMEOUT


def test_a_node_that_leaves_out_a_frame_every_time_ends_in_bounded_time(node):
    result = run(node, snapshots(500), lambda s, f: f if s <= 50 else f[1:])
    assert np.count_nonzero(result.complete) == 50
    assert result.lost_frames > 450
    assert node.now < 5 * TIMEOUT


def test_where_nobody_answers_every_frame_is_lost(node):
    node.status_due, node.answer = np.inf, lambda number: []
    result = run(node, snapshots(30))
    assert result.lost_frames == 30 * PER_SNAPSHOT
    assert (result.complete.any(), result.rate_hz) == (False, 0.0)
    assert node.now < 3 * TIMEOUT


def test_a_node_that_takes_its_time_to_start_still_has_to_report_the_last_snapshot(node):
    node.status_due = 0.9 * TIMEOUT
    result = run(node, snapshots(9), lambda s, f: f[:-1] if s == 9 else f)
    assert (result.lost_frames, result.complete.all()) == (1, True)
    assert result.statuses[-1].sample_counter == 9


def test_one_stall_of_all_that_is_in_flight_does_not_end_the_exchange(node):
    result = run(node, snapshots(60), lambda s, f: [] if 10 < s <= 24 else f, Pace(in_flight=14))
    assert result.lost_frames >= 14 * PER_SNAPSHOT
    assert result.complete[24:].all()


@pytest.mark.parametrize("in_flight", [0, 240])
def test_more_in_flight_than_numbers_are_refused(in_flight):
    with pytest.raises(ValueError, match="1 to 239 work"):
        exchange(SimpleNamespace(), codec_for(LAYOUT), snapshots(1), Pace(in_flight=in_flight))
