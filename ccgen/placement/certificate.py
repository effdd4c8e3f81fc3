"""How far the soft-L1 loss can move an objective that was computed with squares.

Let c be the coordinates of an estimate in the orthonormal readings Q, and c0 their least-squares
value, with residuals r. The soft-L1 loss has the gradient g = Q^T (r s), s = 1/sqrt(1 + (r/f)^2),
at c0, which is Q^T (r (s - 1)) because Q^T r = 0, and curvature of at least
mu(d) = (1 + (rho/f)^2)^(-3/2) within a distance d, where rho bounds the residuals there. Where
d mu(d) >= |g| the loss rises outwards on the whole sphere, so its minimum lies inside, and then
within |g| / mu(d). The estimate of a score shape with coordinates z moves by at most |z| times
that distance.
"""

import numpy as np

from ccgen.estimation.wam import F_SCALE
from ccgen.placement.objective import (
    Floats,
    Indices,
    ObjectiveModel,
    distinct_shapes,
    orthonormalise,
    with_shapes,
)
from ccgen.placement.problem import Problem

_CACHED = 1 << 17


class Certificate:
    """Proven lower bounds of `Problem.percents`, for the paper's objective."""

    def __init__(self, problem: Problem) -> None:
        shapes, counts = distinct_shapes(problem.fit.angles, scalable=False)
        kept = shapes.any(axis=1)
        self._roots: Floats = np.sqrt(counts[kept])[:, None]
        # Weighted so, the samples themselves are coordinates with the same inner products.
        self._model: ObjectiveModel = with_shapes(problem.model, self._roots * shapes[kept])

    def lower_bounds(self, spans: Indices) -> Floats:
        """Bounds in % of the range of motion, shape (P,), of placements of shape (P, n, 2).

        A bound may be negative; where the argument does not hold it is minus infinity.
        """
        chunk = max(1, _CACHED // self._model.shapes.size)
        parts = [self._bounds(spans[k : k + chunk]) for k in range(0, len(spans), chunk)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _bounds(self, spans: Indices) -> Floats:
        model = self._model
        vectors = model.vectors(spans, np.arange(spans.shape[1]), spans.shape[1])
        orthonormalise(vectors, model.rank)
        samples, scored = vectors[..., : model.rank], vectors[..., model.rank :]
        fitted = samples @ model.shapes
        residuals = model.shapes - np.swapaxes(samples, 1, 2) @ fitted
        errors = np.swapaxes(scored, 1, 2) @ fitted - model.score_shapes
        reach = np.linalg.norm(scored, axis=1) @ model.score_weights
        moved = self._distances(samples, residuals).sum(axis=-1)
        lower: Floats = model.total(errors, None) - reach * moved
        return lower

    def _distances(self, samples: Floats, residuals: Floats) -> Floats:
        """Largest distance of the soft-L1 minimum from least squares, shape (P, m), radians.

        Args:
            samples: Q^T, shape (P, n, N).
            residuals: weighted by the roots of the counts, shape (P, N, m), radians.
        """
        ratios = np.square(residuals / (self._roots * F_SCALE))
        largest = np.sqrt(ratios.max(axis=1))
        ratios += 1.0
        pull = 1.0 / np.sqrt(ratios) - 1.0
        gradient = np.linalg.norm(samples @ (residuals * pull), axis=1)
        leverage = (np.linalg.norm(samples, axis=1) / self._roots[:, 0]).max(axis=1)[:, None]
        radius = 2.0 * gradient * (1.0 + largest**2) ** 1.5
        curvature = (1.0 + (largest + leverage * radius / F_SCALE) ** 2) ** -1.5
        inside = radius * curvature >= gradient
        return np.where(inside, gradient / curvature, np.inf)
