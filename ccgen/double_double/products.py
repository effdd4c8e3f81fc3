"""Matrix products without rounding, whatever the BLAS does.

Every row of the left and every column of the right operand is cut into slices of so few bits that
a product of two slices, summed in any order, with or without fused multiply-adds, is exact in
doubles (K. Ozaki, T. Ogita, S. Oishi, S. M. Rump, "Error-free transformations of matrix
multiplication by using fast routines of matrix multiplication", Numerical Algorithms 59, 2012).
The products of slices are added in a fixed order.
"""

import numpy as np
from numpy.typing import ArrayLike

from ccgen.double_double.numbers import DoubleDouble, Floats, two_sum

_DOUBLE_BITS = 53
_ONCE, _TWICE = 54, 108
"""Bits of a double and of a double-double number, and a few."""


def matmul(left: ArrayLike | DoubleDouble, right: ArrayLike | DoubleDouble) -> DoubleDouble:
    """Product with an error of about 2^-106 of the largest terms of each sum.

    Args:
        left: shape (..., p, n).
        right: shape (..., n, q); leading dimensions broadcast.

    Returns:
        Shape (..., p, q).
    """
    parts = _partial_products(DoubleDouble.of(left), DoubleDouble.of(right), _TWICE)
    total = DoubleDouble.of(parts[0])
    for part in parts[1:]:
        total = total + part
    return total


def reproducible_matmul(left: Floats, right: Floats) -> Floats:
    """Product in double precision, the same bits on every machine; shapes as of `matmul`."""
    parts = _partial_products(DoubleDouble.of(left), DoubleDouble.of(right), _ONCE)
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def _partial_products(x: DoubleDouble, y: DoubleDouble, bits: int) -> list[Floats]:
    """Exact products of slices that add up to so many bits of the product, smallest first."""
    terms = x.shape[-1]
    width = (_DOUBLE_BITS - max(terms - 1, 0).bit_length()) // 2
    count = -(-bits // width)
    lefts, rights = _slices(x, -1, width, count), _slices(y, -2, width, count)
    return [
        np.matmul(lefts[i], rights[order - i])
        for order in reversed(range(count))
        for i in range(order + 1)
    ]


def _slices(x: DoubleDouble, axis: int, bits: int, count: int) -> list[Floats]:
    """Leading bits of all numbers along an axis, counted from the largest of them."""
    largest = np.abs(x.hi).max(axis=axis, keepdims=True, initial=0.0)
    exponent = np.frexp(largest)[1]
    rest, low = x.hi, x.lo
    slices = []
    for k in range(count):
        # Numbers of the size of this one end at the last bit of the slice.
        rounder = np.ldexp(1.5, exponent + (_DOUBLE_BITS - 1 - (k + 1) * bits))
        part = (rest + rounder) - rounder
        slices.append(part)
        rest, low = two_sum(rest - part, low)
    return slices
