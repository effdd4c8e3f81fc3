"""Two clocks laid on each other: by how much sensors lag, and readings at a reference's times.

A delay d says that what the sensors read at time t is the shape of time t - d. It is found where
readings follow best what the reference lets expect, by least squares of each sensor with a gain and
a zero of its own: first on a grid, then by Gauss-Newton with the slope of what is expected, so that
a fraction of a sample shows.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LARGEST_DELAY = 2.0
"""Seconds that are searched to either side."""

_GRID_ROWS = 3000
_MOST_STEPS = 400
_NEAR = 10
"""Steps of the grid to either side of a delay that is nearly known."""
_TURNS = 8
_FEWEST = 20
"""Readings of a sensor without which it says nothing of the delay."""
_OUTLIER = 3.0
"""Residuals beyond so many standard deviations are left out."""
_WIDEST_GAP = 5.0
"""Median steps between readings across which there is no interpolation."""
_JUMP = 20.0
"""Times the usual change of slope from row to row, beyond which it jumps: nothing lies between the
rows, as where a recording was cut."""
_LEAST_JUMP = 0.02
"""Share of the range of values that such a change is at least."""
_CERTAIN = 2.0
"""Standard deviations that a delay differs from 0 by, to count on a common clock."""


@dataclass(frozen=True)
class Delay:
    """By how much sensors lag."""

    seconds: float
    std: float
    """0 where it is stated."""


def sampled(t: Floats, values: Floats, at: Floats, stands_for: Floats | None = None) -> Floats:
    """Values at other times, linear between rows, shape (len(at), n).

    Args:
        t: of the rows, shape (N,), seconds, never running back.
        values: shape (N, n); NaN where there is none.
        at: times, shape (K,).
        stands_for: times on the same clock that the values are to be taken for, shape (K,).

    Returns:
        NaN outside the rows, next to a missing value, across gaps and jumps, and where
        a jump lies between a time and the one that it stands for.
    """
    if at is t or np.array_equal(at, t):
        return values
    return _Track(t, values).sampled(at, at if stands_for is None else stands_for)


@dataclass(frozen=True, eq=False)
class _Track:
    """Values on their clock, arguments as of `sampled`; gaps and jumps are sought once."""

    t: Floats
    values: Floats

    def sampled(self, at: Floats, stands_for: Floats) -> Floats:
        """Values at other times, as `sampled` tells."""
        t, values = self.t, self.values
        left, share = _between(t, at)
        step = np.diff(t)[left]
        inside = (at >= t[0]) & (at <= t[-1])
        inside &= (step <= self._widest) | (share == 0) | (share == 1)
        low, high = values[left], values[left + 1]
        mixed = (1 - share)[:, None] * low + share[:, None] * high
        mixed = np.where((share == 0)[:, None], low, np.where((share == 1)[:, None], high, mixed))
        known = inside[:, None] & ~self._cut(at, stands_for)
        return np.asarray(np.where(known, mixed, np.nan))

    @cached_property
    def _widest(self) -> float:
        """Seconds between rows across which there is no interpolation."""
        return _WIDEST_GAP * _usual_step(self.t)

    @cached_property
    def _jumps(self) -> list[NDArray[np.intp]]:
        """The row before each jump, by column."""
        jump = _jumps(self.values)
        return [np.flatnonzero(own[:-1] & own[1:]) for own in jump.T]

    def _cut(self, one: Floats, other: Floats) -> NDArray[np.bool_]:
        """Whether a jump lies in between of two times, shape (K, n)."""
        low, high = np.minimum(one, other), np.maximum(one, other)
        found = np.zeros((len(one), self.values.shape[1]), dtype=np.bool_)
        for j, at in enumerate(self._jumps):
            begun = np.searchsorted(self.t[at], high, "left")
            found[:, j] = begun > np.searchsorted(self.t[at + 1], low, "right")
        return found


def averaged(t: Floats, at: Floats) -> float:
    """Share of the variance of white noise that values at other times keep, 1/2 to 1.

    Arguments as of `sampled`: a value between two rows is a mean of both.
    """
    if at is t or np.array_equal(at, t):
        return 1.0
    _, share = _between(t, at)
    share = share[(at >= t[0]) & (at <= t[-1])]
    return float(np.mean(np.square(share) + np.square(1 - share))) if len(share) else 1.0


def white_noise(values: Floats) -> Floats:
    """Noise by how values of rows that follow each other differ, shape (n,); 0 where none do."""
    changes = np.diff(values, n=2, axis=0)
    found = np.zeros(values.shape[1])
    for j, column in enumerate(changes.T):
        known = column[~np.isnan(column)]
        if len(known):
            found[j] = 1.4826 * float(np.median(np.abs(known))) / np.sqrt(6.0)
    return found


def _between(t: Floats, at: Floats) -> tuple[NDArray[np.intp], Floats]:
    """The row before each time, and the share of the step from there that has passed."""
    left = np.clip(np.searchsorted(t, at), 1, len(t) - 1) - 1
    step = np.diff(t)[left]
    share = np.where(step > 0, (at - t[left]) / np.where(step > 0, step, 1.0), 1.0)
    return left, np.asarray(share)


def _jumps(values: Floats) -> NDArray[np.bool_]:
    """Where the slope changes far more than it does elsewhere, shape of `values`."""
    found = np.zeros(values.shape, dtype=np.bool_)
    bends = np.abs(np.diff(values, n=2, axis=0))
    for j, bend in enumerate(bends.T):
        known = values[~np.isnan(values[:, j]), j]
        least = _LEAST_JUMP * float(np.ptp(known)) if len(known) else 0.0
        usual = bend[bend > 1e-6 * least]
        if len(usual):
            found[1:-1, j] = bend > max(_JUMP * float(np.median(usual)), least)
    return found


def estimated_delay(
    t: Floats, expected: Floats, read_at: Floats, lengths: Floats, near: float | None = None
) -> Delay | None:
    """Find by how much the sensors lag.

    Args:
        t: clock of the reference, shape (N,), seconds.
        expected: change of each sensor's length by the reference, shape (N, n); NaN where unknown.
        read_at: clock of the sensors, shape (K,), seconds.
        lengths: what they read, shape (K, n); NaN where there is none.
        near: seconds about which it is sought; None for everywhere.

    Returns:
        None where no sensor tells enough.
    """
    from ccgen.recordings.learning import independent_rows

    span = min(LARGEST_DELAY, (t[-1] - t[0]) / 8)
    step = max(_usual_step(t), 2 * span / _MOST_STEPS)
    if not span > 0 or not step > 0:
        return None
    every = max(1, len(read_at) // _GRID_ROWS)
    grid = np.arange(-np.floor(span / step), np.floor(span / step) + 1) * step
    if near is not None:
        grid = grid[np.abs(grid - near) <= _NEAR * step]
    slope = np.gradient(expected, np.maximum.accumulate(t + 1e-9 * np.arange(len(t))), axis=0)
    chosen = slice(None, None, every)
    track, turned = _Track(t, expected), _Track(t, slope)
    misfits = []
    for d in grid:
        at = read_at[chosen] - d
        misfits.append(_misfit(track.sampled(at, at), lengths[chosen]))
    if not np.isfinite(misfits).any():
        return None
    delay = float(grid[np.nanargmin(misfits)])
    share = independent_rows(lengths) / len(lengths) if len(lengths) > 1 else 1.0
    std = np.inf
    for _ in range(_TURNS):
        at = read_at - delay
        known = track.sampled(at, at), turned.sampled(at, at)
        change, information = _step(*known, lengths)
        if not information > 0:
            return None
        delay += float(np.clip(change, -step, step))
        std = float(1 / np.sqrt(information * max(share, 1 / len(lengths))))
    return Delay(float(np.clip(delay, -span, span)), std)


def counts_as_none(delay: Delay) -> bool:
    """Whether a delay on a common clock is no more than chance."""
    return abs(delay.seconds) < _CERTAIN * delay.std


def _usual_step(t: Floats) -> float:
    steps = np.diff(t)
    return float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0


def _misfit(expected: Floats, lengths: Floats) -> float:
    """Mean over sensors of the logarithm of what a gain and a zero leave of the variance."""
    total, sensors = 0.0, 0
    for x, y in zip(expected.T, lengths.T, strict=True):
        there = ~np.isnan(x) & ~np.isnan(y)
        if there.sum() < _FEWEST:
            continue
        a, b = x[there] - x[there].mean(), y[there] - y[there].mean()
        both = float(a @ a) * float(b @ b)
        if both > 0:
            total += np.log(max(1.0 - float(a @ b) ** 2 / both, 1e-12))
            sensors += 1
    return total / sensors if sensors else np.nan


def _step(expected: Floats, slope: Floats, lengths: Floats) -> tuple[float, float]:
    """Change of the delay by Gauss-Newton, and the information about it."""
    gradient = information = 0.0
    for x, s, y in zip(expected.T, slope.T, lengths.T, strict=True):
        there = ~np.isnan(x) & ~np.isnan(y) & ~np.isnan(s)
        if there.sum() < _FEWEST:
            continue
        for _ in range(2):  # without outliers the second time
            base = np.stack([x[there], np.ones(int(there.sum()))], axis=1)
            fitted, *_ = np.linalg.lstsq(base, y[there], rcond=None)
            residual = y - fitted[0] * x - fitted[1]
            scale = 1.4826 * float(np.median(np.abs(residual[there])))
            kept = there & (np.abs(np.nan_to_num(residual)) <= _OUTLIER * max(scale, 1e-12))
            if kept.sum() < _FEWEST:
                break
            there = kept
        base = np.stack([x[there], np.ones(int(there.sum()))], axis=1)
        late = -fitted[0] * s[there]
        along, *_ = np.linalg.lstsq(base, late, rcond=None)
        late = late - base @ along
        variance = max(float(np.var(residual[there])), 1e-18)
        gradient += float(late @ residual[there]) / variance
        information += float(late @ late) / variance
    return (gradient / information if information > 0 else 0.0), information
