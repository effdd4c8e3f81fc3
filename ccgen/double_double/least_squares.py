"""Least squares in double-double precision, by an orthonormal basis of the columns.

Columns are made orthonormal by modified Gram-Schmidt steps, the one with the most left first, and
once more, which makes them orthogonal to rounding. What is left of a column in the end, if it is
below rounding in double precision, is taken for zero. Nothing is squared: the condition number of
the columns enters once. (A. Bjorck, "Numerical methods for least squares problems", SIAM 1996,
sections 2.4 and 2.7: rank-revealing QR and complete orthogonal decomposition.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ccgen.double_double.numbers import DoubleDouble, Floats, concatenate, square_root
from ccgen.double_double.products import matmul

EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class OrthonormalBasis:
    """Orthonormal basis of the columns of a matrix A, shape (N, n).

    Attributes:
        vectors: shape (N, k), orthonormal columns that span those of A.
        back: shape (n, k); of all x with A x = vectors @ c, back @ c is the smallest.
    """

    vectors: DoubleDouble
    back: DoubleDouble

    @classmethod
    def of(cls, columns: ArrayLike | DoubleDouble) -> OrthonormalBasis:
        """Find the basis of a matrix of shape (N, n).

        A column of which less than N eps of the whole matrix (n eps if that is more) is
        independent of the others adds nothing: a matrix that is given in doubles cannot show more.
        """
        matrix = DoubleDouble.of(columns)
        once, shares = _orthonormalise(matrix, max(matrix.shape) * EPS)
        vectors, rest = _orthonormalise(once, 0.0)
        # A = vectors shares; with shares^T = rows L, the smallest x is rows L^-T c.
        shares = matmul(rest, shares)
        rows, upper = _orthonormalise(shares.T, 0.0)
        return cls(vectors, _solve_upper(upper, rows.T).T)

    def coordinates(self, targets: ArrayLike | DoubleDouble) -> DoubleDouble:
        """Coordinates, shape (k, m), of the least-squares approximation of targets, (N, m)."""
        return matmul(self.vectors.T, targets)

    def solution(self, coordinates: DoubleDouble) -> Floats:
        """Smallest x with A x = vectors @ coordinates, rounded, shape (n, m)."""
        return matmul(self.back, coordinates).hi


def least_squares(columns: ArrayLike | DoubleDouble, targets: ArrayLike | DoubleDouble) -> Floats:
    """Least-squares solution of columns @ x ~ targets; the smallest where it is not unique.

    Args:
        columns: shape (N, n).
        targets: shape (N, m).

    Returns:
        Shape (n, m).
    """
    basis = OrthonormalBasis.of(columns)
    return basis.solution(basis.coordinates(targets))


def _orthonormalise(matrix: DoubleDouble, negligible: float) -> tuple[DoubleDouble, DoubleDouble]:
    """Q, shape (N, k), and S, shape (k, n), with matrix = Q S.

    Args:
        matrix: shape (N, n).
        negligible: share of the matrix below which a column counts as zero; with 0 columns are
            taken as they come, none is left out, and S is upper triangular.
    """
    left = matrix
    limit = negligible * float(square_root((matrix * matrix).sum(axis=0).sum(axis=0)).hi)
    units, shares = [], []
    for k in range(matrix.shape[1]):
        lengths = square_root((left * left).sum(axis=0))
        most = int(np.argmax(lengths.hi)) if negligible else k
        if lengths.hi[most] <= limit:
            break
        unit = left[:, most : most + 1] / lengths[most]
        share = (unit * left).sum(axis=0)
        left = left - unit * share
        units.append(unit)
        shares.append(share[None])
    if not units:
        return DoubleDouble.of(np.zeros((len(matrix.hi), 0))), DoubleDouble.of(
            np.zeros((0, matrix.shape[1]))
        )
    return concatenate(units, axis=1), concatenate(shares)


def _solve_upper(upper: DoubleDouble, wanted: DoubleDouble) -> DoubleDouble:
    """X with upper X = wanted, by back substitution; shapes (k, k) and (k, n)."""
    rows: list[DoubleDouble] = []
    left = wanted
    for k in reversed(range(len(upper.hi))):
        row = left[k : k + 1] / upper[k, k]
        left = left[:k] - upper[:k, k : k + 1] * row
        rows.append(row)
    return concatenate(rows[::-1]) if rows else wanted
