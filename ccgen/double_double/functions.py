"""Sine and cosine in double-double precision.

    sin(2 x) = 2 sin(x) (1 - v(x))      v(2 x) = 2 sin(x)^2      with v(x) = 1 - cos(x)

carry both from an angle so small that their Taylor series need few terms to the angle asked for;
neither cancels, so each doubling costs a rounding or two.
"""

import math

import numpy as np

from ccgen.double_double.numbers import DoubleDouble

_DOUBLINGS = 5
_LARGEST = 8.0
"""Angles up to which the series is good to the last bit, radians: 1/4 before the doublings."""

_TERMS = 12
"""The first one left out is below 1e-41 of the sum."""


def sine_and_versine(angle: DoubleDouble) -> tuple[DoubleDouble, DoubleDouble]:
    """Sine, and one minus the cosine, with errors of about 1e-31 of themselves.

    Args:
        angle: any shape, at most 8 radians either way.

    Raises:
        ValueError: an angle beyond.
    """
    if np.abs(angle.hi).max(initial=0.0) > _LARGEST:
        raise ValueError(f"an angle beyond {_LARGEST:g} radians")
    x = angle * 2.0**-_DOUBLINGS
    square = x * x
    sine = x * _series(1, square)
    versine = square * _series(2, square)
    for _ in range(_DOUBLINGS):
        sine, versine = 2 * sine * (1 - versine), 2 * sine * sine
    return sine, versine


def _series(first: int, square: DoubleDouble) -> DoubleDouble:
    """Sum over k of (-square)^k / (2 k + first)!, by Horner's rule."""
    total = DoubleDouble.of(np.zeros(square.shape))
    for k in reversed(range(_TERMS)):
        total = _reciprocal(math.factorial(2 * k + first)) - square * total
    return total


def _reciprocal(whole: int) -> DoubleDouble:
    """1 / n of an integer of at most 106 bits."""
    high = float(whole)
    return 1.0 / DoubleDouble(np.array(high), np.array(float(whole - int(high))))
