"""The integer check of sensors against each other: what the C node computes, bit for bit.

A group is the sensors that output axes read together: a bending axis' own, or all of a joint whose
axes couple. For a snapshot in which every sensor of the group has a reading, with differences
d_k = count_k - zero_k:

    z_j    = sum_k W_jk d_k                        accumulator of twice the precision, no shift
    alarm  = |z_j| > threshold_j for some j
    first  = the lowest j of largest |z_j|
    second = the largest |z_j| of the others       (0 in a group of one)
    named  = first, where alarm and |z_first| - second > margin_first; else nobody

All rows W_j share one scale, so that their |z_j| compare. |z_j| and every partial sum stay below
2^(2 precision - 1) for all differences in range: no addition wraps, and |z_j| exists. What a
verdict does to a joint over time is `ccgen.fixedpoint.watch`.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.fixedpoint.model import Floats, Integers

NOBODY = -1
"""In the place of a sensor's number."""


@dataclass(frozen=True, eq=False)
class GroupCheck:
    """The check of one group of n sensors.

    Attributes:
        first: number of its first sensor in the joint's list; the others follow.
        precision: bits of counts and weights, 16 or 32.
        weights: W, shape (n, n), steps of z per count.
        threshold: shape (n,), steps of z, 0 or more.
        margin: shape (n,), steps of z, 0 or more.
    """

    first: int
    precision: int
    weights: Integers
    threshold: Integers
    margin: Integers

    @property
    def sensors(self) -> int:
        """Number n of sensors."""
        return int(self.weights.shape[0])

    @property
    def own(self) -> slice:
        """The group's part of the joint's list of sensors."""
        return slice(self.first, self.first + self.sensors)

    def residuals(self, differences: ArrayLike) -> Integers:
        """z of snapshots, shape (..., n), from the group's differences, shape (..., n)."""
        return np.asarray(np.asarray(differences, dtype=np.int64) @ self.weights.T)

    def verdicts(self, differences: ArrayLike) -> tuple[NDArray[np.bool_], Integers]:
        """Whether snapshots alarm, and the sensor of the group that each names or `NOBODY`.

        Args:
            differences: shape (K, n), counts minus zeros; every sensor with a reading.

        Returns:
            Shapes (K,) and (K,).
        """
        size = np.abs(self.residuals(differences))
        alarm = np.asarray((size > self.threshold).any(axis=1))
        first = size.argmax(axis=1)
        rows = np.arange(len(size))
        largest = size[rows, first]
        size[rows, first] = 0
        clear = largest - size.max(axis=1) > self.margin[first]
        return alarm, np.asarray(np.where(alarm & clear, first, NOBODY), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class RoundedResiduals:
    """Rows of a residual matrix in integers.

    Attributes:
        weights: shape (n, n).
        matrix: what they stand for, shape (n, n), 1/metres.
        scale: z of 1 is 2^scale steps.
    """

    weights: Integers
    matrix: Floats
    scale: int

    def steps(self, values: Floats, precision: int) -> Integers:
        """Values of z, 0 or more, in whole steps; what exceeds every z becomes the largest."""
        limit = 2 ** (2 * precision - 1) - 1
        steps = np.rint(np.ldexp(values, self.scale)).tolist()
        return np.array([min(int(step), limit) for step in steps], dtype=np.int64)


def rounded_residuals(
    matrix: Floats, metres_per_count: Floats, span: Integers, precision: int
) -> RoundedResiduals:
    """Round a residual matrix to integers on the finest scale without overflow.

    Args:
        matrix: T, shape (n, n), 1/metres.
        metres_per_count: shape (n,).
        span: the largest |difference| of each sensor, shape (n,).
        precision: 16 or 32.
    """
    gains = matrix * metres_per_count
    weight_limit, limit = 2 ** (precision - 1) - 1, 2 ** (2 * precision - 1) - 1
    scale = precision - math.frexp(float(np.abs(gains).max()))[1]
    while True:
        rounded = np.rint(np.ldexp(gains, scale))
        if np.abs(rounded).max() <= weight_limit:
            weights = rounded.astype(np.int64)
            if largest_residual(weights, span) <= limit:
                return RoundedResiduals(
                    weights, np.ldexp(rounded, -scale) / metres_per_count, scale
                )
        scale -= 1


def largest_residual(weights: Integers, span: Integers) -> int:
    """Bound of |z_j| and of every partial sum: max_j sum_k |W_jk| D_k."""
    return max(sum(abs(int(w)) * int(d) for w, d in zip(row, span, strict=True)) for row in weights)
