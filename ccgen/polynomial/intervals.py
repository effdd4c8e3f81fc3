"""Intervals with ends in binary fixed point, rounded outward: what they enclose is proven."""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

POINT = 160
"""Binary digits behind the point of an end."""


@dataclass(slots=True)  # not frozen, which would make each of very many three times as slow
class Interval:
    """All numbers from low to high, in units of 2^-POINT."""

    low: int
    high: int

    @classmethod
    def of(cls, low: Fraction | int, high: Fraction | int | None = None) -> "Interval":
        """The smallest interval that holds two numbers, or one, and all between."""
        high = low if high is None else high
        return cls(_floor(low), -_floor(-high))

    def __add__(self, other: "Interval") -> "Interval":
        return Interval(self.low + other.low, self.high + other.high)

    def __sub__(self, other: "Interval") -> "Interval":
        return Interval(self.low - other.high, self.high - other.low)

    def __neg__(self) -> "Interval":
        return Interval(-self.high, -self.low)

    def __mul__(self, other: "Interval") -> "Interval":
        a, b, c, d = self.low, self.high, other.low, other.high
        # By signs, most products of intervals need two products of their ends.
        if a >= 0:
            low, high = (a if c >= 0 else b) * c, (b if d >= 0 else a) * d
        elif b <= 0:
            low, high = (a if d >= 0 else b) * d, (b if c >= 0 else a) * c
        elif c >= 0:
            low, high = a * d, b * d
        elif d <= 0:
            low, high = b * c, a * c
        else:
            low, high = min(a * d, b * c), max(a * c, b * d)
        return Interval(low >> POINT, -(-high >> POINT))

    def squared(self) -> "Interval":
        """The squares of all numbers; narrower than the product with itself."""
        product = self * self
        return Interval(0, product.high) if self.low < 0 < self.high else product

    def times_power(self, exponent: int) -> "Interval":
        """All numbers times 2^exponent."""
        if exponent >= 0:
            return Interval(self.low << exponent, self.high << exponent)
        return Interval(self.low >> -exponent, -(-self.high >> -exponent))

    def within(self, other: "Interval") -> "Interval":
        """What lies in both, which must have a number in common."""
        return Interval(max(self.low, other.low), min(self.high, other.high))

    @property
    def magnitude(self) -> Fraction:
        """Largest absolute value."""
        return Fraction(max(abs(self.low), abs(self.high)), 1 << POINT)

    @property
    def ends(self) -> tuple[Fraction, Fraction]:
        """Both ends as rationals."""
        return Fraction(self.low, 1 << POINT), Fraction(self.high, 1 << POINT)

    def steps(self, fraction_bits: int) -> tuple[int, int]:
        """The least and the greatest integer x for which x 2^-fraction_bits may lie within."""
        shift = POINT - fraction_bits
        if shift < 0:
            return self.low << -shift, self.high << -shift
        return -(-self.low >> shift), self.high >> shift


def hull(intervals: Iterable[Interval]) -> Interval:
    """The smallest interval that holds all of some."""
    some = list(intervals)
    return Interval(min(one.low for one in some), max(one.high for one in some))


def power_of_two(exponent: int) -> Fraction:
    """2^exponent as a rational."""
    return Fraction(1 << exponent) if exponent >= 0 else Fraction(1, 1 << -exponent)


def _floor(value: Fraction | int) -> int:
    return (value.numerator << POINT) // value.denominator


ZERO = Interval(0, 0)
ONE = Interval.of(1)
