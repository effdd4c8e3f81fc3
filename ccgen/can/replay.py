"""Counts to send again: those of a log of the bus, or of a recording."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import can
import numpy as np
from numpy.typing import NDArray

from ccgen.can.codec import Codec, health_of
from ccgen.can.gathering import Gathered, Gatherer
from ccgen.can.layout import FrameLayout
from ccgen.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Replay:
    """Snapshots of a file.

    Attributes:
        times: shape (k,), seconds from the first, never running back.
        counts: shape (k, n); the layout's value for "no reading" where a sensor had none.
        first: number of the first on the bus; None where the file knows no numbers.
        notes: what is to be known of the file.
    """

    times: Floats
    counts: Integers
    first: int | None
    notes: tuple[str, ...]

    def until(self, seconds: float | None) -> "Replay":
        """What is sent in so many seconds from the first on; None for all."""
        if seconds is None:
            return self
        part = self.times <= seconds
        return replace(self, times=self.times[part], counts=self.counts[part])


def logged_counts(
    messages: Iterable[can.Message], codec: Codec, fingerprint: int, source: Path
) -> Replay:
    """Gather the complete snapshots of a log.

    Args:
        messages: the log's frames.
        codec: of the joint that is to have them.
        fingerprint: of its model.
        source: the log, for messages.

    Raises:
        InputError: the log holds no complete snapshot of the joint, or as `messages` does.
    """
    layout = codec.layout
    gatherer = Gatherer(layout, layout.lengths_frames, 1e-6 * layout.window_max_us)
    snapshots: list[Gathered] = []
    strangers: set[int] = set()
    before = codec.errors.total()
    for message in messages:
        decoded = codec.decode(message)
        if decoded is None:
            continue
        if decoded.kind == "health":
            strangers.add(health_of(decoded).fingerprint)
        if decoded.kind == "lengths":
            gatherer.tick(message.timestamp)
            begun, _ = gatherer.take(decoded.index, decoded.number, decoded.values)
            snapshots += [] if begun is None else [begun]
    complete = [snapshot for snapshot in snapshots if snapshot.complete]
    damaged = codec.errors.total() - before
    if not complete:
        spoilt = f" ({damaged} frames failed their check)" if damaged else ""
        raise InputError(
            f"{source}: holds no complete snapshot of {layout.name}{spoilt}; "
            "name a log of this joint and the folder that its sensors were compiled from"
        )
    times = np.array([snapshot.t for snapshot in complete])
    return Replay(
        times - times[0],
        np.array([snapshot.values for snapshot in complete], dtype=np.int64),
        complete[0].number,
        tuple(_notes(source, len(snapshots) - len(complete), strangers - {fingerprint & 0xFFFF})),
    )


def _notes(source: Path, incomplete: int, strangers: set[int]) -> Iterable[str]:
    if incomplete:
        yield f"{source}: {incomplete} snapshots came incomplete; they are left out"
    if strangers:
        yield (
            f"{source}: was logged with another model ({min(strangers):#06x}); "
            "its counts are sent to this one"
        )


def recorded_counts(
    times: Floats | None, counts: Floats, layout: FrameLayout, source: Path
) -> Replay:
    """Take the counts of a recording.

    Args:
        times: shape (k,), seconds; None for a row a cycle.
        counts: shape (k, n), NaN where there is no reading.
        layout: of the joint that is to have them.
        source: the recording, for messages.

    Raises:
        InputError: a count that is no integer, or that no frame can hold.
    """
    most = 2 ** (8 * layout.count_bytes - 1) - 1
    there = ~np.isnan(counts)
    wrong = there & ((np.abs(counts) > most) | (counts != np.rint(counts)))
    if wrong.any():
        row, sensor = np.argwhere(wrong)[0]
        raise InputError(
            f"{source}: row {row + 1}, count_{layout.sensors[sensor]}: {counts[row, sensor]:g} is "
            f"no count that a frame can hold; write integers from {-most} to {most}"
        )
    values = np.where(there, counts, -most - 1).astype(np.int64)
    if times is None:
        cycles = np.arange(len(values), dtype=np.float64)
        return Replay(np.asarray(1e-6 * layout.cycle_us * cycles), values, None, ())
    return Replay(times - times[0], values, None, ())
