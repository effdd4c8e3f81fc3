"""Snapshots to a node and its answers back, with every frame that fails to come counted.

The node answers a snapshot with its ANGLES frames and TIP, under the snapshot's counter. A frame
is lost when it has not come by the time a later snapshot is answered in full, or when the time-out
passes. STATUS frames come with every answer and, once a cycle, without one; they count themselves,
so one is lost where their counter jumps, or where none ever reports the last snapshot.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import or_

import can
import numpy as np
from numpy.typing import NDArray

from ccgen.can.answers import PendingAnswer, StatusStream
from ccgen.can.codec import Codec, Status
from ccgen.can.transports.slcan import BlockSlcanBus

Integers = NDArray[np.int64]

_FAILED_ROUNDS = 3
"""After so many time-outs of all that is in flight, one after the other, the rest is given up.

A node that has never said anything is given up at the first."""

_LISTEN_CYCLES = 5
"""So many cycles, beyond the time-out, has an idle node to send the status due every cycle."""


@dataclass(frozen=True)
class Pace:
    """How snapshots are sent.

    Attributes:
        rate_hz: snapshots a second; None for as fast as answers come.
        in_flight: snapshots that wait for their answer at the same time, fewer than 15.
        timeout: seconds until an answer's missing frames are lost.
    """

    rate_hz: float | None = None
    in_flight: int = 4
    timeout: float = 5.0


@dataclass(frozen=True)
class Answer:
    """One snapshot's answer as it comes.

    Attributes:
        index: of the snapshot.
        angles: 2m raw angles, u segments first.
        tip: 3 raw coordinates.
        lost_frames: in this exchange so far.
        status: the latest; None before the first.
    """

    index: int
    angles: tuple[int, ...]
    tip: tuple[int, ...]
    lost_frames: int
    status: Status | None


OnAnswer = Callable[[Answer], None]


@dataclass(frozen=True, eq=False)
class Exchange:
    """What came of sending k snapshots.

    Attributes:
        angles: shape (k, 2m), raw angles, u segments first; 0 where `complete` does not hold.
        tips: shape (k, 3), raw tip coordinates.
        complete: shape (k,), whether all ANGLES frames and TIP came.
        statuses: every STATUS frame in order.
        lost_frames: expected frames that did not come.
        corrupted: frames that came but failed their checks; each is lost as well.
        unexpected: frames in answer to no snapshot in flight: repeated or too late.
        seconds: from the first frame sent to the last answer.
        gone: why the bus went away before the end; empty where it did not.
    """

    angles: Integers
    tips: Integers
    complete: NDArray[np.bool_]
    statuses: tuple[Status, ...]
    lost_frames: int
    corrupted: int
    unexpected: int
    seconds: float
    gone: str = ""

    @property
    def snapshots(self) -> int:
        """Snapshots that were to be sent."""
        return len(self.complete)

    @property
    def rate_hz(self) -> float:
        """Snapshots answered in full per second."""
        return float(np.count_nonzero(self.complete)) / self.seconds if self.seconds > 0 else 0.0

    @property
    def faults(self) -> int:
        """Every fault bit that some status reported."""
        return reduce(or_, (status.faults for status in self.statuses), 0)


def exchange(
    bus: can.BusABC,
    codec: Codec,
    counts: Integers,
    pace: Pace | None = None,
    on_answer: OnAnswer | None = None,
) -> Exchange:
    """Send every snapshot and collect the answers; returns in bounded time, whatever comes.

    Args:
        bus: the host's end.
        codec: of the joint.
        counts: shape (k, nu + nv).
        pace: rate, bound on snapshots in flight, time-out.
        on_answer: called with each answer when it is complete.

    Raises:
        ValueError: as many snapshots in flight as the counter can tell apart, or none; a count
            that does not fit the frame.
    """
    run = _Run(bus, codec, counts, pace or Pace(), on_answer)
    run.listen_for_status()
    run.stream()
    run.wait_for_last_status()
    return run.result()


class _Run:
    def __init__(
        self,
        bus: can.BusABC,
        codec: Codec,
        counts: Integers,
        pace: Pace,
        on_answer: OnAnswer | None,
    ) -> None:
        layout = codec.layout
        if not 1 <= pace.in_flight < layout.counter_modulus:
            raise ValueError(f"{pace.in_flight} in flight; 1 to {layout.counter_modulus - 1} work")
        self.bus, self.codec, self.layout = bus, codec, layout
        self.pace, self.on_answer = pace, on_answer
        self.counts: list[list[int]] = counts.tolist()
        self.angles = np.zeros((len(self.counts), 2 * layout.segments), dtype=np.int64)
        self.tips = np.zeros((len(self.counts), 3), dtype=np.int64)
        self.complete = np.zeros(len(self.counts), dtype=np.bool_)
        self.answer_frames = layout.angles_frames + 1
        self.pending: dict[int, PendingAnswer] = {}
        self.statuses = StatusStream(layout.counter_modulus)
        self.sent = self.answered = self.failed = self.lost = self.unexpected = 0
        self.refused = self._refused()
        self.begin = self.end = 0.0
        self.first_sample: int | None = None
        self.gone = ""

    def listen_for_status(self) -> None:
        """Learn from an idle node how many snapshots it has seen; none may come."""
        cycles = 1e-3 * self.layout.cycle_ms * _LISTEN_CYCLES
        patience = time.perf_counter() + self.pace.timeout + cycles
        while self.first_sample is None and time.perf_counter() < patience and not self._gone():
            self._receive(cycles)
            if self.statuses.seen:
                self.first_sample = self.statuses.seen[-1].sample_counter

    def stream(self) -> None:
        """Send and receive until every snapshot is answered or given up."""
        self.begin = self.end = time.perf_counter()
        while self.pending or self.sent < len(self.counts):
            now = time.perf_counter()
            self._expire(now)
            if self._gone():
                break
            if self._may_send(now):
                self._send(now)
            else:
                self._receive(self._patience(now))
        self.lost += self.answer_frames * (len(self.counts) - self.sent)
        for pending in list(self.pending.values()):
            self._close(pending)

    def wait_for_last_status(self) -> None:
        """Wait for the status that reports the last snapshot; one is lost if it never comes."""
        if not self.answered:
            return
        patience = time.perf_counter() + self.pace.timeout
        while not self._reported():
            left = patience - time.perf_counter()
            if left <= 0 or self._gone():
                self.statuses.lost += 1
                return
            self._receive(left)

    def result(self) -> Exchange:
        return Exchange(
            angles=self.angles,
            tips=self.tips,
            complete=self.complete,
            statuses=tuple(self.statuses.seen),
            lost_frames=self.lost + self.statuses.lost,
            corrupted=self._refused() - self.refused,
            unexpected=self.unexpected,
            seconds=self.end - self.begin,
            gone=self.gone,
        )

    def _gone(self) -> bool:
        rounds = _FAILED_ROUNDS if self.statuses.seen or self.answered else 0
        return bool(self.gone) or self.failed > rounds * self.pace.in_flight

    def _refused(self) -> int:
        lines = self.bus.malformed_lines if isinstance(self.bus, BlockSlcanBus) else 0
        return self.codec.errors.total() + lines

    def _reported(self) -> bool:
        """Whether some status counts as many snapshots as were answered."""
        if not self.statuses.seen:
            return False
        if self.first_sample is None:
            return True
        behind = self.first_sample + self.answered - self.statuses.seen[-1].sample_counter
        return behind % 2**16 in (0, *range(2**15, 2**16))

    def _may_send(self, now: float) -> bool:
        return self._free() and now >= self._due()

    def _free(self) -> bool:
        return self.sent < len(self.counts) and len(self.pending) < self.pace.in_flight

    def _due(self) -> float:
        return self.begin + (self.sent / self.pace.rate_hz if self.pace.rate_hz else 0.0)

    def _patience(self, now: float) -> float:
        """Seconds until something is to be done even if no frame comes."""
        oldest = next(iter(self.pending.values()), None)
        moments = [] if oldest is None else [oldest.sent + self.pace.timeout]
        if self._free():
            moments.append(self._due())
        return max(0.0, min(moments, default=now) - now)

    def _send(self, now: float) -> None:
        counter = self.sent % self.layout.counter_modulus
        frames = self.codec.encode(self.counts[self.sent], counter)
        self.pending[counter] = PendingAnswer(self.sent, now, [None] * (self.answer_frames - 1))
        self.sent += 1
        try:
            if isinstance(self.bus, BlockSlcanBus):
                self.bus.send_all(frames, timeout=self.pace.timeout)
            else:
                for frame in frames:
                    self.bus.send(frame, timeout=self.pace.timeout)
        except (can.CanError, OSError):
            return  # the frames of the answer will not come: that is where the loss is counted

    def _receive(self, timeout: float) -> None:
        try:
            message = self.bus.recv(timeout)
        except (can.CanError, OSError) as error:
            self.gone = _reason(error)  # nothing more will come
            return
        decoded = self.codec.decode(message) if message is not None else None
        if decoded is None or decoded.kind == "lengths":
            return
        if decoded.kind == "status":
            self.statuses.take(decoded)
            return
        pending = self.pending.get(decoded.counter)
        if pending is None or not pending.store(decoded):
            self.unexpected += 1
        elif pending.received == self.answer_frames:
            self._finish(pending)

    def _finish(self, pending: PendingAnswer) -> None:
        for earlier in [p for p in self.pending.values() if p.index < pending.index]:
            self._close(earlier)
        self.end = time.perf_counter()
        self._close(pending)
        angles = tuple([angle for part in pending.angles for angle in part or ()])
        tip = pending.tip or ()
        self.angles[pending.index] = angles
        self.tips[pending.index] = tip
        self.complete[pending.index] = True
        if self.on_answer is not None:
            status = self.statuses.seen[-1] if self.statuses.seen else None
            lost = self.lost + self.statuses.lost
            self.on_answer(Answer(pending.index, angles, tip, lost, status))

    def _close(self, pending: PendingAnswer) -> None:
        del self.pending[pending.index % self.layout.counter_modulus]
        self.lost += self.answer_frames - pending.received
        self.answered += pending.received > 0
        self.failed = 0 if pending.received == self.answer_frames else self.failed + 1

    def _expire(self, now: float) -> None:
        while self.pending:
            oldest = next(iter(self.pending.values()))
            if now - oldest.sent <= self.pace.timeout:
                return
            self._close(oldest)


def _reason(error: Exception) -> str:
    """Why nothing can be received any more, on one line, with the system's own reason."""
    causes = [error, *filter(None, (error.__cause__, error.__context__))]
    reasons = [str(getattr(cause, "strerror", None) or cause) for cause in causes]
    words = dict.fromkeys(" ".join(reason.split()) for reason in reasons if reason)
    return ": ".join(words) or type(error).__name__
