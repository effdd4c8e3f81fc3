"""Objective of whole populations of placements at once (eq. 11), without an optimiser.

The weights of a placement are taken to minimise a sum of squares over the fit library, which the
soft-L1 loss nearly is: with heuristic overlap on the paper's 80 joints it moves the objective by
less than 0.03 % for four sensors and more, by up to 0.6 % for three (median 0.0003 %) and up to
0.9 % for two, 19 % on joints beyond the fold. `ccgen.placement.certificate` bounds the
difference, and `ccgen.placement.compare` settles what it leaves open.

Such a fit depends on the library only through its inner products, so the shapes are replaced by
their few coordinates in an orthonormal basis (singular value decomposition, exact to rounding).
Shapes that are multiples of each other have errors that are multiples of each other, so the score
keeps one of them.

A sensor is a vector: its readings of the fit shapes, then its readings of the score shapes. With
the sensors' vectors made orthonormal in the fit coordinates, by Gram-Schmidt steps that carry the
score coordinates along, the fitted estimate of the score shapes Y from the fit shapes X is

    Y ~ Z Q^T X,    Q: fit coordinates, Z: score coordinates of the orthonormal vectors.

Neither normal equations nor weights appear, and nearly dependent readings do no harm.

With sensor noise the estimator is the noise-aware one. Each sensor gets one more fit coordinate,
its noise times the square root of the number of shapes; the same coordinates of Q are what the
noise does to the estimate.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation.folded import folded_mean
from ccgen.shapes import ShapeLibrary

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

DEPENDENT = 3e-14
"""A reading adds nothing if less than this share of it is independent of the others."""

_CACHED = 1 << 16
"""Numbers worked on at once: few enough to stay in the processor's cache."""

_MOVED_AT_ONCE = 1 << 15
"""The same where one sensor moves."""

_SINGULAR = 1e-15
"""Directions of the shapes below this share of the largest are rounding."""


@dataclass(frozen=True, eq=False)
class ObjectiveModel:
    """What the objective of a placement on one joint depends on.

    Attributes:
        segments: number m of segments.
        shapes: fit shapes as coordinates in an orthonormal basis, shape (r, m), radians.
        score_shapes: shape (q, m), radians.
        score_weights: how often each score shape counts, over c s m ROM / 100, shape (q,).
        sums: prefix sums along the joint of both, shape (m + 1, r + q).
        noise: noise of a sensor's length over its radius, radians; 0 for the paper's objective.
        samples: number N of fit shapes.
    """

    segments: int
    shapes: Floats
    score_shapes: Floats
    score_weights: Floats
    sums: Floats
    noise: float
    samples: int

    @property
    def rank(self) -> int:
        """Number r of coordinates that hold the fit shapes."""
        return len(self.shapes)

    def fit_size(self, sensors: int) -> int:
        """Number of leading coordinates of a vector that belong to the fit."""
        return self.rank + (sensors if self.noise else 0)

    def vectors(self, spans: Indices, slots: Indices, sensors: int) -> Floats:
        """Vectors of sensors: fit readings, noise coordinates, score readings.

        Args:
            spans: first and last segment, shape (..., 2).
            slots: number of each sensor within its placement, which broadcasts against (...).
            sensors: number n of sensors of a placement.

        Returns:
            Shape (..., d) with d = r + q, or r + n + q with noise.
        """
        first, last = spans[..., 0], spans[..., 1]
        lengths = (last - first + 1)[..., None]
        means: Floats = (self.sums[last + 1] - self.sums[first]) / lengths
        if not self.noise:
            return means
        own = np.arange(sensors) == slots[..., None]
        extra = np.sqrt(self.samples) * self.noise / lengths * own
        return np.concatenate([means[..., : self.rank], extra, means[..., self.rank :]], axis=-1)

    def values(self, spans: Indices) -> Floats:
        """Objective of each placement in % of the range of motion, shape (P,).

        Args:
            spans: shape (P, n, 2).
        """
        sensors = spans.shape[1]
        chunk = max(1, _CACHED // (self.score_shapes.size + sensors * self.sums.shape[1]))
        parts = [self._values(spans[k : k + chunk]) for k in range(0, len(spans), chunk)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _values(self, spans: Indices) -> Floats:
        sensors = spans.shape[1]
        vectors = self.vectors(spans, np.arange(sensors), sensors)
        size = self.fit_size(sensors)
        orthonormalise(vectors, size)
        fitted = vectors[..., : self.rank] @ self.shapes
        errors = np.swapaxes(vectors[..., size:], 1, 2) @ fitted
        errors -= self.score_shapes
        noise = np.swapaxes(vectors[..., self.rank : size], 1, 2) @ fitted if self.noise else None
        return self.total(errors, noise)

    def moved_values(self, others: Indices, catalogue: Indices, slot: int) -> Floats:
        """Cost of adding each span to the other sensors, shape (S,), in %.

        Args:
            others: shape (n - 1, 2).
            catalogue: spans to try, shape (S, 2).
            slot: place of the moving sensor among the n.
        """
        sensors = len(others) + 1
        size, rank = self.fit_size(sensors), self.rank
        basis = self.vectors(others, np.delete(np.arange(sensors), slot), sensors)[None]
        orthonormalise(basis, size)
        added = self.vectors(catalogue, np.array(slot), sensors)[None]
        orthogonalise(added, basis, size)
        known, new = basis[0], added[0]
        fitted = known[:, :rank] @ self.shapes
        errors = known[:, size:].T @ fitted - self.score_shapes
        noise = known[:, rank:size].T @ fitted
        gained = new[:, :rank] @ self.shapes
        values = np.empty(len(catalogue))
        chunk = max(1, _MOVED_AT_ONCE // (errors.size + noise.size))
        changed = np.empty((chunk, *errors.shape))
        for start in range(0, len(catalogue), chunk):
            part = slice(start, min(start + chunk, len(catalogue)))
            change = gained[part, None, :]
            here = np.multiply(new[part, size:, None], change, out=changed[: part.stop - start])
            here += errors
            disturbed = noise + new[part, rank:size, None] * change if self.noise else None
            values[part] = self.total(here, disturbed)
        return values

    def total(self, errors: Floats, noise: Floats | None) -> Floats:
        """Score from errors; overwrites them.

        Args:
            errors: of the score shapes, shape (P, q, m), radians.
            noise: effect of each sensor's noise, times sqrt(N), shape (P, n, m), radians.
        """
        if noise is None:
            np.abs(errors, out=errors)
        else:
            deviation = np.sqrt(np.square(noise).sum(axis=1, keepdims=True) / self.samples)
            errors = folded_mean(errors, deviation)
        weights = np.repeat(self.score_weights, self.segments)
        result: Floats = errors.reshape(len(errors), -1) @ weights
        return result


def objective_model(fit: ShapeLibrary, score: ShapeLibrary, noise: float = 0.0) -> ObjectiveModel:
    """Prepare a joint's libraries for evaluating placements.

    Args:
        fit: shapes that weights are fitted to.
        score: shapes that they are scored on.
        noise: standard deviation of a sensor's length over its radius, radians; 0 for the paper's
            objective, else the expected error of the noise-aware estimator.
    """
    shapes = _coordinates(fit.angles)
    score_shapes, counts = distinct_shapes(score.angles, scalable=not noise)
    return ObjectiveModel(
        segments=fit.angles.shape[1],
        shapes=shapes,
        score_shapes=score_shapes,
        score_weights=100.0 * counts / (score.angles.size * score.range_of_motion),
        sums=_prefix_sums(shapes, score_shapes),
        noise=noise,
        samples=len(fit.angles),
    )


def with_shapes(model: ObjectiveModel, shapes: Floats) -> ObjectiveModel:
    """The model with other coordinates of the fit shapes, shape (r, m): same inner products."""
    return replace(model, shapes=shapes, sums=_prefix_sums(shapes, model.score_shapes))


def orthonormalise(vectors: Floats, size: int) -> None:
    """Gram-Schmidt on the second-to-last dimension, in place; dependent vectors become zero.

    Each vector is projected twice, which leaves it orthogonal to rounding.

    Args:
        vectors: shape (P, n, d).
        size: number of leading coordinates that the inner product counts.
    """
    for j in range(vectors.shape[1]):
        orthogonalise(vectors[:, j : j + 1], vectors[:, :j], size)


def orthogonalise(vectors: Floats, basis: Floats, size: int) -> None:
    """Make vectors orthogonal to an orthonormal basis and of unit length, in place.

    Args:
        vectors: shape (P, S, d).
        basis: shape (P, k, d), orthonormal in the leading coordinates.
        size: number of leading coordinates that the inner product counts.
    """
    before = np.linalg.norm(vectors[..., :size], axis=-1, keepdims=True)
    if basis.shape[-2]:
        transposed = np.swapaxes(basis[..., :size], -1, -2)
        for _ in range(2):
            vectors -= (vectors[..., :size] @ transposed) @ basis
    after = np.linalg.norm(vectors[..., :size], axis=-1, keepdims=True)
    independent = after > DEPENDENT * before
    vectors *= np.divide(1.0, after, out=np.zeros_like(after), where=independent)


def distinct_shapes(angles: Floats, scalable: bool) -> tuple[Floats, Floats]:
    """One of each group of shapes whose errors are the same, and the group's total.

    Mirrored shapes have mirrored errors. If `scalable`, so have scaled ones (not with noise), and
    the total counts each by its scale.
    """
    largest = np.abs(angles).argmax(axis=1)
    peaks = angles[np.arange(len(angles)), largest]
    scales = np.abs(peaks) if scalable else np.ones(len(angles))
    signs = np.where(peaks < 0, -1.0, 1.0)
    kept = scales > 0
    forms = (angles * signs[:, None])[kept] / scales[kept, None]
    tolerance = 1e-13 * max(float(np.abs(forms).max(initial=0.0)), 1e-300)
    _, chosen, group = np.unique(
        np.round(forms / tolerance), axis=0, return_index=True, return_inverse=True
    )
    totals = np.bincount(group.ravel(), weights=scales[kept]).astype(np.float64)
    distinct: Floats = forms[chosen]
    return distinct, totals


def _prefix_sums(shapes: Floats, score_shapes: Floats) -> Floats:
    both = np.concatenate([shapes, score_shapes]).T
    sums = np.zeros((both.shape[0] + 1, both.shape[1]))
    np.cumsum(both, axis=0, out=sums[1:])
    return sums


def _coordinates(angles: Floats) -> Floats:
    """Shapes in the basis of their singular vectors, shape (r, m): same inner products."""
    _, singular, right = np.linalg.svd(angles, full_matrices=False)
    kept = singular > _SINGULAR * singular[0]
    coordinates: Floats = singular[kept, None] * right[kept]
    return coordinates
