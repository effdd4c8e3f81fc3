"""Mean square error of whole populations of placements, from the shapes' second moment alone.

With bends x of an axis of second moment C, lengths over the radius y = H x + e, where a row of H is
1 within a sensor's span, and errors of covariance R, the noise-aware estimate leaves the covariance

    P = C - C H' S^-1 H C,    S = H C H' + R,

and the objective is sqrt(sum over axes of tr(D P)). D weighs directions of error: the identity for
the angles of segments, the mean of J' J for a tip whose Jacobian is J. Both S and H C D C H' are
made of entries that belong to pairs of spans, which are sums over rectangles of C and of C D C.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ccgen.placement.objective import Floats, Indices

_DEPENDENT = 1e-12
"""A length adds nothing if less than this share of its variance is independent of the others."""

_AT_ONCE = 4096


@dataclass(frozen=True, eq=False)
class AxisMoments:
    """What the error of one axis depends on.

    Attributes:
        moment: prefix sums of C along both dimensions, shape (m + 1, m + 1), radians squared.
        judged: the same of C D C.
        total: tr(D C).
        variance: of a length over the radius, radians squared.
        tolerance: variance of the gains, share squared.
    """

    moment: Floats
    judged: Floats
    total: float
    variance: float
    tolerance: float

    @classmethod
    def of(cls, C: Floats, D: Floats, deviation: float, tolerance: float) -> "AxisMoments":
        """From C and D, shape (m, m), and deviations of noise, radians, and gains."""
        total = float(np.sum(D * C))
        return cls(_prefix(C), _prefix(C @ D @ C), total, deviation**2, tolerance**2)

    def own(self, spans: Indices) -> tuple[Floats, Floats]:
        """Variances of single lengths, and what they have of C D C, shapes (S,)."""
        clean = _between(self.moment, spans, spans)
        noisy = clean * (1.0 + self.tolerance) + self.variance
        return noisy + _DEPENDENT * clean, _between(self.judged, spans, spans)

    def pairs(self, left: Indices, right: Indices) -> tuple[Floats, Floats]:
        """Entries of H C H' and H C D C H' for spans that broadcast, (..., 2) each."""
        return _between(self.moment, left, right), _between(self.judged, left, right)

    def matrices(self, spans: Indices) -> tuple[Floats, Floats]:
        """S and H C D C H' of placements, shape (..., n, 2); shapes (..., n, n)."""
        S, N = self.pairs(spans[..., :, None, :], spans[..., None, :, :])
        diagonal = np.arange(spans.shape[-2])
        S[..., diagonal, diagonal] = self.own(spans)[0]
        return S, N


@dataclass(frozen=True, eq=False)
class MomentModel:
    """Root mean square error of placements, in %.

    Attributes:
        axes: those that have the same spans.
        unit: what counts as 1.
    """

    axes: Sequence[AxisMoments]
    unit: float

    def values(self, spans: Indices) -> Floats:
        """Objective of each placement in %, shape (P,), for spans of shape (P, n, 2)."""
        parts = [self._values(spans[k : k + _AT_ONCE]) for k in range(0, len(spans), _AT_ONCE)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def moved_values(self, others: Indices, catalogue: Indices, slot: int) -> Floats:
        """Objective for each span of a catalogue beside other sensors, shape (S,), in %.

        One more length takes away its own share of what the others leave (Schur complement).

        Args:
            others: shape (n - 1, 2).
            catalogue: shape (S, 2).
            slot: of no account here.
        """
        left = np.zeros(len(catalogue))
        for axis in self.axes:
            S, N = axis.matrices(others)
            inverse = _inverse(S)
            s, n = axis.pairs(catalogue[:, None, :], others[None])
            variance, judged = axis.own(catalogue)
            told = s @ inverse
            alone = variance - np.sum(told * s, axis=1)
            gain = judged - 2.0 * np.sum(told * n, axis=1) + np.sum((told @ N) * told, axis=1)
            kept = alone > _DEPENDENT * variance
            added = np.divide(gain, alone, out=np.zeros_like(gain), where=kept)
            left += axis.total - np.sum(inverse * N) - np.maximum(added, 0.0)
        return self._percent(left)

    def _values(self, spans: Indices) -> Floats:
        left = np.zeros(len(spans))
        for axis in self.axes:
            S, N = axis.matrices(spans)
            left += axis.total - np.trace(_solved(S, N), axis1=-2, axis2=-1)
        return self._percent(left)

    def _percent(self, left: Floats) -> Floats:
        return np.asarray(100.0 * np.sqrt(np.maximum(left, 0.0)) / self.unit)


def _solved(S: Floats, N: Floats) -> Floats:
    """S^-1 N; where sensors tell the same, to the last bit, what they tell together counts once."""
    try:
        return np.asarray(np.linalg.solve(S, N))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(S, hermitian=True) @ N)


def _inverse(S: Floats) -> Floats:
    return _solved(S, np.broadcast_to(np.eye(S.shape[-1]), S.shape))


def _prefix(matrix: Floats) -> Floats:
    sums = np.zeros((len(matrix) + 1, len(matrix) + 1))
    np.cumsum(np.cumsum(matrix, axis=0), axis=1, out=sums[1:, 1:])
    return sums


def _between(sums: Floats, rows: Indices, columns: Indices) -> Floats:
    """Sums over rectangles of spans, from prefix sums."""
    top, bottom = rows[..., 0], rows[..., 1] + 1
    left, right = columns[..., 0], columns[..., 1] + 1
    found: Floats = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    return found
