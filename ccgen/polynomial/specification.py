"""What is asked of a compiled function: the ranges of its inputs, the errors of its outputs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

from ccgen.errors import ArgumentError

WIDTHS = (16, 32)
"""Bits that an input or output may have."""

_FRACTION_BITS = 120
"""Largest magnitude of an exponent of a Q format."""


@dataclass(frozen=True)
class Input:
    """An input: integers x that stand for x 2^-fraction_bits.

    Attributes:
        range: lowest and highest value, of all its elements or a pair for each.
        fraction_bits: of its Q format.
        bits: of its integers, 16 or 32.
        held: whether the C's caller keeps it in range, so that the C need not.
    """

    range: tuple[float, float] | Sequence[tuple[float, float]]
    fraction_bits: int
    bits: int = 16
    held: bool = False


@dataclass(frozen=True)
class Output:
    """An output.

    Attributes:
        error: largest distance to the exact polynomial that is wanted, of every element.
        fraction_bits: of its Q format; None lets the compiler choose.
        bits: of its integers, 16 or 32.
    """

    error: float
    fraction_bits: int | None = None
    bits: int = 32


@dataclass(frozen=True)
class Variable:
    """One element of an input or output, as the compiled function has it.

    Attributes:
        name: of the input or output.
        element: its place in it, column by column; None where it is a scalar.
        bits: of its integer.
        fraction_bits: of its Q format.
        low: least integer.
        high: greatest integer.
        held: of an input, as in `Input`.
    """

    name: str
    element: int | None
    bits: int
    fraction_bits: int
    low: int
    high: int
    held: bool = False


def input_variables(function: Any, inputs: Mapping[str, Input]) -> list[Variable]:
    """The elements of all inputs of a `casadi.Function`, in its order.

    Raises:
        ArgumentError: an input without range, a range or format that no integers have.
    """
    _require_names("inputs", "range", function.name_in(), inputs)
    found = []
    for index, name in enumerate(function.name_in()):
        stated, shape = inputs[name], function.size_in(index)
        ranges = _ranges(name, stated, shape[0] * shape[1])
        found += [
            _input_variable(name, None if shape == (1, 1) else element, stated, pair)
            for element, pair in enumerate(ranges)
        ]
    return found


def check_outputs(function: Any, outputs: Mapping[str, Output]) -> None:
    """Refuse outputs that ask for what no compiler could give.

    Raises:
        ArgumentError: an output without error, or of an unknown width.
    """
    _require_names("outputs", "error", function.name_out(), outputs)
    for name, wanted in outputs.items():
        if not (math.isfinite(wanted.error) and wanted.error > 0):
            raise ArgumentError(f"the error of {name} is {wanted.error:g}; above 0", "outputs")
        _check_format("outputs", name, wanted.bits, wanted.fraction_bits or 0)


def _require_names(argument: str, what: str, names: list[str], given: Mapping[str, Any]) -> None:
    for name in names:
        if name not in given:
            raise ArgumentError(f"no {what} of {name}; give one for {', '.join(names)}", argument)
    for name in given:
        if name not in names:
            raise ArgumentError(f"{name} is unknown; the function has {', '.join(names)}", argument)


def _ranges(name: str, stated: Input, elements: int) -> list[tuple[float, float]]:
    pairs: list[Any] = list(stated.range)
    if all(isinstance(end, Real) for end in pairs):
        pairs = [tuple(pairs)] * elements
    if len(pairs) != elements or any(len(pair) != 2 for pair in pairs):
        raise ArgumentError(
            f"the range of {name} is {stated.range!r}; one pair, or one for each of its "
            f"{elements} elements",
            "inputs",
        )
    return pairs


def _input_variable(
    name: str, element: int | None, stated: Input, pair: tuple[float, float]
) -> Variable:
    _check_format("inputs", name, stated.bits, stated.fraction_bits)
    first, last = pair
    if not (math.isfinite(first) and math.isfinite(last) and first <= last):
        raise ArgumentError(
            f"the range of {name} is {first:g} to {last:g}; a lower and an upper end", "inputs"
        )
    least, greatest = (math.ldexp(end, stated.fraction_bits) for end in pair)
    limit = 2 ** (stated.bits - 1)
    if math.ceil(least) < -limit or math.floor(greatest) >= limit:
        raise ArgumentError(
            f"{first:g} to {last:g} of {name} does not fit {stated.bits} bits with "
            f"{stated.fraction_bits} behind the point; use {_most(pair, limit)} or fewer",
            "inputs",
        )
    if math.ceil(least) > math.floor(greatest):
        raise ArgumentError(
            f"no number of {name}'s format lies from {first:g} to {last:g}; use more fraction bits",
            "inputs",
        )
    low, high = math.ceil(least), math.floor(greatest)
    return Variable(name, element, stated.bits, stated.fraction_bits, low, high, stated.held)


def _most(pair: tuple[float, float], limit: int) -> int:
    """Most fraction bits with which a range fits integers from -limit to below limit."""
    bits = limit.bit_length() - math.frexp(max(abs(end) for end in pair))[1]
    while math.ldexp(pair[0], bits) < -limit or math.ldexp(pair[1], bits) >= limit:
        bits -= 1
    return bits


def _check_format(argument: str, name: str, bits: int, fraction_bits: int) -> None:
    if bits not in WIDTHS:
        raise ArgumentError(f"{name} has {bits} bits; 16 or 32", argument)
    if abs(fraction_bits) > _FRACTION_BITS:
        raise ArgumentError(
            f"{name} has {fraction_bits} fraction bits; at most {_FRACTION_BITS} either way",
            argument,
        )
