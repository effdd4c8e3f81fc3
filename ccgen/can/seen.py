"""What a monitor tells: snapshots, and the states of frames."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ccgen.can.gathering import Fault
from ccgen.can.layout import FrameLayout
from ccgen.fixedpoint import FixedPointModel

State = Literal["good"] | Fault
"""What a frame, or a snapshot, is to its receiver."""

_NO_TIP = -(2**15)


@dataclass(frozen=True)
class Seen:
    """One snapshot.

    Attributes:
        t: when its first frame came, seconds of the bus's clock.
        number: of the snapshot.
        counts: in the joint's order of sensors, None where nothing came; empty where LENGTHS are
            not on the bus.
        values: raw values of all axes, None where nothing came.
        tip: raw coordinates; None where it did not come.
        missing, suspected: names of sensors.
        faults: in the order of `Fault`; ("good",) where there is none.
        frames: what was wrong with single frames since the snapshot told before, by name.
    """

    t: float
    number: int
    counts: tuple[int | None, ...]
    values: tuple[int | None, ...]
    tip: tuple[int, ...] | None
    missing: tuple[str, ...]
    suspected: tuple[str, ...]
    faults: tuple[State, ...]
    frames: dict[str, tuple[Fault, ...]]


@dataclass
class FrameStates:
    """What one frame of the joint was to its receiver so far."""

    name: str
    counts: "Counter[State]" = field(default_factory=Counter)
    state: State = "never_seen"
    t: float = float("-inf")

    def see(self, state: State, t: float) -> None:
        """Take what the frame was this time."""
        self.counts[state] += 1
        self.state, self.t = state, t

    def miss(self, times: int) -> None:
        """Take that it did not come."""
        self.counts["some_lost"] += times
        self.state = "some_lost"


def plain(seen: Seen, model: FixedPointModel, layout: FrameLayout) -> dict[str, Any]:
    """A snapshot in degrees, metres and shares of the length, for JSON; None for no reading."""
    parts: dict[str, list[float | None]] = {}
    start, lowest = 0, -(2 ** (model.precision - 1))
    for name, axis in model.axes.items():
        raw = seen.values[start : start + axis.segments]
        start += axis.segments
        scale = 2.0**-axis.fraction_bits * (1.0 if name == "h" else 180.0 / np.pi)
        parts[name] = [
            None if value is None or value == lowest else round(scale * value, 9) for value in raw
        ]
    step = 2.0**-layout.tip_fraction_bits
    tip = [None if x == _NO_TIP else step * x for x in seen.tip or (_NO_TIP,) * 3]
    absent = -(1 << (8 * layout.count_bytes - 1))
    record: dict[str, Any] = {
        "t": seen.t,
        "counter": seen.number,
        "counts": [None if count == absent else count for count in seen.counts] or None,
        "angles_deg": {axis: parts[axis] for axis in parts if axis != "h"},
        "elongation": parts.get("h"),
        "tip_m": tip,
        "missing": list(seen.missing),
        "suspected": list(seen.suspected),
        "faults": list(seen.faults),
    }
    if seen.frames:
        record["messages"] = {name: list(own) for name, own in seen.frames.items()}
    return record
