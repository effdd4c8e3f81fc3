"""A plan: the integer operations that compute a polynomial, and what each stands for.

A step holds an integer x that stands for x 2^-fraction_bits. With operands a and b:

    kind        integer                        stands for
    input       the function's input           itself
    constant    value                          the exact constant
    add         a + b                          a + b            both in the step's format
    subtract    a - b                          a - b            likewise
    negate      -a                             -a
    view        a                              a 2^shift        only the format changes
    left        a 2^shift                      a
    right       floor((a + value) / 2^shift)   a
    low         a b                            a b              the product fits 32 bits
    word        floor(a b / 2^16)              a b              b fits 16 bits
    high        floor(a b / 2^32)              a b

Every integer fits 32 bits. "Stands for" is exact: what an integer lacks of it is that step's
rounding, which the proof adds up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

from ccgen.polynomial.enclosures import Enclosure, Ends
from ccgen.polynomial.intervals import ZERO, Interval, power_of_two
from ccgen.polynomial.specification import Variable

PRODUCTS = {"low": 0, "word": 16, "high": 32}
"""Kinds of products, and how many bits each drops."""

Number = TypeVar("Number", Interval, Enclosure)


@dataclass(frozen=True)
class Step:
    """One operation; see the module.

    Attributes:
        kind: what it does.
        operands: numbers of steps before it.
        fraction_bits: of its result.
        shift: of "left" and "right"; of "view" the exponent that the value is multiplied by.
        value: of a constant; of "right" what is added first.
        exact: what a constant stands for.
    """

    kind: str
    operands: tuple[int, ...]
    fraction_bits: int
    shift: int = 0
    value: int = 0
    exact: Fraction = field(default=Fraction(0), hash=False)  # which takes long to hash

    def meant(self, operands: Sequence[Number]) -> Number:
        """What a step that has operands stands for, given what those stand for."""
        if self.kind == "add":
            return operands[0] + operands[1]
        if self.kind == "subtract":
            return operands[0] - operands[1]
        if self.kind == "negate":
            return -operands[0]
        if self.kind == "view":
            return operands[0].times_power(self.shift)
        if self.kind in PRODUCTS:
            if self.operands[0] == self.operands[1]:
                return operands[0].squared()
            return operands[0] * operands[1]
        return operands[0]

    @cached_property
    def rounding(self) -> Interval:
        """What the step's integer stands for, less what it should from its operands."""
        unit = power_of_two(-self.fraction_bits)
        if self.kind == "constant":
            return Interval.of(self.value * unit - self.exact)
        if self.kind in PRODUCTS:
            return Interval.of(_floor_error(PRODUCTS[self.kind]) * unit, 0)
        if self.kind == "right":
            added = self.value * unit / power_of_two(self.shift)
            return Interval.of(added + _floor_error(self.shift) * unit, added)
        return ZERO

    def integers(self, operands: Sequence[Ends]) -> Ends:
        """Least and greatest integer, given those of its operands."""
        if self.kind == "constant":
            return self.value, self.value
        low, high = operands[0]
        if self.kind == "add":
            return low + operands[1][0], high + operands[1][1]
        if self.kind == "subtract":
            return low - operands[1][1], high - operands[1][0]
        if self.kind == "negate":
            return -high, -low
        if self.kind == "left":
            return low << self.shift, high << self.shift
        if self.kind == "right":
            return (low + self.value) >> self.shift, (high + self.value) >> self.shift
        if self.kind in PRODUCTS:
            ends = [x * y for x in operands[0] for y in operands[1]]
            least = 0 if self.operands[0] == self.operands[1] and low < 0 < high else min(ends)
            return least >> PRODUCTS[self.kind], max(ends) >> PRODUCTS[self.kind]
        return low, high


def _floor_error(dropped: int) -> Fraction:
    """Largest loss, in units of the result, of dropping so many bits."""
    return power_of_two(-dropped) - 1


@dataclass(frozen=True)
class Plan:
    """All steps, inputs first, and where the outputs are.

    Attributes:
        inputs: elements of the inputs, as the first steps.
        steps: operations in order.
        outputs: elements of the outputs with the step that each is.
    """

    inputs: tuple[Variable, ...]
    steps: tuple[Step, ...]
    outputs: tuple[tuple[Variable, int], ...]
