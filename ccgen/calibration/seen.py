"""What sensors read beside what they should, and the plain gains between the two."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Seen:
    """What n sensors read in N rows of a recording, and what they should.

    Attributes:
        source: how messages name the recording.
        t: shape (N,), seconds; numbers of rows where there are no times.
        timed: whether `t` are seconds.
        expected: changes of length of the reference shapes, shape (N, n), metres; NaN: unknown.
        lengths: readings at nominal gain, shape (N, n), metres; NaN: none, or stuck.
        raw: the same with those that stick, shape (N, n).
        step: nominal metres per count, shape (n,).
        noise: what is usual for a reading of the joint, play and all, metres.
    """

    source: str
    t: Floats
    timed: bool
    expected: Floats
    lengths: Floats
    raw: Floats
    step: Floats
    noise: float = 0.0


def pooled(seen: Sequence[Seen], i: int, j: int) -> tuple[Floats, Floats]:
    """Expected changes of sensor j and readings of i, each about their mean in a recording.

    Returns:
        Shape (K,) each, of all rows that have both, metres.
    """
    xs, ys = [np.zeros(0)], [np.zeros(0)]
    for one in seen:
        x, y = one.expected[:, j], one.lengths[:, i]
        there = ~np.isnan(x) & ~np.isnan(y)
        if there.any():
            xs.append(x[there] - x[there].mean())
            ys.append(y[there] - y[there].mean())
    return np.concatenate(xs), np.concatenate(ys)


def gain_of(x: Floats, y: Floats) -> float:
    """Gain of readings by expected changes, both about their mean; NaN where those do not move."""
    moved = float(x @ x)
    return float(x @ y) / moved if moved > 0 else np.nan


def correlation(x: Floats, y: Floats) -> float:
    """Correlation of readings and expected changes, both about their mean; 0 where one rests."""
    both = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / both if both > 0 else 0.0
