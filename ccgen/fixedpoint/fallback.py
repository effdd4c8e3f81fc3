"""The integer reference model of an axis of which a sensor gives no reading.

A mask tells which sensors of the axis are absent: without a reading, or left out. With the axis'
own bias, shift and fraction bits, in every case:

    nobody is absent:          the axis' own rows
    j alone is absent:         d_j = 0 and the rows of fallback j, whose column j is 0
    j alone, no such rows:     the axis is lost
    two or more are absent:    the axis is lost

All values of a lost axis are the most negative one, "no reading".
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.fixedpoint import bounds
from ccgen.fixedpoint.model import AxisModel, Floats, Integers


@dataclass(frozen=True, eq=False)
class Fallbacks:
    """Rows that serve while one sensor of an axis is absent.

    Attributes:
        rows: for each of the axis' n sensors weights of shape (m, n), or None where the axis is
            lost without it.
        saturates: whether some difference in range exceeds the angle's format with some rows.
    """

    rows: Sequence[Integers | None]
    saturates: bool

    def flash_bytes(self, precision: int) -> int:
        """Bytes of all rows in flash, where an odd number of 16-bit weights is padded."""
        found = [table for table in self.rows if table is not None]
        padded = sum(len(table) * (table.shape[1] + table.shape[1] % 2) for table in found)
        plain = sum(table.size for table in found)
        return 2 * padded if precision == 16 else 4 * plain


def fallbacks(own: AxisModel, gains: Sequence[Floats | None]) -> Fallbacks:
    """Round fallback weights to the format of an axis.

    Args:
        own: the axis.
        gains: for each of its sensors radians per count, shape (m, n), or None.

    Raises:
        ValueError: a weight or a sum does not fit the format.
    """
    rows: list[Integers | None] = []
    largest = 0
    for table in gains:
        rounded = None if table is None else _rounded(own, table)
        if rounded is not None:
            largest = max(largest, _checked_sum(own, rounded))
        rows.append(rounded)
    return Fallbacks(rows, -(-largest >> own.shift) > own.angle_limit)


def weight_limit(own: AxisModel) -> Floats:
    """Largest |gain| of each sensor, shape (n,), rad per count, that rows of an axis can hold.

    Where all weights were as large, their sum would not overflow either.
    """
    sums = 2 ** (2 * own.precision - 1) - 1 - (1 << own.shift) - int(np.abs(own.bias).max())
    total = sum(int(distance) for distance in own.span)
    largest = min(2 ** (own.precision - 1) - 1, sums // total)
    return np.full(own.sensors, np.ldexp(float(largest), -(own.fraction_bits + own.shift)))


def served(
    own: AxisModel, rows: Sequence[Integers | None], differences: ArrayLike, absent: ArrayLike
) -> Integers:
    """Values of an axis with what serves in each snapshot.

    Args:
        own: the axis.
        rows: `Fallbacks.rows`; empty where there are none.
        differences: shape (K, n), counts minus zeros; what stands at an absent sensor is not read.
        absent: shape (K, n).

    Returns:
        Shape (K, m); the most negative value where the axis is lost.
    """
    gone: NDArray[np.bool_] = np.asarray(absent, dtype=np.bool_)
    distances = np.where(gone, 0, np.asarray(differences, dtype=np.int64))
    values = np.full((len(gone), own.segments), -own.angle_limit - 1, dtype=np.int64)
    count = gone.sum(axis=1)
    whole = count == 0
    values[whole] = _evaluated(own, own.weights, distances[whole])
    for j, table in enumerate(rows):
        alone = (count == 1) & gone[:, j]
        if table is not None and alone.any():
            values[alone] = _evaluated(own, table, distances[alone])
    return values


def _rounded(own: AxisModel, gains: Floats) -> Integers:
    rounded = np.rint(np.ldexp(gains, own.fraction_bits + own.shift))
    if np.abs(rounded).max() > 2 ** (own.precision - 1) - 1:
        raise ValueError(f"axis {own.axis}: a fallback's weight does not fit the format")
    return rounded.astype(np.int64)


def _checked_sum(own: AxisModel, rows: Integers) -> int:
    largest = bounds.largest_accumulator(rows, own.bias, own.span)
    if largest + (1 << own.shift) > 2 ** (2 * own.precision - 1) - 1:
        raise ValueError(f"axis {own.axis}: a fallback's sum does not fit the accumulator")
    return largest


def _evaluated(own: AxisModel, rows: Integers, differences: Integers) -> Integers:
    values = (differences @ rows.T + own.bias) >> own.shift
    return np.asarray(np.clip(values, -own.angle_limit, own.angle_limit))
