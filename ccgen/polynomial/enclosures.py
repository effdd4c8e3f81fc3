"""Ranges of polynomials: intervals, narrowed by the mean value theorem.

An interval knows nothing of where it came from: x - x over 0 to 1 is -1 to 1. An enclosure also
holds the value in the middle of the inputs' ranges and the derivatives by all inputs, and with them
a second interval that holds the value; both together count. Inputs that enter with a power of two
or more are cut into pieces, each enclosed for itself.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Protocol

from ccgen.polynomial.intervals import ONE, ZERO, Interval, power_of_two
from ccgen.polynomial.specification import Variable

PIECES = 16
"""Most pieces that the inputs' ranges are cut into."""

Ends = tuple[int, int]
"""Least and greatest integer."""


class Operation(Protocol):
    """What a node of a graph and a step of a plan have in common."""

    @property
    def kind(self) -> str:
        """What it does."""

    @property
    def operands(self) -> tuple[int, ...]:
        """Numbers of the operations before it that it takes."""


@dataclass(slots=True)
class Enclosure:
    """All values of a polynomial over a piece of the inputs' ranges.

    Attributes:
        value: an interval that holds them.
        middle: holds the value in the middle of the piece.
        slopes: hold the derivatives by the inputs, without those that are 0.
        spans: of all inputs what lies between the middle and the ends; the same object for all.
    """

    value: Interval
    middle: Interval
    slopes: dict[int, Interval]
    spans: Sequence[Interval]

    def __add__(self, other: "Enclosure") -> "Enclosure":
        return self._with(
            self.value + other.value,
            self.middle + other.middle,
            _joined(self.slopes, other.slopes),
        )

    def __sub__(self, other: "Enclosure") -> "Enclosure":
        return self + -other

    def __neg__(self) -> "Enclosure":
        slopes = {k: -slope for k, slope in self.slopes.items()}
        return Enclosure(-self.value, -self.middle, slopes, self.spans)

    def __mul__(self, other: "Enclosure") -> "Enclosure":
        first = {k: slope * other.value for k, slope in self.slopes.items()}
        second = {k: self.value * slope for k, slope in other.slopes.items()}
        value, middle = self.value * other.value, self.middle * other.middle
        return self._with(value, middle, _joined(first, second))

    def squared(self) -> "Enclosure":
        """The squares."""
        slopes = {k: (self.value * slope).times_power(1) for k, slope in self.slopes.items()}
        return self._with(self.value.squared(), self.middle.squared(), slopes)

    def times_power(self, exponent: int) -> "Enclosure":
        """All values times 2^exponent."""
        slopes = {k: slope.times_power(exponent) for k, slope in self.slopes.items()}
        return Enclosure(
            self.value.times_power(exponent), self.middle.times_power(exponent), slopes, self.spans
        )

    def times(self, factor: Interval) -> "Enclosure":
        """All values times a constant that an interval holds."""
        slopes = {k: slope * factor for k, slope in self.slopes.items()}
        return self._with(self.value * factor, self.middle * factor, slopes)

    def constant(self, value: Interval) -> "Enclosure":
        """A constant over the same piece."""
        return Enclosure(value, value, {}, self.spans)

    def _with(self, value: Interval, middle: Interval, slopes: dict[int, Interval]) -> "Enclosure":
        linear = middle
        for k, slope in slopes.items():
            linear = linear + slope * self.spans[k]
        return Enclosure(value.within(linear), middle, slopes, self.spans)


def _joined(first: dict[int, Interval], second: dict[int, Interval]) -> dict[int, Interval]:
    return {k: first.get(k, ZERO) + second.get(k, ZERO) for k in first | second}


def pieces(
    inputs: Sequence[Variable], operations: Sequence[Operation], most: int
) -> Iterator[tuple[list[Ends], list[Enclosure]]]:
    """Pieces of the inputs' ranges, which together hold every input in range.

    Args:
        inputs: the inputs.
        operations: what is computed, inputs first.
        most: pieces.

    Yields:
        Least and greatest integer of every input, and the enclosures of what they stand for.
    """
    powers = _nonlinear(operations, len(inputs))
    cut = [k for k, one in enumerate(inputs) if k in powers and one.low < one.high]
    parts = max(1, int(most ** (1 / len(cut)) + 1e-9)) if cut else 1
    ranges = [_parts(one, parts if k in cut else 1) for k, one in enumerate(inputs)]
    for ends in product(*ranges):
        yield list(ends), _inputs(inputs, ends)


def _parts(variable: Variable, parts: int) -> list[Ends]:
    count = variable.high - variable.low + 1
    edges = [variable.low + count * k // parts for k in range(parts + 1)]
    return [(low, high - 1) for low, high in pairwise(edges) if low < high]


def _inputs(inputs: Sequence[Variable], ends: Sequence[Ends]) -> list[Enclosure]:
    values, middles = [], []
    for variable, (low, high) in zip(inputs, ends, strict=True):
        unit = power_of_two(-variable.fraction_bits)
        values.append(Interval.of(low * unit, high * unit))
        middles.append(Interval.of((low + high) * unit / 2))
    spans = [value - middle for value, middle in zip(values, middles, strict=True)]
    return [
        Enclosure(value, middle, {k: ONE}, spans)
        for k, (value, middle) in enumerate(zip(values, middles, strict=True))
    ]


def _nonlinear(operations: Sequence[Operation], inputs: int) -> set[int]:
    """The inputs that enter some operation with a power of two or more."""
    degrees: list[dict[int, int]] = []
    for number, one in enumerate(operations):
        if number < inputs:
            degrees.append({number: 1})
            continue
        tables = [degrees[k] for k in one.operands]
        combine = sum if one.kind in _PRODUCTS else max
        keys = {k for table in tables for k in table}
        degrees.append({k: combine([table.get(k, 0) for table in tables]) for k in keys})
    return {k for table in degrees for k, degree in table.items() if degree > 1}


_PRODUCTS = ("multiply", "low", "word", "high")
