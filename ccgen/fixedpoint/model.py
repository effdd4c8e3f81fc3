"""The integer reference model: what the C estimator computes, bit for bit.

    d_j     = count_j - zero_j
    acc_i   = bias_i + sum_j W_ij d_j
    angle_i = saturate(acc_i >> shift)

NumPy's int64 carries every value exactly: |acc| < 2^63 is proven when a model is made.

An output axis reads a contiguous part of the joint's one list of sensors: its own where axes are
independent, all of them where sensors couple.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RelativeRange:
    """Ranges relative to a zero that may be captured: shape (n,) counts, ends included.

    Attributes:
        minimum, maximum: lowest and highest difference of a reading and the zero.
        zero_minimum, zero_maximum: zeros that leave the range of motion within the counts.
    """

    minimum: Integers
    maximum: Integers
    zero_minimum: Integers
    zero_maximum: Integers

    @property
    def span(self) -> Integers:
        """Largest |count - zero|; shape (n,)."""
        return np.maximum(-self.minimum, self.maximum)


@dataclass(frozen=True, eq=False)
class SensorRanges:
    """What n sensors may count; shape (n,) each.

    Attributes:
        minimum, maximum: lowest and highest counts of a reading.
        zero: counts at the straight pose.
        relative: as of `AxisModel`.
    """

    minimum: Integers
    maximum: Integers
    zero: Integers
    relative: RelativeRange | None = None

    @property
    def sensors(self) -> int:
        """Number n of sensors."""
        return int(self.zero.size)

    @property
    def span(self) -> Integers:
        """Largest |count - zero| of a reading; shape (n,)."""
        return self.maximum - self.minimum if self.relative is None else self.relative.span

    @property
    def bounds_differences(self) -> bool:
        """Whether some count in range is too far from some zero in range to be a reading."""
        if self.relative is None:
            return False
        low = self.minimum - self.relative.zero_maximum
        high = self.maximum - self.relative.zero_minimum
        return bool(np.any((low < self.relative.minimum) | (high > self.relative.maximum)))

    @property
    def zeros(self) -> "SensorRanges":
        """What is accepted as zeros."""
        if self.relative is None:
            return self
        low, high = self.relative.zero_minimum, self.relative.zero_maximum
        return SensorRanges(low, high, self.zero)

    @property
    def moved(self) -> Integers:
        """Counts from one end of the motion to the other, shape (n,).

        Of relative ranges those of the shapes alone, however many more the transducer has.
        """
        width = self.maximum - self.minimum
        if self.relative is None:
            return np.asarray(width)
        free = self.relative.zero_maximum - self.relative.zero_minimum
        return np.asarray(width - free)

    def around(self, zero: ArrayLike | None = None) -> "SensorRanges":
        """Counts that are readings with a zero, of shape (..., n); the own one by default."""
        offset = self.zero if zero is None else np.asarray(zero, dtype=np.int64)
        if self.relative is None:
            return SensorRanges(self.minimum, self.maximum, offset)
        low = np.maximum(self.minimum, offset + self.relative.minimum)
        high = np.minimum(self.maximum, offset + self.relative.maximum)
        return SensorRanges(low, high, offset)


@dataclass(frozen=True, eq=False)
class AxisModel:
    """Fixed-point estimator of one output axis: m rows, of segments or sections, and n sensors.

    Attributes:
        axis: "u", "v" or "h".
        precision: bits of counts, weights and angles, 16 or 32.
        weights: shape (m, n), angle steps times 2^shift per count.
        bias: shape (m,), intercept and rounding half, in steps of the accumulator.
        shift: bits dropped from the accumulator.
        fraction_bits: an angle of 1 rad, or a share of 1, is 2^fraction_bits.
        minimum, maximum: shape (n,), lowest and highest counts of a reading.
        zero: shape (n,), counts at the straight pose.
        saturates: whether some count and zero in range exceed the angle's format.
        headroom_bits: doublings the accumulator stays clear of overflow.
        worst_error_percent_rom: proven bound of what quantisation adds, over all counts and
            zeros in range; where the axis saturates, over those that do not.
        rms_error_percent_rom: root mean square of what it adds over the shape library. Of "h"
            both are % of the length.
        first: number of its first sensor in the joint's list.
        relative: what a zero may be and how far readings may lie from it; None where any zero and
            any reading within the range of counts will do.
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
    first: int = 0
    relative: RelativeRange | None = None

    @property
    def segments(self) -> int:
        """Number m of rows: segments, or sections of "h"."""
        return int(self.weights.shape[0])

    @property
    def part(self) -> slice:
        """The part of the joint's list of sensors that this axis reads."""
        return slice(self.first, self.first + self.sensors)

    @property
    def sensors(self) -> int:
        """Number of sensors n."""
        return int(self.weights.shape[1])

    @property
    def angle_limit(self) -> int:
        """Largest magnitude of an angle; the most negative value means "no reading"."""
        return int(2 ** (self.precision - 1) - 1)

    @property
    def ranges(self) -> SensorRanges:
        """What its sensors may count."""
        return SensorRanges(self.minimum, self.maximum, self.zero, self.relative)

    @property
    def span(self) -> Integers:
        """Largest |count - zero| of each sensor that is a reading; shape (n,)."""
        return self.ranges.span

    @property
    def narrow(self) -> bool:
        """Whether every difference of a count and a zero in range fits int16."""
        return bool(np.all(self.span <= 2**15 - 1))

    def missing(self, counts: ArrayLike, zero: ArrayLike | None = None) -> NDArray[np.bool_]:
        """Which readings lie outside their range; shape (..., n).

        Args:
            counts: shape (..., n).
            zero: as of `estimate`.
        """
        values = np.asarray(counts, dtype=np.int64)
        outside = (values < self.minimum) | (values > self.maximum)
        if self.relative is not None:
            far = values - (self.zero if zero is None else np.asarray(zero, dtype=np.int64))
            outside |= (far < self.relative.minimum) | (far > self.relative.maximum)
        return np.asarray(outside)

    def refused(self, zero: ArrayLike) -> NDArray[np.bool_]:
        """Which zeros would leave the range of motion without counts; shape (..., n)."""
        values = np.asarray(zero, dtype=np.int64)
        low, high = self.minimum, self.maximum
        if self.relative is not None:
            low, high = self.relative.zero_minimum, self.relative.zero_maximum
        return np.asarray((values < low) | (values > high))

    def estimate(self, counts: ArrayLike, zero: ArrayLike | None = None) -> Integers:
        """Angles of all segments, integers in steps of 2^-fraction_bits rad.

        Args:
            counts: shape (..., n), each within its range.
            zero: shape (n,) or (..., n), counts at the straight pose; the model's own by default.

        Returns:
            Shape (..., m).

        Raises:
            ValueError: a count or a zero is out of range.
        """
        values = np.asarray(counts, dtype=np.int64)
        offset = self.zero if zero is None else np.asarray(zero, dtype=np.int64)
        if self.missing(values, offset).any() or self.refused(offset).any():
            raise ValueError(f"axis {self.axis}: a count or a zero is outside its range")
        angles = ((values - offset) @ self.weights.T + self.bias) >> self.shift
        return np.asarray(np.clip(angles, -self.angle_limit, self.angle_limit))

    def radians(self, angles: ArrayLike) -> Floats:
        """Angles in rad from integer angles; exact."""
        return np.ldexp(np.asarray(angles, dtype=np.float64), -self.fraction_bits)


@dataclass(frozen=True, eq=False)
class FixedPointModel:
    """All output axes of a joint.

    Attributes:
        name: the joint's.
        precision: bits of counts, weights and angles, 16 or 32.
        axes: models by output axis, in the order "u", "v", "h".
    """

    name: str
    precision: int
    axes: Mapping[str, AxisModel]

    @property
    def u(self) -> AxisModel:
        """Bending about x."""
        return self.axes["u"]

    @property
    def v(self) -> AxisModel:
        """Bending about y."""
        return self.axes["v"]

    def axis(self, name: str) -> AxisModel:
        """Return an output axis."""
        return self.axes[name]

    @property
    def segments(self) -> int:
        """Number of segments m."""
        return next(model.segments for axis, model in self.axes.items() if axis != "h")

    @property
    def values(self) -> int:
        """Number of values of all axes."""
        return sum(model.segments for model in self.axes.values())

    @property
    def groups(self) -> tuple[SensorRanges, ...]:
        """Ranges of sensors that meet in an axis, in the joint's order of sensors."""
        parts = {model.first: model.ranges for model in self.axes.values()}
        return tuple(parts[first] for first in sorted(parts))

    @property
    def readings(self) -> SensorRanges:
        """The ranges and zeros of all sensors."""
        groups = self.groups
        relatives = [group.relative for group in groups if group.relative is not None]
        relative = None
        if relatives:
            relative = RelativeRange(
                *(_joined(relatives, field.name) for field in fields(RelativeRange))
            )
        low, high, zero = (_joined(groups, name) for name in ("minimum", "maximum", "zero"))
        return SensorRanges(low, high, zero, relative)

    def split(self, values: Integers) -> dict[str, Integers]:
        """Values of each axis, shape (..., m), from those of all, shape (..., rows of all axes)."""
        ends = np.cumsum([model.segments for model in self.axes.values()])[:-1]
        return dict(zip(self.axes, np.split(values, ends, axis=-1), strict=True))

    def estimate(self, counts: ArrayLike, zero: ArrayLike | None = None) -> Integers:
        """Values of all axes, one axis after the other, from counts and zeros of all sensors.

        Args:
            counts: shape (..., n), in the joint's order of sensors.
            zero: shape (n,) or (..., n); the model's own by default.

        Returns:
            Shape (..., rows of all axes).

        Raises:
            ValueError: a count or a zero is out of range.
        """
        values = np.asarray(counts, dtype=np.int64)
        offset = self.readings.zero if zero is None else np.asarray(zero, dtype=np.int64)
        return np.concatenate(
            [
                model.estimate(values[..., model.part], offset[..., model.part])
                for model in self.axes.values()
            ],
            axis=-1,
        )


def _joined(parts: Sequence[SensorRanges] | Sequence[RelativeRange], name: str) -> Integers:
    return np.concatenate([getattr(part, name) for part in parts])
