"""Numbers that are the unevaluated sum of two doubles, hi + lo with |lo| <= ulp(hi) / 2.

The error-free transformations are Knuth's TwoSum, Dekker's FastTwoSum and Dekker's product with
Veltkamp's splitting, which needs no fused multiply-add. On them stand the operations of M. Joldes,
J.-M. Muller, V. Popescu, "Tight and rigorous error bounds for basic building blocks of double-word
arithmetic" (ACM TOMS 44, 2017): relative errors of a few 2^-106, about 1e-32.

Values between about 1e-140 and 1e140, or zero, keep that: errors of products are doubles too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_SPLITTER = 2.0**27 + 1


@dataclass(frozen=True, eq=False)
class DoubleDouble:
    """An array of double-double numbers; operands broadcast, plain numbers and arrays are exact.

    Attributes:
        hi: the nearest doubles.
        lo: what they leave, of the same shape.
    """

    hi: Floats
    lo: Floats

    __array_ufunc__ = None  # so that an array on the left leaves the operation to this class

    @classmethod
    def of(cls, value: ArrayLike | DoubleDouble) -> DoubleDouble:
        """Take over doubles exactly."""
        if isinstance(value, DoubleDouble):
            return value
        hi = np.asarray(value, dtype=np.float64)
        return cls(hi, np.zeros_like(hi))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.hi.shape

    @property
    def T(self) -> DoubleDouble:  # noqa: N802
        """The transposed array, as of NumPy's."""
        return DoubleDouble(self.hi.T, self.lo.T)

    def __getitem__(self, key: Any) -> DoubleDouble:
        return DoubleDouble(self.hi[key], self.lo[key])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.hi, -self.lo)

    def __add__(self, other: ArrayLike | DoubleDouble) -> DoubleDouble:
        y = DoubleDouble.of(other)
        high, rest = two_sum(self.hi, y.hi)
        low, tail = two_sum(self.lo, y.lo)
        high, rest = fast_two_sum(high, rest + low)
        return DoubleDouble(*fast_two_sum(high, tail + rest))

    __radd__ = __add__

    def __sub__(self, other: ArrayLike | DoubleDouble) -> DoubleDouble:
        return self + -DoubleDouble.of(other)

    def __rsub__(self, other: ArrayLike | DoubleDouble) -> DoubleDouble:
        return -self + other

    def __mul__(self, other: ArrayLike | DoubleDouble) -> DoubleDouble:
        y = DoubleDouble.of(other)
        high, rest = two_product(self.hi, y.hi)
        return DoubleDouble(*fast_two_sum(high, rest + (self.hi * y.lo + self.lo * y.hi)))

    __rmul__ = __mul__

    def __truediv__(self, other: ArrayLike | DoubleDouble) -> DoubleDouble:
        y = DoubleDouble.of(other)
        quotient = self.hi / y.hi
        rest = self - y * quotient
        return DoubleDouble(*fast_two_sum(quotient, rest.hi / y.hi))

    def __rtruediv__(self, other: ArrayLike) -> DoubleDouble:
        return DoubleDouble.of(other) / self

    def sum(self, axis: int) -> DoubleDouble:
        """Sum over an axis, halves added to halves."""
        left = DoubleDouble(np.moveaxis(self.hi, axis, 0), np.moveaxis(self.lo, axis, 0))
        if not len(left.hi):
            return DoubleDouble.of(np.zeros(left.shape[1:]))
        while len(left.hi) > 1:
            half = len(left.hi) // 2
            pairs = left[:half] + left[half : 2 * half]
            left = concatenate([pairs, left[2 * half :]]) if len(left.hi) % 2 else pairs
        return left[0]


def two_sum(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return s and e with s = fl(x + y) and x + y = s + e exactly."""
    total = x + y
    kept = total - x
    return total, (x - (total - kept)) + (y - kept)


def fast_two_sum(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Like `two_sum` for |x| >= |y|, or x = 0."""
    total = x + y
    return total, y - (total - x)


def two_product(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return p and e with p = fl(x y) and x y = p + e exactly."""
    product = x * y
    x_high, x_low = _split(x)
    y_high, y_low = _split(y)
    rest = x_low * y_low - (((product - x_high * y_high) - x_low * y_high) - x_high * y_low)
    return product, rest


def square_root(x: DoubleDouble) -> DoubleDouble:
    """Square root of numbers that are not negative."""
    root = np.sqrt(x.hi)
    square, rest = two_product(root, root)
    rest = ((x.hi - square) - rest) + x.lo
    correction = np.divide(rest, 2 * root, out=np.zeros_like(root), where=root > 0)
    return DoubleDouble(*fast_two_sum(root, correction))


def concatenate(parts: Sequence[DoubleDouble], axis: int = 0) -> DoubleDouble:
    """Join arrays along an axis that they have."""
    return DoubleDouble(
        np.concatenate([part.hi for part in parts], axis=axis),
        np.concatenate([part.lo for part in parts], axis=axis),
    )


def _split(x: Floats) -> tuple[Floats, Floats]:
    """High and low half of the digits, 26 bits each (Veltkamp)."""
    scaled = _SPLITTER * x
    high = scaled - (scaled - x)
    return high, x - high
