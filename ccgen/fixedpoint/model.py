"""The integer reference model: what the C estimator computes, bit for bit.

    d_j     = count_j - zero_j
    acc_i   = bias_i + sum_j W_ij d_j
    angle_i = saturate(acc_i >> shift)

NumPy's int64 carries every value exactly: |acc| < 2^63 is proven when a model is made.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AxisModel:
    """Fixed-point estimator of one bending axis with m segments and n sensors.

    Attributes:
        axis: "u" or "v".
        precision: bits of counts, weights and angles, 16 or 32.
        weights: shape (m, n), angle steps times 2^shift per count.
        bias: shape (m,), intercept and rounding half, in steps of the accumulator.
        shift: bits dropped from the accumulator.
        fraction_bits: an angle of 1 rad is 2^fraction_bits.
        minimum, maximum: shape (n,), the transducers' declared ranges in counts.
        zero: shape (n,), counts at the straight pose.
        saturates: whether some count and zero in range exceed the angle's format.
        headroom_bits: doublings the accumulator stays clear of overflow.
        worst_error_percent_rom: proven bound of what quantisation adds, over all counts and
            zeros in range; where the axis saturates, over those that do not.
        rms_error_percent_rom: root mean square of what it adds over the shape library.
    """

    axis: str
    precision: int
    weights: Integers
    bias: Integers
    shift: int
    fraction_bits: int
    minimum: Integers
    maximum: Integers
    zero: Integers
    saturates: bool
    headroom_bits: int
    worst_error_percent_rom: float
    rms_error_percent_rom: float

    @property
    def segments(self) -> int:
        """Number of segments m."""
        return int(self.weights.shape[0])

    @property
    def sensors(self) -> int:
        """Number of sensors n."""
        return int(self.weights.shape[1])

    @property
    def angle_limit(self) -> int:
        """Largest magnitude of an angle; the most negative value means "no reading"."""
        return int(2 ** (self.precision - 1) - 1)

    @property
    def narrow(self) -> bool:
        """Whether every difference of a count and a zero in range fits int16."""
        return bool(np.all(self.maximum - self.minimum <= 2**15 - 1))

    def missing(self, counts: ArrayLike) -> NDArray[np.bool_]:
        """Which readings lie outside their transducer's range; shape (..., n)."""
        values = np.asarray(counts, dtype=np.int64)
        return np.asarray((values < self.minimum) | (values > self.maximum))

    def estimate(self, counts: ArrayLike, zero: ArrayLike | None = None) -> Integers:
        """Angles of all segments, integers in steps of 2^-fraction_bits rad.

        Args:
            counts: shape (..., n), each within its transducer's range.
            zero: shape (n,) or (..., n), counts at the straight pose; the model's own by default.

        Returns:
            Shape (..., m).

        Raises:
            ValueError: a count or a zero is out of range.
        """
        values = np.asarray(counts, dtype=np.int64)
        offset = self.zero if zero is None else np.asarray(zero, dtype=np.int64)
        if self.missing(values).any() or self.missing(offset).any():
            raise ValueError(f"axis {self.axis}: a count or a zero is outside its range")
        angles = ((values - offset) @ self.weights.T + self.bias) >> self.shift
        return np.asarray(np.clip(angles, -self.angle_limit, self.angle_limit))

    def radians(self, angles: ArrayLike) -> Floats:
        """Angles in rad from integer angles; exact."""
        return np.ldexp(np.asarray(angles, dtype=np.float64), -self.fraction_bits)


@dataclass(frozen=True, eq=False)
class FixedPointModel:
    """Both axes of a joint."""

    name: str
    precision: int
    u: AxisModel
    v: AxisModel

    def axis(self, name: str) -> AxisModel:
        """Return axis "u" or "v"."""
        return {"u": self.u, "v": self.v}[name]

    @property
    def segments(self) -> int:
        """Number of segments m."""
        return self.u.segments

    def estimate(self, counts: ArrayLike, zero: ArrayLike | None = None) -> Integers:
        """Angles of both axes, u then v, from counts and zeros, u then v.

        Args:
            counts: shape (..., nu + nv).
            zero: shape (nu + nv,) or (..., nu + nv); the model's own by default.

        Returns:
            Shape (..., 2 m).

        Raises:
            ValueError: a count or a zero is out of range.
        """
        split = [self.u.sensors]
        own = np.concatenate([self.u.zero, self.v.zero])
        u, v = np.split(np.asarray(counts, dtype=np.int64), split, axis=-1)
        zero_u, zero_v = np.split(np.asarray(own if zero is None else zero), split, axis=-1)
        return np.concatenate([self.u.estimate(u, zero_u), self.v.estimate(v, zero_v)], axis=-1)
