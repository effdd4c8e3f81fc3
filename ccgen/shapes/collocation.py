"""Integration and interpolation at Gauss-Legendre nodes, in double-double precision.

A function on [0, 1] is held by its values at the N nodes. In Legendre polynomials P_k of
x = 2 s - 1 its coefficients are

    a_k = (2 k + 1) / 2  sum_j w_j P_k(x_j) f(x_j),    w_j = 2 / ((1 - x_j^2) P_N'(x_j)^2),

for the quadrature is exact for the products, and integrals of P_k are (P_{k+1} - P_{k-1}) / (2k+1).
Everything follows from the nodes by arithmetic that is the same on every machine; a solution of
equations that are written with these matrices is as good as they are, about 1e-29.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ccgen.double_double import DoubleDouble, concatenate, matmul

_NEWTON_STEPS = 5
"""From the asymptotic nodes, good to about 1e-5: three reach rounding, with two to spare."""

Number = TypeVar("Number", NDArray[np.float64], DoubleDouble)


@dataclass(frozen=True, eq=False)
class Collocation:
    """Matrices for N nodes.

    Attributes:
        positions: nodes s, shape (N,), rising.
        quadrature: weights of the integral over [0, 1], shape (N,).
        analysis: Legendre coefficients of nodal values, shape (N, N).
        twice_integrated: int_0^s int_t^1 f(r) dr dt at the nodes, shape (N, N).
    """

    positions: DoubleDouble
    quadrature: DoubleDouble
    analysis: DoubleDouble
    twice_integrated: DoubleDouble

    def at(self, positions: DoubleDouble) -> DoubleDouble:
        """Rows that interpolate nodal values at positions s, shape (n_positions, N)."""
        return matmul(legendre(2 * positions - 1, len(self.analysis.hi)), self.analysis)


@lru_cache(maxsize=4)
def collocation(nodes: int) -> Collocation:
    """The matrices for so many nodes."""
    x = _legendre_nodes(nodes)
    values = legendre(x, nodes + 2)
    slope = _slope(nodes, x, values[:, nodes], values[:, nodes - 1])
    weights = 2 / ((1 - x * x) * slope * slope)
    degrees = 2 * np.arange(nodes) + 1.0
    analysis = values[:, :nodes].T * weights * (degrees[:, None] / 2)
    # ds = dx / 2 in both integrals.
    outboard = _integrated(-0.5 * analysis, at_end=True)
    twice = _integrated(0.5 * outboard, at_end=False)
    return Collocation((x + 1) / 2, weights / 2, analysis, matmul(values, twice))


def legendre(x: DoubleDouble, count: int) -> DoubleDouble:
    """P_0 to P_{count - 1} at points x, shape (n_points, count), by Bonnet's recursion."""
    rising = np.arange(count, dtype=np.float64)
    ratios = DoubleDouble.of(rising) / (rising + 1)
    columns = [DoubleDouble.of(np.ones(x.shape)), x]
    for k in range(1, count - 1):
        along = x * columns[k]
        columns.append(along + (along - columns[k - 1]) * ratios[k])
    return concatenate([column[:, None] for column in columns[:count]], axis=1)


def _legendre_nodes(nodes: int) -> DoubleDouble:
    """Zeros of P_N, rising, symmetric about 0.

    Newton's steps in doubles; then one of third order (Halley's, with P'' from Legendre's equation)
    triples the digits.
    """
    numbers = np.arange(nodes // 2) + 0.75
    guess = np.cos(np.pi * numbers / (nodes + 0.5))
    for _ in range(_NEWTON_STEPS):
        values = np.polynomial.legendre.legvander(guess, nodes)
        guess = guess - values[:, -1] / _slope(nodes, guess, values[:, -1], values[:, -2])
    x = DoubleDouble.of(guess)
    exact = legendre(x, nodes + 1)
    step = exact[:, -1] / _slope(nodes, x, exact[:, -1], exact[:, -2])
    x = x - step * (1 + step * x / (1 - x * x))
    middle = [DoubleDouble.of(np.zeros(nodes % 2))]
    return concatenate([-x, *middle, x[::-1]])


def _slope(degree: int, x: Number, value: Number, before: Number) -> Number:
    """P_N'(x) from P_N(x) and P_{N-1}(x)."""
    slope: Number = degree * (before - x * value) / (1 - x * x)
    return slope


def _integrated(coefficients: DoubleDouble, at_end: bool) -> DoubleDouble:
    """Integral over x, zero at x = 1 or at x = -1, of series of shape (k, q); shape (k + 1, q)."""
    degrees = 2 * np.arange(len(coefficients.hi)) + 1.0
    shares = coefficients / degrees[:, None]
    none = DoubleDouble.of(np.zeros((1, coefficients.shape[1])))
    raised = concatenate([none, shares])
    lowered = concatenate([shares[1:], none, none])
    total = raised - lowered
    signs = np.ones(len(degrees)) if at_end else (-1.0) ** np.arange(1, len(degrees) + 1)
    constant = (total[1:] * signs[:, None]).sum(axis=0)
    return concatenate([-constant[None], total[1:]])
