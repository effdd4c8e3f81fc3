"""What sensors read in a recording: metres, on the reference's clock, without what sticks.

A length is a count times the nominal metres per count, so that a count of 0 is a length of 0.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.clocks import (
    Delay,
    averaged,
    counts_as_none,
    estimated_delay,
    sampled,
    white_noise,
)
from ccgen.recordings.recording import Recording
from ccgen.recordings.sensors import RecordedSensors

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_SHORTEST_STUCK = 5
"""Equal counts in a row below which nothing is said to stick."""
_MOVED = 6.0
"""Standard deviations that a length is expected to change by while its count does not."""
_TURNS = 6


@dataclass(frozen=True, eq=False)
class Read:
    """What the sensors of a recording read."""

    lengths: Floats
    """At the reference's times, shape (N, n), metres; NaN where there is none."""
    delay: Delay
    stuck: NDArray[np.intp]
    """Number of counts left out for each sensor because they stick, shape (n,)."""
    names: tuple[str, ...]
    """Of the sensors."""
    lost: Floats
    """Variance of the readings' noise that `lengths` have lost as means of rows, shape (n,)."""

    def own_noise(self, noise: Floats) -> Floats:
        """Noise of a single reading where that of `lengths` is known, shape (n,), metres."""
        # What differs from row to row may be motion, but noise is no more than all that is left.
        return np.asarray(np.sqrt(np.square(noise) + np.minimum(self.lost, np.square(noise))))

    def notes(self, source: str) -> tuple[str, ...]:
        """What a reader of results should know of the readings, a line each."""
        stuck = [
            f"{source}: sensor {name}: {count} counts that stick are left out"
            for name, count in zip(self.names, self.stuck, strict=True)
            if count
        ]
        if np.isinf(self.delay.std):
            return (*stuck, f"{source}: does not tell by how much the sensors lag; taken as 0")
        return tuple(stuck)


def expected_changes(states: Floats, matrix: Floats) -> Floats:
    """Changes of length H x, shape (N, n), metres; NaN where a state that matters is unknown."""
    known = np.nan_to_num(states) @ matrix.T
    unknown = np.isnan(states).astype(np.float64) @ (matrix != 0).T.astype(np.float64)
    return np.asarray(np.where(unknown > 0, np.nan, known))


def read_lengths(
    recording: Recording,
    sensors: RecordedSensors,
    expected: Floats,
    learned: Flags,
    near: float | None = None,
) -> Read:
    """Lay what sensors read beside a reference.

    Args:
        recording: with counts.
        sensors: those of the joint.
        expected: changes of length by the reference, shape (N, n), metres; NaN where unknown.
        learned: from which rows a delay may be learned, shape (N,).
        near: seconds about which a delay is sought; None for everywhere.
    """
    counts = recording.counts
    assert counts is not None
    lengths = counts.values * sensors.metres_per_count
    delay = _delay(recording, lengths, np.where(learned[:, None], expected, np.nan), near)
    stuck = _stuck(counts.values, lengths, sampled(recording.t, expected, counts.t - delay.seconds))
    lengths = np.where(stuck, np.nan, lengths)
    at = recording.t + delay.seconds if delay.seconds else recording.t
    lost = np.square(white_noise(lengths)) * (1 - averaged(counts.t, at))
    # Where a common clock was cut, readings that lag are those of another time.
    own = recording.t if counts.t is recording.t else None
    return Read(sampled(counts.t, lengths, at, own), delay, stuck.sum(axis=0), sensors.names, lost)


def _delay(recording: Recording, lengths: Floats, expected: Floats, near: float | None) -> Delay:
    stated, counts = recording.file.delay, recording.counts
    assert counts is not None
    if stated is not None:
        return Delay(stated, 0.0)
    if not recording.timed:
        return Delay(0.0, 0.0)
    found = estimated_delay(recording.t, expected, counts.t, lengths, near)
    if found is None:
        return Delay(0.0, np.inf)
    # On a common clock interpolation would only smooth the noise that there is.
    if counts.t is recording.t and counts_as_none(found):
        return Delay(0.0, found.std)
    return found


def _stuck(counts: Floats, lengths: Floats, expected: Floats) -> Flags:
    """Which counts stay the same while the joint moves, shape (K, n)."""
    found = np.zeros(counts.shape, dtype=np.bool_)
    for j in range(counts.shape[1]):
        fitted, scale = _followed(expected[:, j], lengths[:, j])
        for first, last in _runs(counts[:, j]):
            part = fitted[first:last]
            part = part[~np.isnan(part)]
            if len(part) and part.max() - part.min() > _MOVED * scale:
                found[first:last, j] = True
    return found


def _followed(expected: Floats, lengths: Floats) -> tuple[Floats, float]:
    """What a sensor should read, by a gain and a zero of its own, and how far off it usually is."""
    there = ~np.isnan(expected) & ~np.isnan(lengths)
    if there.sum() < 2 * _SHORTEST_STUCK:
        return np.full_like(expected, np.nan), np.inf
    kept = there
    fitted, scale = expected, np.inf
    for _ in range(_TURNS):
        base = np.stack([expected[kept], np.ones(int(kept.sum()))], axis=1)
        (gain, zero), *_ = np.linalg.lstsq(base, lengths[kept], rcond=None)
        fitted = gain * expected + zero
        off = np.abs(np.where(there, lengths - fitted, 0.0))
        scale = 1.4826 * float(np.median(off[there]))
        kept = there & (off <= 3 * max(scale, 1e-9))
    return fitted, scale


def _runs(counts: Floats) -> list[tuple[int, int]]:
    """First row and the row after the last of each long run of equal counts."""
    ends = np.flatnonzero(np.concatenate([[True], counts[1:] != counts[:-1], [True]]))
    return [
        (int(a), int(b))
        for a, b in pairwise(ends)
        if b - a >= _SHORTEST_STUCK and not np.isnan(counts[a])
    ]
