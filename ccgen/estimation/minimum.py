"""The minimum of the soft-L1 loss in double-double precision: weights that no rounding moves.

Every step is arithmetic that is the same on every machine (`ccgen.double_double`): Newton's
descent in double precision from the least-squares solution, then steps with the gradient in twice
the precision. The coordinates that the loss is minimised in are orthonormal, and the weights follow
from them through a triangle that was made in twice the precision too, so that nearly dependent
readings leave the weights' last digits in place.
"""

import numpy as np

from ccgen.double_double import (
    DoubleDouble,
    OrthonormalBasis,
    matmul,
    reproducible_matmul,
    square_root,
)
from ccgen.estimation.soft_l1 import Bases, descend
from ccgen.estimation.weights import Floats

_STEPS = 12
"""Each gains ten digits and more; many outliers leave fewer."""

_SETTLED = 2.0**-98
"""Share of the largest coordinate below which a step is rounding."""


def minimum(readings: DoubleDouble, targets: Floats, f_scale: float) -> Floats:
    """Weights of least soft-L1 loss of readings @ weights - target, the nearest doubles.

    Of several minima, because readings depend on each other to rounding, the smallest.

    Args:
        readings: shape (N samples, n sensors).
        targets: shape (N, m segments).
        f_scale: residual at which the loss turns from quadratic to linear, in the targets' unit.

    Returns:
        Shape (m, n).

    Raises:
        InputError: no convergence, because gross outliers outnumber the other samples.
    """
    basis = OrthonormalBasis.of(readings)
    vectors = basis.vectors
    if not vectors.shape[1]:
        return np.zeros((targets.shape[1], readings.shape[1]))
    bases = Bases(vectors.hi[None], np.ones((1, vectors.shape[1]), bool), reproducible_matmul)
    coordinates = DoubleDouble.of(descend(bases, targets.T, f_scale)[0].T)
    for _ in range(_STEPS):
        residuals = matmul(vectors, coordinates) - targets
        ratios = residuals / f_scale
        roots = square_root(1 + ratios * ratios)
        gradient = matmul(vectors.T, residuals / roots)
        step = bases.step((1 / roots.hi**3).T[None], gradient.hi.T[None])[0].T
        coordinates = coordinates - step
        if np.abs(step).max() <= _SETTLED * np.abs(coordinates.hi).max():
            break
    return basis.solution(coordinates).T
