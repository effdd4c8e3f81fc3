"""Linear regression with the soft-L1 loss, solved to its minimum for many problems at once.

The loss of a residual r is f^2 (sqrt(1 + (r / f)^2) - 1): r^2 / 2 for small residuals, f |r| for
outliers. It is the `loss="soft_l1", f_scale=f` of `scipy.optimize.least_squares`, whose
trust-region search stops on absolute tolerances that small residuals meet long before the
minimum. The sum over linear residuals is convex, so the minimum is unique in the row space of the
readings, and Newton's method in an orthonormal basis finds it to rounding in a few steps.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.estimation.weights import Floats

MAX_STEPS = 500
SHARES = tuple(0.25**k for k in range(1, 7))
"""Shares of a Newton step to try where the whole step overshoots."""
CHUNK = 1 << 17
"""Residuals worked on at once: few enough to stay in the processor's cache."""
EPS = float(np.finfo(np.float64).eps)
_ROUNDING = 4.0
"""Units of rounding that a step is at least."""

Product = Callable[[Floats, Floats], Floats]

Scale = float | Floats
"""One for all samples, or one for each of N."""


def soft_l1(residuals: Floats, f_scale: Scale) -> Floats:
    """Sum of the loss over the last dimension, in the residuals' unit squared.

    Args:
        residuals: shape (..., N).
        f_scale: residual at which the loss turns from quadratic to linear, same unit; a number, or
            one a sample.

    Returns:
        Shape (...), equal to the `cost` of `least_squares`.
    """
    total: Floats = _losses(residuals, f_scale).sum(axis=-1)
    return total


def minimise(readings: Floats, targets: Floats, f_scale: Scale) -> Floats:
    """Weights that minimise the soft-L1 loss of readings @ weights - target, per target.

    Directions of the readings whose singular value is below rounding (N eps of the largest) get
    no weight: among equally good minima this is the one of smallest norm.

    Args:
        readings: shape (*stack, N samples, n sensors).
        targets: shape (N, m segments), the same for the whole stack.
        f_scale: unit of the targets; a number, or one a sample. A sample of weight w is one whose
            readings, targets and scale are multiplied by the root of w.

    Returns:
        Shape (*stack, m, n).

    Raises:
        InputError: no convergence, because gross outliers outnumber the other samples.
    """
    samples, sensors = readings.shape[-2:]
    stack = readings.reshape(-1, samples, sensors)
    chunk = max(1, CHUNK // targets.size)
    weights = [
        _minimise_chunk(stack[k : k + chunk], targets.T, f_scale)
        for k in range(0, len(stack), chunk)
    ]
    return np.concatenate(weights).reshape(*readings.shape[:-2], targets.shape[1], sensors)


def _minimise_chunk(readings: Floats, targets: Floats, f_scale: Scale) -> Floats:
    """Weights, shape (B, m, n), for readings (B, N, n) and targets (m, N)."""
    left, singular, right = np.linalg.svd(readings, full_matrices=False)
    kept = singular > singular[:, :1] * readings.shape[1] * EPS
    bases = Bases(np.where(kept[:, None, :], left, 0.0), kept)
    coordinates = descend(bases, targets, f_scale)
    inverse = np.divide(1.0, singular, out=np.zeros_like(singular), where=kept)
    weights: Floats = (coordinates * inverse[:, None, :]) @ right
    return weights


class Bases:
    """Orthonormal bases of B readings' column spaces, and what every step needs of them."""

    def __init__(
        self, vectors: Floats, kept: NDArray[np.bool_], product: Product = np.matmul
    ) -> None:
        """Take vectors, shape (B, N, k), zero where `kept`, shape (B, k), is false.

        Every sum of more than a few terms goes through `product`, a product of matrices.
        """
        self.vectors = vectors
        self.kept = kept
        self.product = product
        problems, samples, k = vectors.shape
        self.squares = (vectors[..., :, None] * vectors[..., None, :]).reshape(
            problems, samples, k * k
        )

    def __getitem__(self, some: NDArray[np.bool_]) -> "Bases":
        return Bases(self.vectors[some], self.kept[some], self.product)

    def residuals(self, at: Floats, targets: Floats) -> Floats:
        """Residuals, shape (B, m, N), at coordinates of shape (B, m, k)."""
        return self.product(at, np.swapaxes(self.vectors, 1, 2)) - targets

    def loss(self, residuals: Floats, f_scale: Scale) -> Floats:
        """Soft-L1 loss, shape (B, m), of residuals of shape (B, m, N)."""
        return self.product(_losses(residuals, f_scale), np.ones((residuals.shape[-1], 1)))[..., 0]

    def along(self, pulls: Floats) -> Floats:
        """Components of vectors of shape (B, m, N), shape (B, m, k)."""
        return self.product(pulls, self.vectors)

    def step(self, curvature: Floats, gradient: Floats) -> Floats:
        """Solve the weighted normal equations, shape (B, m, k).

        Dropped directions have a zero gradient; a unit diagonal keeps them where they are. For
        the others rounding size suffices: it keeps the system regular when outliers empty a
        direction.
        """
        k = self.kept.shape[1]
        diagonal = np.where(self.kept, EPS, 1.0)[:, None, :, None] * np.eye(k)
        hessian = self.product(curvature, self.squares).reshape(*gradient.shape, k) + diagonal
        return _solve(hessian, gradient)


def _losses(residuals: Floats, f_scale: Scale) -> Floats:
    z = np.square(residuals / f_scale)
    # sqrt(1 + z) - 1 without the cancellation that would eat small residuals.
    losses: Floats = f_scale**2 * (z / (np.sqrt(1.0 + z) + 1.0))
    return losses


def _row_sums(values: Floats) -> Floats:
    """Sums over the last dimension, term after term."""
    sums: Floats = np.cumsum(values, axis=-1)[..., -1]
    return sums


def _solve(matrices: Floats, wanted: Floats) -> Floats:
    """Solve positive definite systems, shapes (..., k, k) and (..., k), by elimination in order."""
    rows = np.concatenate([matrices, wanted[..., None]], axis=-1)
    k = wanted.shape[-1]
    for j in range(k):
        rows[..., j, :] /= rows[..., j, j, None]
        rows[..., j + 1 :, :] -= rows[..., j + 1 :, j, None] * rows[..., j, None, :]
    solved = rows[..., k]
    for j in reversed(range(k)):
        solved[..., :j] -= rows[..., :j, j] * solved[..., j, None]
    return solved


def descend(bases: Bases, targets: Floats, f_scale: Scale) -> Floats:
    """Coordinates of the minimum, shape (B, m, k), from the least-squares solution on.

    Args:
        bases: of B problems.
        targets: shape (m, N).
        f_scale: unit of the targets.

    Raises:
        InputError: no convergence.
    """
    at = bases.along(np.broadcast_to(targets, (len(bases.vectors), *targets.shape)))
    pending = np.arange(len(at))
    for _ in range(MAX_STEPS):
        at[pending], moved = _improve(bases, at[pending], targets, f_scale)
        if not moved.any():
            return at
        if not moved.all():
            pending, bases = pending[moved], bases[moved]
    raise InputError(
        f"the robust fit did not settle in {MAX_STEPS} steps; remove the gross outliers, which "
        "outweigh the rest of the samples"
    )


def _improve(
    bases: Bases, at: Floats, targets: Floats, f_scale: Scale
) -> tuple[Floats, NDArray[np.bool_]]:
    """One step for each problem, and which of the B problems still move.

    Newton's step converges quadratically near the minimum but may overshoot among outliers; where
    it lowers the loss by less than half of its promise, shares of it compete with the reweighted
    least-squares step, which majorises the loss and so never raises it. A problem rests once
    Newton promises less than rounding, or moves by no more, or nothing lowers its loss.
    """
    residuals = bases.residuals(at, targets)
    loss = bases.loss(residuals, f_scale)
    reweight = 1.0 / np.sqrt(1.0 + np.square(residuals / f_scale))
    gradient = bases.along(residuals * reweight)
    step = bases.step(reweight**3, gradient)
    promise = 0.5 * _row_sums(gradient * step)
    samples = residuals.shape[-1]
    # Coordinates are projections of the targets: smaller steps are what rounding leaves of them.
    rounding = _ROUNDING * EPS * np.sqrt(samples) * np.abs(targets).max(axis=1)
    moving = (promise > samples * EPS * loss) & (np.abs(step).max(axis=-1) > rounding)
    whole = at - step
    # Where a step gains less than rounding, it still brings the coordinates to their last digits.
    kept = np.where(moving[..., None], at, whole)
    if not moving.any():
        return kept, moving.any(axis=1)
    best, lowest = _lowest(bases, [whole], targets, f_scale)
    short = (moving & (lowest > loss - 0.5 * promise)).any(axis=1)
    if short.any():
        some, start = bases[short], at[short]
        tries = [best[short], start - some.step(reweight[short], gradient[short])]
        tries += [start - step[short] * share for share in SHARES]
        best[short], lowest[short] = _lowest(some, tries, targets, f_scale)
    moving &= lowest < loss
    return np.where(moving[..., None], best, kept), moving.any(axis=1)


def _lowest(
    bases: Bases, tries: list[Floats], targets: Floats, f_scale: Scale
) -> tuple[Floats, Floats]:
    """Of several coordinates, for each problem those of the lowest loss, and that loss."""
    best = tries[0]
    lowest = bases.loss(bases.residuals(best, targets), f_scale)
    for other in tries[1:]:
        loss = bases.loss(bases.residuals(other, targets), f_scale)
        best = np.where((loss < lowest)[..., None], other, best)
        lowest = np.minimum(loss, lowest)
    return best, lowest
