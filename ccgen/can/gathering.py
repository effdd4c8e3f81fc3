"""How frames of one number become a snapshot: the Python mirror of `ccgen/snapshot.h`.

It says of every snapshot what the node's own code would: which of its frames came again, too late,
in the wrong order or not at all. Unlike the node it keeps what came too late, for those who know
better whether it was, and says where a number came again with other content.
"""

from dataclasses import dataclass, field
from typing import Literal

from ccgen.can.layout import FrameLayout

Fault = Literal[
    "repeated", "some_lost", "bad_crc", "bad_format", "reordered", "late", "stale", "missing",
    "suspected", "never_seen",
]  # fmt: skip

STALE_CYCLES = 3
"""Cycles without a complete snapshot after which the last one is stale."""

_HALF_US = 0.5e-6
"""What rounding may take from a time, which the node knows in whole microseconds."""

_Phase = Literal["none", "pending", "complete", "dropped"]


@dataclass(eq=False)
class Gathered:
    """Frames that have one number.

    Attributes:
        number: of the snapshot.
        t: when its first frame came, seconds.
        parts: payload of each frame, None until it comes.
        first: which of them came first.
        skipped: snapshots that were lost whole before it.
        faults: what was wrong on the way.
    """

    number: int
    t: float
    parts: list[tuple[int, ...] | None]
    first: int
    skipped: int = 0
    faults: set[Fault] = field(default_factory=set)

    @property
    def complete(self) -> bool:
        """Whether every frame has come."""
        return None not in self.parts

    @property
    def values(self) -> tuple[int, ...]:
        """The values of all frames that came, in the order of the layout."""
        return tuple([value for part in self.parts for value in part or ()])


class Gatherer:
    """Puts frames of the same number together, as they come."""

    def __init__(self, layout: FrameLayout, frames: int, window: float) -> None:
        """Begin with nothing.

        Args:
            layout: of the joint.
            frames: of one number.
            window: seconds within which they must come.
        """
        self._frames, self._numbers = frames, layout.numbers
        self._window = window + _HALF_US
        self._patience = STALE_CYCLES * 1e-6 * layout.cycle_us + _HALF_US
        self._phase: _Phase = "none"
        self._newest = Gathered(0, 0.0, [None] * frames, 0)
        self._taken: set[int] = set()
        self._next: set[Fault] = set()
        self._now = self._heard = float("-inf")
        self._completed = float("inf")

    @property
    def newest(self) -> Gathered:
        """What was begun last."""
        return self._newest

    def tick(self, now: float) -> bool:
        """Let time go on; returns whether the latest complete snapshot is stale."""
        self._now = max(self._now, now)
        if self._phase != "none" and self._now - self._heard > max(self._patience, self._window):
            if self._phase == "pending":
                self._newest.faults.add("some_lost")
            self._phase = "none"
        stale = self._now - self._completed > self._patience
        if stale:
            self.flag("stale")
        return stale

    def confirm(self) -> None:
        """Take it that what came too late was in time for the node, and complete."""
        self._completed = self._now

    def flag(self, fault: Fault) -> None:
        """Tell of something wrong: with the snapshot in progress, or else with the next one."""
        (self._newest.faults if self._phase == "pending" else self._next).add(fault)

    def take(
        self, slot: int, number: int, values: tuple[int, ...]
    ) -> tuple[Gathered | None, Fault | None]:
        """Take a frame that came at the time of the last tick.

        Args:
            slot: which of the frames of its number it is.
            number: of its snapshot.
            values: its payload.

        Returns:
            The snapshot that it begins, if it does; and what is wrong with the frame itself.
        """
        ahead = (number - self._newest.number) % self._numbers
        if self._phase != "none" and ahead >= (self._numbers + 1) // 2:
            self.flag("reordered")
            return None, "reordered"
        begun = self._begun(slot, number, ahead, values)
        self._heard = self._now
        return begun, self._place(slot, values)

    def _begun(
        self, slot: int, number: int, ahead: int, values: tuple[int, ...]
    ) -> Gathered | None:
        """Begin a snapshot where the frame belongs to none in progress."""
        skipped = 0
        if self._phase != "none":
            same = slot not in self._taken or self._newest.parts[slot] == values
            if ahead == 0 and same:
                return None
            if self._phase == "pending":
                self._newest.faults.add("some_lost")
            skipped = max(0, ahead - 1)
            if skipped:
                self._next.add("some_lost")
            if ahead == 0:
                self._next.add("repeated")
        self._phase = "pending"
        parts: list[tuple[int, ...] | None] = [None] * self._frames
        self._newest = Gathered(number, self._now, parts, slot, skipped, self._next)
        self._next = set()
        self._taken.clear()
        return self._newest

    def _place(self, slot: int, values: tuple[int, ...]) -> Fault | None:
        newest = self._newest
        if self._phase == "complete":
            newest.faults.add("repeated")
            return "repeated"
        if self._phase == "dropped" or self._now - newest.t > self._window:
            newest.faults.add("late")
            newest.parts[slot] = newest.parts[slot] or values
            self._phase = "dropped"
            return "late"
        if slot in self._taken:
            newest.faults.add("repeated")
            return "repeated"
        newest.parts[slot] = values
        self._taken.add(slot)
        if newest.complete:
            self._phase = "complete"
            self._completed = self._now
        return None
