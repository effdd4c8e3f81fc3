"""Snapshots to a node and its answers back, with every frame that fails to come counted.

The node answers a snapshot with its ANGLES frames and TIP, under the snapshot's number. A frame
is lost when it has not come by the time a later snapshot is answered in full, or when the time-out
passes. STATUS frames come with every answer and, once a cycle, without one; they count themselves,
so one is lost where their counter jumps, or where none ever reports the last snapshot; HEALTH
frames count themselves too. What the joint does not publish is not waited for.

Each exchange is a sender that starts anew: it keeps silent for a window of the layout before its
first frame. Where the node may have a wider one, `Pace.first` must be a number that the bus has
not just seen; `fresh_number` gives one.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_

import can
import numpy as np
from numpy.typing import NDArray

from ccgen.can.answers import CountedStream, PendingAnswer
from ccgen.can.codec import Codec, Health, Status, health_of, status_of
from ccgen.can.layout import ZERO_OF_THE_MODEL, ZERO_STATES, FrameLayout
from ccgen.can.logs import Log, stamped
from ccgen.can.transports import gone_because
from ccgen.can.transports.slcan import BlockSlcanBus
from ccgen.errors import InputError

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
        times: when each snapshot is sent, seconds from the first, shape (k,); instead of a rate.
        in_flight: snapshots that wait for their answer at the same time, fewer than there are
            numbers.
        timeout: seconds until an answer's missing frames are lost.
        first: number of the first snapshot.
        silence: seconds without a frame before the first; None for the layout's window.
    """

    rate_hz: float | None = None
    in_flight: int = 4
    timeout: float = 5.0
    first: int = 0
    silence: float | None = None
    times: Sequence[float] | None = None


@dataclass(frozen=True)
class Answer:
    """One snapshot's answer as it comes.

    Attributes:
        index: of the snapshot.
        angles: raw values of all axes, u segments first; none where they are not published.
        tip: 3 raw coordinates; none where it is not published.
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
        angles: shape (k, values), raw values of all axes, u segments first; 0 where `complete`
            does not hold.
        tips: shape (k, 3), raw tip coordinates.
        complete: shape (k,), whether all ANGLES frames and TIP came.
        statuses: every STATUS frame in order.
        healths: every HEALTH frame in order.
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
    healths: tuple[Health, ...]
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

    @property
    def other_zero(self) -> str:
        """Whose zero the node said it works with, once it was not the model's; else empty."""
        others = {health.zero for health in self.healths} - {ZERO_OF_THE_MODEL}
        return ZERO_STATES[min(others)] if others else ""

    def stranger(self, fingerprint: int) -> str:
        """What tells that the node is not of the model with this fingerprint; else empty."""
        others = {health.fingerprint for health in self.healths} - {fingerprint}
        if not others:
            return ""
        return f"the node is of another model ({min(others):#06x}, not {fingerprint:#06x})"


def fresh_start(layout: FrameLayout, pace: Pace) -> Pace:
    """The pace with a first number and a silence that no node takes for those of a former sender.

    Numbers follow the machine's clock, one a cycle, so that a sender which sends no faster than
    that and starts again goes on with a number that its former self has not reached. A faster one
    has to keep silent for the widest window that a node may have.
    """
    cycle = 1e-3 * layout.cycle_ms
    followed = pace.rate_hz is not None and pace.rate_hz * cycle <= 1.0
    silence = cycle if followed else cycle * layout.window_cycles
    number = int((time.monotonic() + silence) / cycle) % layout.numbers
    return replace(pace, first=number, silence=silence)


def exchange(
    bus: can.BusABC,
    codec: Codec,
    counts: Integers,
    pace: Pace | None = None,
    on_answer: OnAnswer | None = None,
    log: Log | None = None,
) -> Exchange:
    """Send every snapshot and collect the answers; returns in bounded time, whatever comes.

    Args:
        bus: the host's end.
        codec: of the joint.
        counts: shape (k, n).
        pace: rate, bound on snapshots in flight, time-out.
        on_answer: called with each answer when it is complete.
        log: takes down every frame, sent and received, with the machine's time.

    Raises:
        InputError: the joint publishes neither angles nor tip.
        ValueError: as many snapshots in flight as the counter can tell apart, or none; a count
            that does not fit the frame.
    """
    if not codec.layout.numbered_frames:
        raise InputError(
            'can.publish: without "angles" or "tip" a node answers no snapshot; publish one of them'
        )
    run = _Run(bus, codec, counts, pace or Pace(), on_answer, log)
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
        log: Log | None,
    ) -> None:
        layout = codec.layout
        if not 1 <= pace.in_flight < layout.numbers:
            raise ValueError(f"{pace.in_flight} in flight; 1 to {layout.numbers - 1} work")
        self.bus, self.codec, self.layout = bus, codec, layout
        self.pace, self.on_answer, self.log = pace, on_answer, log
        self.counts: list[list[int]] = counts.tolist()
        self.angles = np.zeros((len(self.counts), layout.values), dtype=np.int64)
        self.tips = np.zeros((len(self.counts), 3), dtype=np.int64)
        self.complete = np.zeros(len(self.counts), dtype=np.bool_)
        self.answer_frames = layout.numbered_frames
        self.pending: dict[int, PendingAnswer] = {}
        self.statuses = CountedStream(layout.counter_modulus, status_of)
        self.healths = CountedStream(layout.counter_modulus, health_of)
        self.sent = self.answered = self.failed = self.lost = self.unexpected = 0
        self.refused = self._refused()
        self.begin = self.end = 0.0
        self.first_sample: int | None = None
        self.gone = ""

    def listen_for_status(self) -> None:
        """Learn in silence how many snapshots an idle node has seen; it may never tell."""
        cycles = 1e-3 * self.layout.cycle_ms * _LISTEN_CYCLES
        silence = self.pace.silence
        now = time.perf_counter()
        quiet = now + (1e-6 * self.layout.window_us if silence is None else silence)
        patience = max(quiet, now + self.pace.timeout + cycles)
        if not self.layout.publishes("status"):
            patience = quiet
        while now < (patience if self.first_sample is None else quiet) and not self._gone():
            self._receive(cycles if self.first_sample is None else quiet - now)
            if self.statuses.seen:
                self.first_sample = self.statuses.seen[-1].sample_counter
            now = time.perf_counter()

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
        if not self.answered or not self.layout.publishes("status"):
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
            healths=tuple(self.healths.seen),
            lost_frames=self._lost(),
            corrupted=self._refused() - self.refused,
            unexpected=self.unexpected,
            seconds=self.end - self.begin,
            gone=self.gone,
        )

    def _gone(self) -> bool:
        heard = self.statuses.seen or self.healths.seen or self.answered
        rounds = _FAILED_ROUNDS if heard else 0
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

    def _number(self, index: int) -> int:
        """Number of a snapshot on the bus."""
        return (self.pace.first + index) % self.layout.numbers

    def _may_send(self, now: float) -> bool:
        return self._free() and now >= self._due()

    def _free(self) -> bool:
        return self.sent < len(self.counts) and len(self.pending) < self.pace.in_flight

    def _due(self) -> float:
        if self.pace.times is not None:
            return self.begin + self.pace.times[self.sent]
        return self.begin + (self.sent / self.pace.rate_hz if self.pace.rate_hz else 0.0)

    def _patience(self, now: float) -> float:
        """Seconds until something is to be done even if no frame comes."""
        oldest = next(iter(self.pending.values()), None)
        moments = [] if oldest is None else [oldest.sent + self.pace.timeout]
        if self._free():
            moments.append(self._due())
        return max(0.0, min(moments, default=now) - now)

    def _send(self, now: float) -> None:
        number = self._number(self.sent)
        frames = self.codec.encode(self.counts[self.sent], number)
        angles = self.answer_frames - self.layout.publishes("tip")
        self.pending[number] = PendingAnswer(self.sent, now, [None] * angles)
        self.sent += 1
        try:
            if isinstance(self.bus, BlockSlcanBus):
                self.bus.send_all(frames, timeout=self.pace.timeout)
            else:
                for frame in frames:
                    self.bus.send(frame, timeout=self.pace.timeout)
        except (can.CanError, OSError):
            return  # the frames of the answer will not come: that is where the loss is counted
        if self.log is not None:
            for frame in frames:
                frame.is_rx = False
                self.log(stamped(frame))

    def _receive(self, timeout: float) -> None:
        try:
            message = self.bus.recv(timeout)
        except (can.CanError, OSError) as error:
            self.gone = gone_because(error)  # nothing more will come
            return
        if message is not None and self.log is not None:
            self.log(stamped(message))
        decoded = self.codec.decode(message) if message is not None else None
        if decoded is None or decoded.kind in ("lengths", "command"):
            return
        if decoded.kind == "status":
            self.statuses.take(decoded)
            return
        if decoded.kind == "health":
            self.healths.take(decoded)
            return
        pending = self.pending.get(decoded.number)
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
        if self.layout.publishes("angles"):
            self.angles[pending.index] = angles
        if self.layout.publishes("tip"):
            self.tips[pending.index] = tip
        self.complete[pending.index] = True
        if self.on_answer is not None:
            status = self.statuses.seen[-1] if self.statuses.seen else None
            self.on_answer(Answer(pending.index, angles, tip, self._lost(), status))

    def _lost(self) -> int:
        return self.lost + self.statuses.lost + self.healths.lost

    def _close(self, pending: PendingAnswer) -> None:
        del self.pending[self._number(pending.index)]
        self.lost += self.answer_frames - pending.received
        self.answered += pending.received > 0
        self.failed = 0 if pending.received == self.answer_frames else self.failed + 1

    def _expire(self, now: float) -> None:
        while self.pending:
            oldest = next(iter(self.pending.values()))
            if now - oldest.sent <= self.pace.timeout:
                return
            self._close(oldest)
