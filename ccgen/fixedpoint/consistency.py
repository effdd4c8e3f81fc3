"""The integer check of sensors against each other: what the C node computes, bit for bit.

A group is the sensors that output axes read together: a bending axis' own, or all of a joint whose
axes couple. For a snapshot in which every one of its n sensors has a reading, with differences
d_k = count_k - zero_k and numbers P of parity values, the first ones or all:

    p_i    = sum_k V_ik d_k                        accumulator of twice the precision
    shift  = the least from the group's own on with which all P values fit:
             q_i = p_i >> shift,  -2^15 <= q_i < 2^15
    z_j    = sum_i B_ji q_i                        32 bits
    more   = shift - the group's own

    alarm  = |z_j| > threshold_j >> more for some j, of the values that decide on alarms
    first  = the lowest j of largest |z_j|, of all values
    second = the largest |z_j| of the others       (0 in a group of one)
    named  = first, where alarm and |z_first| - second > margin_first >> more; else nobody

No sum wraps for differences in range, and |z_j| exists. While -2^b <= p_i < 2^b for the values that
decide, with the group's number b of bits, no |z_j| exceeds its threshold: the C then is done. What
a verdict does to a joint over time is `ccgen.fixedpoint.watch`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.estimation.consistency.box import half_edge
from ccgen.estimation.consistency.residuals import Parity
from ccgen.fixedpoint.model import Floats, Integers

NOBODY = -1
"""In the place of a sensor's number."""

BOX_BITS = 10
"""Bits of a parity value, without its sign, at the edge of where nothing alarms."""
_VALUE_BITS = 15
_LARGEST = 2**31 - 1
_LARGEST_DIRECTIONS = 2**16 - 1
"""Of one z, the sum of sizes: so many values of 16 bits stay below 2^31."""


@dataclass(frozen=True, eq=False)
class GroupCheck:
    """The check of one group of n sensors.

    Attributes:
        first: number of its first sensor in the joint's list; the others follow.
        precision: bits of counts and weights, 16 or 32.
        weights: V, shape (n, n), steps of p per count.
        kept: how many of the first p decide on alarms.
        quiet_bits: b.
        directions: B, shape (n, n), of 16 bits.
        threshold: shape (n,), steps of z, 0 or more.
        margin: shape (n,), steps of z, 0 or more.
    """

    first: int
    precision: int
    weights: Integers
    kept: int
    quiet_bits: int
    directions: Integers
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

    @property
    def shift(self) -> int:
        """Bits that parity values lose at least."""
        return _shift(self.quiet_bits)

    def quiet(self, differences: ArrayLike) -> NDArray[np.bool_]:
        """Of which snapshots the parity values alone tell that nothing alarms, shape (K,).

        Args:
            differences: as of `verdicts`.
        """
        values = np.asarray(differences, dtype=np.int64) @ self.weights[: self.kept].T
        edge = 1 << self.quiet_bits
        return np.asarray(((-edge <= values) & (values < edge)).all(axis=1))

    def verdicts(self, differences: ArrayLike) -> tuple[NDArray[np.bool_], Integers]:
        """Whether snapshots alarm, and the sensor of the group that each names or `NOBODY`.

        Args:
            differences: shape (K, n), counts minus zeros; every sensor with a reading.

        Returns:
            Shapes (K,) and (K,).
        """
        values = np.asarray(differences, dtype=np.int64) @ self.weights.T
        size, more = self._sizes(values[:, : self.kept])
        alarm = np.asarray((size > self.threshold >> more[:, None]).any(axis=1))
        named = np.full(len(values), NOBODY, dtype=np.int64)
        named[alarm] = self._named(values[alarm])
        return alarm, named

    def _named(self, values: Integers) -> Integers:
        size, more = self._sizes(values)
        first = size.argmax(axis=1)
        rows = np.arange(len(size))
        largest = size[rows, first]
        size[rows, first] = 0
        clear = largest - size.max(axis=1) > self.margin[first] >> more
        return np.asarray(np.where(clear, first, NOBODY), dtype=np.int64)

    def _sizes(self, values: Integers) -> tuple[Integers, Integers]:
        """|z| of parity values, shape (K, n), and the bits that they lose more, shape (K,)."""
        largest = np.where(values < 0, ~values, values).max(axis=1) >> self.shift
        more = sum((largest >> bits) >= 2**_VALUE_BITS for bits in range(64 - _VALUE_BITS))
        shifts = np.asarray(more, dtype=np.int64)
        short = values >> (self.shift + shifts)[:, None]
        return np.abs(short @ self.directions[:, : values.shape[1]].T), shifts

    def flaw(self, span: Integers) -> str | None:
        """Say what of the check may overflow, or hide an alarm; None where nothing does.

        Args:
            span: the largest |difference| of each sensor, shape (n,).
        """
        sizes = np.abs(self.directions).sum(axis=1)
        box = sizes_of_kept(self.directions, self.kept) << (self.quiet_bits - self.shift)
        if (
            largest_value(self.weights, span) + 2**self.quiet_bits
            > 2 ** (2 * self.precision - 1) - 1
        ):
            return "a sum may overflow"
        if sizes.max() > _LARGEST_DIRECTIONS:
            return "a residual may overflow"
        return "an alarm may pass unseen" if (box > self.threshold).any() else None


def _shift(quiet_bits: int) -> int:
    return max(0, quiet_bits - BOX_BITS)


def sizes_of_kept(directions: Integers, kept: int) -> Integers:
    """Sums of |B_ji| over the values that decide on alarms, shape (n,)."""
    return np.asarray(np.abs(directions[:, :kept]).sum(axis=1))


@dataclass(frozen=True, eq=False)
class RoundedParity:
    """Parity values and residuals of a group in integers.

    Attributes:
        weights, kept, quiet_bits, directions: as of `GroupCheck`.
        alarming, naming: the matrices of residuals that these stand for, shape (n, n), 1/metres.
        steps_per_unit: z of 1 in steps.
    """

    weights: Integers
    kept: int
    quiet_bits: int
    directions: Integers
    alarming: Floats
    naming: Floats
    steps_per_unit: float

    def steps(self, values: Floats) -> Integers:
        """Values of z, 0 or more, in whole steps; what exceeds every z becomes the largest."""
        steps = np.rint(values * self.steps_per_unit)
        return np.asarray(np.minimum(steps, _LARGEST), dtype=np.int64)

    def thresholds(self, limits: Floats) -> Integers:
        """Thresholds of z in steps, none below what the quiet box reaches."""
        bits = self.quiet_bits - _shift(self.quiet_bits)
        box = sizes_of_kept(self.directions, self.kept) << bits
        return np.asarray(np.maximum(self.steps(limits), box), dtype=np.int64)


def rounded_parity(
    parity: Parity, limits: Floats, metres_per_count: Floats, span: Integers, precision: int
) -> RoundedParity:
    """Round parity values and residuals to integers on the finest scale without overflow.

    Args:
        parity: of the group, in coordinates whose box is large.
        limits: about what the thresholds of its residuals will be, shape (n,).
        metres_per_count: shape (n,).
        span: the largest |difference| of each sensor, shape (n,).
        precision: 16 or 32.
    """
    gains = parity.basis * metres_per_count
    edge = _SLACK * half_edge(parity, limits)
    weight_limit, limit = 2 ** (precision - 1) - 1, 2 ** (2 * precision - 1) - 1
    bits = 2 * precision - 2
    while True:
        rounded = np.rint(np.ldexp(gains / edge, bits))
        if np.abs(rounded).max() <= weight_limit:
            weights = rounded.astype(np.int64)
            if largest_value(weights, span) + 2**bits <= limit:
                break
        bits -= 1
    sums = np.abs(parity.directions).sum(axis=1).max()
    finest = min(
        (2**_VALUE_BITS - 1) / np.abs(parity.directions).max(),
        (_LARGEST_DIRECTIONS - len(weights)) / sums,
    )
    directions = np.rint(parity.directions * finest).astype(np.int64)
    basis = weights * np.ldexp(edge, -bits) / metres_per_count
    kept = parity.kept
    return RoundedParity(
        weights=weights,
        kept=kept,
        quiet_bits=bits,
        directions=directions,
        alarming=directions[:, :kept] @ basis[:kept] / finest,
        naming=directions @ basis / finest,
        steps_per_unit=float(np.ldexp(finest / edge, bits - _shift(bits))),
    )


_SLACK = 0.98
"""Of the box, for what rounding changes of the thresholds."""


def largest_value(weights: Integers, span: Integers) -> int:
    """Bound of |p_i| and of every partial sum: max_i sum_k |V_ik| D_k."""
    return max(sum(abs(int(w)) * int(d) for w, d in zip(row, span, strict=True)) for row in weights)
