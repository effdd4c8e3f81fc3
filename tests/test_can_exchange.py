"""Snapshots and answers: matched, timed out, counted; against a node written in Python."""

import threading
from dataclasses import replace
from types import SimpleNamespace

import can
import cantools
import numpy as np
import pytest

from ccgen.can.codec import Codec
from ccgen.can.exchange import Pace, exchange
from ccgen.can.layout import FrameLayout
from ccgen.export.dbc import dbc_text

LAYOUT = FrameLayout("shoulder", 0x300, False, False, 3, 3, 4, 2, 2, 10, 17)
PER_SNAPSHOT = LAYOUT.angles_frames + 1
QUICK = Pace(timeout=0.4)


def codec_for(layout):
    axis = SimpleNamespace(transducer=SimpleNamespace(metres_per_count=2e-6), fraction_bits=18)
    joint = SimpleNamespace(u=axis, v=axis, can=SimpleNamespace(bitrate=1_000_000))
    text = dbc_text(layout, joint, SimpleNamespace(u=axis, v=axis))
    return Codec(layout, cantools.database.load_string(text, "dbc"))


def expected(counts):
    """The stand-in's answer: sums over the counts, different in every angle."""
    counts = np.asarray(counts)
    weights = np.arange(1, 2 * LAYOUT.segments + 1)
    return counts.sum(axis=-1)[..., None] // weights


class PythonNode:
    """Answers every complete snapshot; `spoil` may replace each outgoing list of frames."""

    def __init__(self, channel, spoil=lambda sample, frames: frames):
        self.codec, self.spoil = codec_for(LAYOUT), spoil
        self.bus = can.Bus(interface="virtual", channel=channel)
        self.stop = threading.Event()
        self.samples = self.statuses = 0
        self.parts = {}
        self.thread = threading.Thread(target=self.serve)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        self.thread.join(timeout=5)
        assert not self.thread.is_alive()
        self.bus.shutdown()

    def serve(self):
        while not self.stop.is_set():
            message = self.bus.recv(LAYOUT.cycle_ms / 1000)
            decoded = self.codec.decode(message) if message is not None else None
            frames = [] if message is not None else [self.status()]
            if decoded is not None:
                self.parts.setdefault(decoded.counter, {})[decoded.index] = decoded.values
                frames = self.answer(decoded.counter)
            for frame in frames:
                self.bus.send(frame)

    def status(self):
        self.statuses += 1
        values = [self.samples % 2**16, 0, 0, 0]
        return self.codec.encode_frame("status", 0, values, (self.statuses - 1) % 15)

    def answer(self, counter):
        parts = self.parts[counter]
        if len(parts) < LAYOUT.lengths_frames:
            return []
        del self.parts[counter]
        self.samples += 1
        angles = expected([c for k in sorted(parts) for c in parts[k]]).tolist()
        frames = [
            self.codec.encode_frame("angles", k, angles[3 * k : 3 * k + 3], counter)
            if k < 2
            else self.codec.encode_frame("angles", k, angles[6:], counter)
            for k in range(LAYOUT.angles_frames)
        ]
        tip = self.codec.encode_frame("tip", 0, [self.samples, 0, -1], counter)
        return self.spoil(self.samples, [*frames, tip, self.status()])


def snapshots(number):
    return np.random.default_rng(1).integers(-1000, 1000, (number, 6))


def run(channel, counts, spoil=lambda sample, frames: frames, pace=QUICK, on_answer=None):
    with (
        PythonNode(channel, spoil),
        can.Bus(interface="virtual", channel=channel) as bus,
    ):
        return exchange(bus, codec_for(LAYOUT), counts, pace, on_answer)


@pytest.mark.parametrize("in_flight", [1, 4, 14])
def test_every_answer_finds_its_snapshot(request, in_flight):
    counts = snapshots(60)
    result = run(request.node.name, counts, pace=replace(QUICK, in_flight=in_flight))
    np.testing.assert_array_equal(result.angles, expected(counts))
    np.testing.assert_array_equal(result.tips[:, 0], np.arange(1, 61))
    assert result.complete.all()
    assert (result.snapshots, result.lost_frames, result.corrupted, result.unexpected) == (
        60, 0, 0, 0,
    )  # fmt: skip
    assert result.statuses[-1].sample_counter == 60
    assert result.rate_hz > 0


def test_answers_are_told_as_they_come(request):
    told = []
    counts = snapshots(5)
    run(request.node.name, counts, on_answer=told.append)
    assert [(answer.index, list(answer.angles)) for answer in told] == list(
        enumerate(expected(counts).tolist())
    )
    assert [answer.tip for answer in told] == [(k, 0, -1) for k in range(1, 6)]
    assert told[-1].lost_frames == 0
    assert told[-1].status is not None


def test_snapshots_leave_at_the_rate_asked_for(request):
    result = run(request.node.name, snapshots(21), pace=replace(QUICK, rate_hz=100.0))
    assert result.complete.all()
    assert result.seconds >= 0.2


@pytest.mark.parametrize("victim", range(PER_SNAPSHOT))
def test_one_lost_frame_is_one_lost_frame(request, victim):
    def spoil(sample, frames):
        return frames[:victim] + frames[victim + 1 :] if sample == 7 else frames

    counts = snapshots(20)
    result = run(request.node.name, counts, spoil)
    assert result.lost_frames == 1
    assert np.flatnonzero(~result.complete).tolist() == [6]
    others = result.complete
    np.testing.assert_array_equal(result.angles[others], expected(counts)[others])


def test_a_frame_lost_from_the_last_answer_is_counted(request):
    result = run(request.node.name, snapshots(9), lambda s, f: f[1:] if s == 9 else f)
    assert (result.lost_frames, np.count_nonzero(~result.complete)) == (1, 1)


def test_a_lost_status_is_counted_by_its_counter(request):
    result = run(request.node.name, snapshots(20), lambda s, f: f[:-1] if s == 8 else f)
    assert (result.lost_frames, result.complete.all()) == (1, True)


def test_a_corrupted_frame_is_counted_and_lost(request):
    def spoil(sample, frames):
        if sample == 5:
            frames[1].data[4] ^= 0x10
        return frames

    result = run(request.node.name, snapshots(10), spoil)
    assert (result.corrupted, result.lost_frames) == (1, 1)


def test_a_repeated_frame_is_unexpected_but_nothing_is_lost(request):
    result = run(request.node.name, snapshots(10), lambda s, f: [f[0], *f])
    assert (result.unexpected, result.lost_frames) == (10, 0)


def test_a_node_that_falls_silent_loses_all_the_rest_in_bounded_time(request):
    result = run(request.node.name, snapshots(500), lambda s, f: f if s <= 50 else [])
    assert np.count_nonzero(result.complete) == 50
    assert result.lost_frames >= 450 * PER_SNAPSHOT


def test_a_node_that_leaves_out_a_frame_every_time_ends_in_bounded_time(request):
    result = run(request.node.name, snapshots(500), lambda s, f: f if s <= 50 else f[1:])
    assert np.count_nonzero(result.complete) == 50
    assert result.lost_frames > 450


def test_where_nobody_answers_every_frame_is_lost(request):
    with can.Bus(interface="virtual", channel=request.node.name) as bus:
        result = exchange(bus, codec_for(LAYOUT), snapshots(30), QUICK)
    assert result.lost_frames == 30 * PER_SNAPSHOT
    assert (result.complete.any(), result.rate_hz) == (False, 0.0)


def test_one_stall_of_all_that_is_in_flight_does_not_end_the_exchange(request):
    result = run(
        request.node.name,
        snapshots(60),
        lambda s, f: [] if 10 < s <= 24 else f,
        replace(QUICK, in_flight=14),
    )
    assert result.lost_frames >= 14 * PER_SNAPSHOT
    assert result.complete[24:].all()


@pytest.mark.parametrize("in_flight", [0, 15])
def test_more_in_flight_than_counters_are_refused(in_flight):
    with pytest.raises(ValueError, match="1 to 14 work"):
        exchange(SimpleNamespace(), codec_for(LAYOUT), snapshots(1), Pace(in_flight=in_flight))
