"""Arithmetic with twice the precision of a double, the same bits on every processor.

Only additions, subtractions, multiplications, divisions and square roots of single array elements
decide a result: IEEE 754 rounds each of them correctly, whatever the vector unit. Where a matrix
product is left to the BLAS, its operands are cut so that no order of summation rounds.
"""

from ccgen.double_double.functions import sine_and_versine
from ccgen.double_double.least_squares import OrthonormalBasis, least_squares
from ccgen.double_double.numbers import DoubleDouble, concatenate, square_root
from ccgen.double_double.products import matmul, reproducible_matmul

__all__ = [
    "DoubleDouble",
    "OrthonormalBasis",
    "concatenate",
    "least_squares",
    "matmul",
    "reproducible_matmul",
    "sine_and_versine",
    "square_root",
]
