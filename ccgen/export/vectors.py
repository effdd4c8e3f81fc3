"""Test vectors: drawn alike in Python and in the self-test on the target.

Draw k of a block is a 32-bit mix of seed and k, so that Python draws a whole block at once. A
quarter of the draws sit on an end of the range: of what is accepted as a zero, and of what is a
reading with that zero; then readings are lost. A block is compared by a checksum in which every
single wrong value shows: h = 16777619 h + value (mod 2^32), of each snapshot the states of the axes
and then all values, in order.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.fixedpoint import FixedPointModel
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.model import SensorRanges

Integers = NDArray[np.int64]

STEP = 0x9E3779B9
MIX = (0x85EBCA6B, 0xC2B2AE35)
CHECKSUM_FACTOR = 16777619
_MASK = np.uint64(0xFFFFFFFF)


@dataclass(frozen=True, eq=False)
class Block:
    """Counts and zeros in the joint's order of sensors; shapes (k, n)."""

    counts: Integers
    zeros: Integers


def draws(seed: int, number: int) -> NDArray[np.uint64]:
    """Return the first draws of a block, each below 2^32."""
    x = (np.uint64(seed) + np.uint64(STEP) * np.arange(1, number + 1, dtype=np.uint64)) & _MASK
    for shift, factor in ((16, MIX[0]), (13, MIX[1])):
        x ^= x >> np.uint64(shift)
        x = (x * np.uint64(factor)) & _MASK
    return x ^ (x >> np.uint64(16))


def block(model: FixedPointModel, seed: int, snapshots: int) -> Block:
    """Draw zeros and counts over the full declared ranges, ends included, and lose readings."""
    readings = model.readings
    n = readings.sensors
    x = draws(seed, snapshots * (2 * n + 1)).reshape(snapshots, 2 * n + 1)
    zeros = _spread(x[:, :n], readings.zeros)
    counts = _spread(x[:, n : 2 * n], readings.around(zeros))
    lost = _lost(x[:, -1], n)
    counts[lost] = -(2 ** (model.precision - 1))
    return Block(counts, zeros)


def _lost(x: NDArray[np.uint64], sensors: int) -> NDArray[np.bool_]:
    """Which readings are lost, shape (k, sensors): of one snapshot of two, up to three."""
    lost = np.zeros((len(x), sensors), dtype=np.bool_)
    goes = np.ones(len(x), dtype=np.bool_)
    for _ in range(3):
        goes &= (x & np.uint64(1)) != 0
        rows = np.flatnonzero(goes)
        lost[rows, ((x[rows] >> np.uint64(8)) % np.uint64(sensors)).astype(np.int64)] = True
        x = ((x >> np.uint64(1)) ^ (x << np.uint64(7))) & _MASK
    return lost


@dataclass(frozen=True)
class Outcome:
    """What a block comes to.

    Attributes:
        checksum: of the states of its axes and of its values.
        degraded: snapshots in which some axis is degraded or lost.
    """

    checksum: int
    degraded: int


def outcome(guarded: GuardedModel, seed: int, snapshots: int) -> Outcome:
    """Estimate a block, with the checks going on from one snapshot to the next."""
    drawn = block(guarded.model, seed, snapshots)
    followed = guarded.follow(drawn.counts, drawn.zeros)
    states = followed.mask(tuple(guarded.model.axes))
    values = np.column_stack([states, followed.values])
    return Outcome(checksum(values), int(np.count_nonzero(states)))


def _spread(x: NDArray[np.uint64], ranges: SensorRanges) -> Integers:
    """Draws over ranges: a quarter on an end."""
    places = (ranges.maximum - ranges.minimum + 1).astype(np.uint64)
    inside = ranges.minimum + (x % places).astype(np.int64)
    kind = x >> np.uint64(29)
    return np.where(kind == 0, ranges.minimum, np.where(kind == 1, ranges.maximum, inside))


def checksum(values: Integers) -> int:
    """Checksum of all values in order, modulo 2^32."""
    flat = values.reshape(-1) & 0xFFFFFFFF
    powers = np.ones(flat.size, dtype=np.uint32)
    np.multiply.accumulate(
        np.full(max(flat.size - 1, 0), CHECKSUM_FACTOR, dtype=np.uint32), out=powers[1:]
    )
    return int(np.sum(flat.astype(np.uint32) * powers[::-1], dtype=np.uint32))
