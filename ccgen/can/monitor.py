"""What passes on a joint's bus, snapshot by snapshot, for somebody who only listens.

A snapshot is the LENGTHS frames of one number and the node's answer to it, ANGLES and TIP. Where
LENGTHS are not on the bus, the answers alone are the snapshots. A snapshot is told once its answer
and a status have come, once a later one is answered, or once no frame of it can come any more: the
contract of `ccgen/snapshot.h`. Whether a snapshot is too late, the node knows better: it may have a
wider window, and answers.
"""

from collections import Counter, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args

import can
import numpy as np

from ccgen.can.codec import Codec, Decoded, Health, Refused, Status, health_of, status_of
from ccgen.can.gathering import Fault, Gathered, Gatherer
from ccgen.can.layout import FAULTS, ZERO_OF_THE_MODEL
from ccgen.can.reference import Comparison
from ccgen.can.seen import FrameStates, Seen, State
from ccgen.errors import InputError
from ccgen.fixedpoint.guarded import GuardedModel

_ORDER = get_args(Fault)


@dataclass(eq=False)
class _Record:
    """A snapshot on its way: whatever has come of it."""

    serial: int
    t: float
    number: int
    lengths: Gathered | None = None
    answer: Gathered | None = None
    status: Status | None = None

    @property
    def answered(self) -> bool:
        return self.answer is not None and self.answer.complete


class Monitor:
    """Takes frames and gives the snapshots that they make.

    Attributes:
        frames: what every frame of the layout was so far, by identifier.
        told: snapshots told so far.
        faults: how many of them had each fault.
        latest: the snapshot told last.
        health: the latest; None before the first.
        node_faults: names of what the node's statuses told.
    """

    def __init__(
        self,
        guarded: GuardedModel,
        codec: Codec,
        fingerprint: int,
        window: float | None = None,
    ) -> None:
        """Begin with nothing seen.

        Args:
            guarded, codec: of the joint.
            fingerprint: of its model.
            window: seconds within which a snapshot's frames must come; one cycle by default.
        """
        layout = codec.layout
        self._guarded, self._codec, self._fingerprint = guarded, codec, fingerprint & 0xFFFF
        self._layout = layout
        self._window = 1e-6 * layout.window_us if window is None else window
        self._lengths = Gatherer(layout, layout.lengths_frames, self._window)
        self._answers = Gatherer(layout, max(1, layout.numbered_frames), self._window)
        self._patience = 1e-6 * layout.cycle_us * layout.latest_cycles
        self._angles = layout.angles_frames if layout.publishes("angles") else 0
        self._ids = {
            kind: [frame.id for frame in layout.frames_of(kind)]
            for kind in ("lengths", "angles", "tip", "status", "health", "command")
        }
        self.frames = {frame.id: FrameStates(frame.name) for frame in layout.used_frames}
        self._records: deque[_Record] = deque()
        self._aside: set[Fault] = set()
        self._spoilt: dict[str, set[Fault]] = {}
        self._serial = self._begun = self._answered = 0
        self._counters: dict[str, int] = {}
        self._comparison = Comparison(guarded)
        self._first = self._last = 0.0
        self.now = float("-inf")
        self.told = 0
        self.faults: Counter[State] = Counter()
        self.latest: Seen | None = None
        self.health: Health | None = None
        self.node_faults: set[str] = set()

    @property
    def compared(self) -> int:
        """Snapshots that were held against the reference model."""
        return self._comparison.compared

    @property
    def mismatches(self) -> int:
        """Values of those that differ from it."""
        return self._comparison.mismatches

    @property
    def heard(self) -> int:
        """Frames of the joint so far, good or not."""
        return sum(
            count
            for frame in self.frames.values()
            for state, count in frame.counts.items()
            if state != "some_lost"
        )

    @property
    def zero_is_the_models(self) -> bool:
        """Whether the node works with the zeros of the model, as far as it has told."""
        return self.health is None or self.health.zero == ZERO_OF_THE_MODEL

    @property
    def rate_hz(self) -> float:
        """Snapshots a second since the first."""
        span = self._last - self._first
        return (self.told - 1) / span if span > 0 else 0.0

    def take(self, message: can.Message) -> Iterable[Seen]:
        """Take a frame with its time; give the snapshots that it completes.

        Raises:
            InputError: the node is of another model.
        """
        found = self._codec.examine(message)
        if found is None:
            return ()
        self.now = max(self.now, message.timestamp)
        self._lengths.tick(self.now)
        self._answers.tick(self.now)
        fault = self._refuse(found) if isinstance(found, Refused) else self._follow(found)
        frame = self.frames[message.arbitration_id]
        frame.see(fault or "good", self.now)
        if fault is not None:
            self._spoilt.setdefault(frame.name, set()).add(fault)
        return self._ready()

    def finish(self) -> Iterator[Seen]:
        """Give the snapshots that are left, but for those that the end cut short."""
        while self._records:
            record = self._records.popleft()
            whole = record.answered or self.now - record.t > self._window
            if whole or (self._answered == 0 and _complete(record.lengths)):
                yield self._tell(record)
        if not self._layout.commands and self.zero_is_the_models:
            self._comparison.hold()

    def states(self) -> dict[str, State]:
        """What each frame is now: stale where it has not come for too long."""
        limit = 3e-6 * self._layout.cycle_us
        periodic = {*self._ids["lengths"], *self._ids["angles"], *self._ids["tip"]}
        return {
            frame.name: "stale"
            if key in periodic and frame.counts and self.now - frame.t > limit
            else frame.state
            for key, frame in self.frames.items()
        }

    def summary(self) -> dict[str, Any]:
        """Plain values of all that was seen, for JSON."""
        return {
            "snapshots": self.told,
            "rate_hz": self.rate_hz,
            "frames": self.heard,
            "faults": {name: self.faults[name] for name in ("good", *_ORDER) if self.faults[name]},
            "node_faults": [name for name in FAULTS if name in self.node_faults],
            "compared": self.compared,
            "mismatches": self.mismatches,
            "messages": {
                frame.name: dict(sorted(frame.counts.items())) or {"never_seen": 0}
                for frame in self.frames.values()
            },
        }

    def _refuse(self, refused: Refused) -> Fault:
        fault: Fault = "bad_crc" if refused.reason == "crc" else "bad_format"
        if refused.kind == "lengths":
            self._lengths.flag(fault)
        elif refused.kind in ("angles", "tip"):
            self._answers.flag(fault)
        else:
            self._aside.add(fault)
        return fault

    def _follow(self, decoded: Decoded) -> Fault | None:
        if decoded.kind == "lengths":
            begun, fault = self._lengths.take(decoded.index, decoded.number, decoded.values)
            if begun is not None and not self._joined_within(begun):
                self._add(begun).lengths = begun
            return fault
        if decoded.kind in ("angles", "tip"):
            slot = decoded.index if decoded.kind == "angles" else self._angles
            begun, fault = self._answers.take(slot, decoded.number, decoded.values)
            if begun is not None:
                self._pair(begun)
            elif self._answers.newest.complete:
                self._note_answered()
            if begun is not None and begun.complete:
                self._note_answered()
            return fault
        if decoded.kind == "command":
            return None
        if decoded.kind == "status":
            self._take_status(status_of(decoded))
        else:
            self._take_health(health_of(decoded))
        return self._counted(decoded)

    def _counted(self, decoded: Decoded) -> Fault | None:
        """Hold the counter of a frame that counts itself against the one before."""
        before = self._counters.get(decoded.kind)
        self._counters[decoded.kind] = decoded.number
        if before is None:
            return None
        ahead = (decoded.number - before) % self._layout.counter_modulus
        if ahead == 1:
            return None
        fault: Fault = "some_lost" if ahead else "repeated"
        self._aside.add(fault)
        return fault

    def _joined_within(self, begun: Gathered) -> bool:
        """Whether the watch began in the middle of a snapshot, which nobody can miss."""
        return self._serial == 0 and begun.first > 0

    def _add(self, begun: Gathered) -> _Record:
        self._serial += 1
        record = _Record(self._serial, begun.t, begun.number)
        self._records.append(record)
        return record

    def _pair(self, answer: Gathered) -> None:
        """Put an answer to its snapshot."""
        for record in self._records:
            if record.number == answer.number and record.answer is None:
                break
        else:
            if self._joined_within(answer):
                return
            record = self._add(answer)
        record.answer = answer
        self._begun = max(self._begun, record.serial)

    def _note_answered(self) -> None:
        for record in self._records:
            if record.answer is self._answers.newest:
                self._answered = max(self._answered, record.serial)
                if "late" in (record.lengths.faults if record.lengths else ()):
                    self._lengths.confirm()

    def _take_status(self, status: Status) -> None:
        self.node_faults |= {name for bit, name in enumerate(FAULTS) if status.faults >> bit & 1}
        for record in self._records:
            if record.serial == self._answered and record.status is None:
                record.status = status

    def _take_health(self, health: Health) -> None:
        if health.fingerprint != self._fingerprint:
            raise InputError(
                f"the node is of another model ({health.fingerprint:#06x}, not "
                f"{self._fingerprint:#06x}); name the folder that it was compiled from, or program "
                "it again"
            )
        self.health = health
        if health.zero == ZERO_OF_THE_MODEL:
            self._comparison.hold()
        else:
            self._comparison.forget()

    def _ready(self) -> Iterator[Seen]:
        while self._records and self._is_ready(self._records[0]):
            yield self._tell(self._records.popleft())

    def _is_ready(self, record: _Record) -> bool:
        if record.serial < self._answered or self.now - record.t > self._patience:
            return True
        if not self._layout.numbered_frames:
            return _complete(record.lengths) or record.serial < self._serial
        if record.serial != self._answered:
            return False
        waits = self._layout.publishes("status") and record.status is None
        return not waits or self._begun > record.serial

    def _tell(self, record: _Record) -> Seen:
        lengths, answer = record.lengths, record.answer
        faults = self._faults(record)
        missing = self._missing(record)
        suspected = self._layout.sensors_in(self.health.suspected_sensors if self.health else 0)
        faults |= {"missing"} if missing else set()
        faults |= {"suspected"} if suspected else set()
        self._count_losses(record)
        counts: tuple[int | None, ...] = ()
        if lengths is not None:
            counts = self._laid_out(lengths, "lengths")
        values = self._laid_out(answer, "angles")
        tip = answer.parts[-1] if answer and self._layout.publishes("tip") else None
        if _complete(lengths) and record.answered and self._angles and lengths and answer:
            whole = [value for part in answer.parts[: self._angles] for value in part or ()]
            self._comparison.take(lengths.values, tuple(whole))
        seen = Seen(
            t=record.t,
            number=record.number,
            counts=counts,
            values=values,
            tip=tip,
            missing=missing,
            suspected=suspected,
            faults=tuple(name for name in _ORDER if name in faults) or ("good",),
            frames={name: tuple(sorted(own)) for name, own in self._spoilt.items()},
        )
        self._spoilt.clear()
        self._first = self._first if self.told else record.t
        self._last = max(self._last, record.t)
        self.told += 1
        self.faults.update(seen.faults)
        self.latest = seen
        return seen

    def _faults(self, record: _Record) -> set[Fault]:
        faults, self._aside = self._aside, set()
        lengths, answer = record.lengths, record.answer
        if lengths is None:
            return faults | (answer.faults if answer else set())
        faults = faults | lengths.faults
        if record.answered and lengths.complete:
            faults.discard("late")
        if answer is not None:
            faults |= answer.faults - {"some_lost", "stale"}
        if not record.answered and self._layout.numbered_frames:
            if not self._answered:
                faults.add("never_seen")
            elif lengths.complete and "late" not in faults:
                faults.add("some_lost")
        return faults

    def _missing(self, record: _Record) -> tuple[str, ...]:
        bits = record.status.missing_sensors if record.status is not None else 0
        names = set(self._layout.sensors_in(bits))
        if _complete(record.lengths) and record.lengths and self.zero_is_the_models:
            gone = self._guarded.missing([record.lengths.values])[0]
            names |= {self._layout.sensors[j] for j in np.flatnonzero(gone)}
        return tuple(name for name in self._layout.sensors if name in names)

    def _laid_out(
        self, gathered: Gathered | None, kind: Literal["lengths", "angles"]
    ) -> tuple[int | None, ...]:
        """Values of all frames of a kind, None for those of frames that did not come."""
        laid: list[int | None] = []
        for k, frame in enumerate(self._layout.frames_of(kind)):
            publishes = kind == "lengths" or self._angles
            part = gathered.parts[k] if gathered is not None and publishes else None
            laid += [None] * len(frame.payload) if part is None else part
        return tuple(laid)

    def _count_losses(self, record: _Record) -> None:
        """Count the frames that a snapshot lacks, each under its name."""
        if record.lengths is not None:
            for k, key in enumerate(self._ids["lengths"]):
                lost = record.lengths.skipped + (record.lengths.parts[k] is None)
                if lost:
                    self.frames[key].miss(lost)
        if record.answer is None and not (self._answered and _complete(record.lengths)):
            return
        parts = record.answer.parts if record.answer else [None] * self._layout.numbered_frames
        keys = [*self._ids["angles"][: self._angles], *self._ids["tip"]]
        for key, part in zip(keys, parts, strict=False):
            if part is None:
                self.frames[key].miss(1)


def _complete(gathered: Gathered | None) -> bool:
    return gathered is not None and gathered.complete
