"""Proofs over every count and zero in range, in exact rational arithmetic."""

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from ccgen.fixedpoint.model import Floats, Integers


def exact(values: Floats) -> list[list[Fraction]]:
    """Rationals that equal the doubles of a matrix, row by row."""
    return [[Fraction(float(x)) for x in row] for row in values]


def largest_accumulator(weights: Integers, bias: Integers, span: Integers) -> int:
    """Bound of |acc| and of every partial sum: max_i |bias_i| + sum_j |W_ij| D_j.

    Args:
        weights: shape (m, n).
        bias: shape (m,).
        span: shape (n,), D_j, the largest |count - zero|.
    """
    return max(
        abs(int(b)) + sum(abs(int(w)) * int(d) for w, d in zip(row, span, strict=True))
        for row, b in zip(weights, bias, strict=True)
    )


def weight_error(
    gains: Floats,
    intercept: Floats,
    weights: Integers,
    offsets: Sequence[int],
    scale: int,
    span: Integers,
) -> Fraction:
    """Proven bound in rad of what rounding the weights and intercepts adds.

    Args:
        gains: shape (m, n), rad per count.
        intercept: shape (m,), rad.
        weights: shape (m, n), gains times 2^scale, rounded.
        offsets: m integers, intercepts times 2^scale, rounded.
        scale: binary digits of the accumulator behind the point.
        span: shape (n,), D_j.
    """
    unit = Fraction(1, 2**scale) if scale >= 0 else Fraction(2**-scale)
    return max(
        abs(int(o) * unit - Fraction(float(c)))
        + sum(
            (abs(int(w) * unit - g) * int(d) for w, g, d in zip(row, real, span, strict=True)),
            Fraction(0),
        )
        for row, real, o, c in zip(weights, exact(gains), offsets, intercept, strict=True)
    )


def headroom_bits(largest: int, accumulator_bits: int) -> int:
    """How often |acc| may double before it leaves a signed accumulator."""
    return accumulator_bits - 1 - largest.bit_length()


def rounding_error(shift: int, fraction_bits: int) -> Fraction:
    """Bound in rad of dropping `shift` bits with the half added before: half a step."""
    return Fraction(0) if shift == 0 else Fraction(1, 2) / Fraction(2) ** fraction_bits


def rms(values: Floats) -> float:
    """Root mean square over all entries, summed without rounding."""
    return math.sqrt(math.fsum(np.square(values).flat) / values.size)
