"""Mean square error of whole populations of placements, from the shapes' second moment alone.

With states x of second moment C, lengths over the radius y = H x + e, where a row of H is what a
sensor reads of the segments within its span, and errors of covariance R, the noise-aware estimate
leaves the covariance

    P = C - C H' S^-1 H C,    S = H C H' + R,

and the objective is sqrt(sum over groups of sensors of tr(D P)). D weighs directions of error: the
identity for the angles of segments, the mean of J' J for a tip whose Jacobian is J. Where only some
rows of x are estimated, the others left at zero, the same holds with D in tr(D C), but without the
block of D between rows that are not estimated elsewhere. Both S and H C D C H' are made of entries
that belong to pairs of spans, which are sums over rectangles of what two kinds of sensors read of
two segments.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ccgen.placement.groups import Group
from ccgen.placement.objective import Floats, Indices

_DEPENDENT = 1e-12
"""A length adds nothing if less than this share of its variance is independent of the others."""

_AT_ONCE = 4096


@dataclass(frozen=True, eq=False)
class GroupMoments:
    """What the error of a group of sensors depends on, for K kinds of them.

    Attributes:
        group: the sensors.
        moment: prefix sums, along both segments, of what two kinds read of C, shape
            (K, K, m + 1, m + 1), radians squared.
        judged: the same of C D C.
        total: tr(D C).
        variance: of a length over the radius, by kind, shape (K,), radians squared.
        tolerance: variance of the gains, by kind, shape (K,), share squared.
    """

    group: Group
    moment: Floats
    judged: Floats
    total: float
    variance: Floats
    tolerance: Floats

    @classmethod
    def of(cls, group: Group, C: Floats, D: Floats) -> "GroupMoments":
        """From C and D, shape (R, R), for the group's rows."""
        total = float(np.sum(D * C))
        judged = C @ group.judged(D) @ C
        return cls(
            group,
            _prefix(group.patterns, C),
            _prefix(group.patterns, judged),
            total,
            np.square(group.deviation),
            np.square(group.tolerance),
        )

    def own(self, spans: Indices, kinds: Indices) -> tuple[Floats, Floats]:
        """Variances of single lengths, and what they have of C D C, shapes (S,)."""
        clean = _between(self.moment, spans, spans, kinds, kinds)
        noisy = clean * (1.0 + self.tolerance[kinds]) + self.variance[kinds]
        return noisy + _DEPENDENT * clean, _between(self.judged, spans, spans, kinds, kinds)

    def pairs(
        self, left: Indices, right: Indices, left_kinds: Indices, right_kinds: Indices
    ) -> tuple[Floats, Floats]:
        """Entries of H C H' and H C D C H' for spans, (..., 2), and kinds that broadcast."""
        ends = (left, right, left_kinds, right_kinds)
        return _between(self.moment, *ends), _between(self.judged, *ends)

    def matrices(self, spans: Indices, kinds: Indices) -> tuple[Floats, Floats]:
        """S and H C D C H' of placements, shape (..., n, 2); shapes (..., n, n)."""
        S, N = self.pairs(
            spans[..., :, None, :], spans[..., None, :, :], kinds[:, None], kinds[None]
        )
        diagonal = np.arange(spans.shape[-2])
        S[..., diagonal, diagonal] = self.own(spans, kinds)[0]
        return S, N

    def left(self, spans: Indices, kinds: Indices) -> Floats:
        """tr(D P) of placements, shape (..., n, 2)."""
        S, N = self.matrices(spans, kinds)
        return np.asarray(self.total - np.trace(_solved(S, N), axis1=-2, axis2=-1))

    def left_beside(
        self, others: Indices, catalogue: Indices, kinds: Indices, kind: Indices
    ) -> Floats:
        """tr(D P) with one more length, for each of its spans, shape (S,).

        It takes away its own share of what the others leave (Schur complement).

        Args:
            others: shape (n - 1, 2).
            catalogue: shape (S, 2).
            kinds: of the others.
            kind: of the one more.
        """
        S, N = self.matrices(others, kinds)
        inverse = _inverse(S)
        s, n = self.pairs(catalogue[:, None, :], others[None], kind, kinds[None])
        variance, judged = self.own(catalogue, kind)
        told = s @ inverse
        alone = variance - np.sum(told * s, axis=1)
        gain = judged - 2.0 * np.sum(told * n, axis=1) + np.sum((told @ N) * told, axis=1)
        kept = alone > _DEPENDENT * variance
        added = np.divide(gain, alone, out=np.zeros_like(gain), where=kept)
        return np.asarray(self.total - np.sum(inverse * N) - np.maximum(added, 0.0))


@dataclass(frozen=True, eq=False)
class MomentModel:
    """Root mean square error of placements, in %.

    Attributes:
        groups: sensors that are read together.
        unit: what counts as 1.
    """

    groups: Sequence[GroupMoments]
    unit: float

    def values(self, spans: Indices) -> Floats:
        """Objective of each placement in %, shape (P,), for spans of shape (P, n, 2)."""
        parts = [self._values(spans[k : k + _AT_ONCE]) for k in range(0, len(spans), _AT_ONCE)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def moved_values(self, others: Indices, catalogue: Indices, slot: int) -> Floats:
        """Objective for each span of a catalogue beside other sensors, shape (S,), in %.

        Args:
            others: shape (n - 1, 2).
            catalogue: shape (S, 2).
            slot: of the moving sensor among the n.
        """
        left = np.zeros(len(catalogue))
        everyone = np.insert(others, slot, 0, axis=0)
        for part in self.groups:
            group, kinds = part.group, part.group.kinds
            at = slot - group.slots.start
            own = everyone[group.slots]
            if 0 <= at < len(kinds):
                rest = np.delete(own, at, axis=0)
                left += part.left_beside(rest, catalogue, np.delete(kinds, at), kinds[at])
            else:
                left += part.left(own, kinds)
        return self._percent(left)

    def _values(self, spans: Indices) -> Floats:
        left = np.zeros(len(spans))
        for part in self.groups:
            left += part.left(spans[:, part.group.slots], part.group.kinds)
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


def _prefix(patterns: Floats, matrix: Floats) -> Floats:
    """Prefix sums of T_j M T_k', of patterns (K, m, R) and a matrix (R, R)."""
    kinds, segments, _ = patterns.shape
    sums = np.zeros((kinds, kinds, segments + 1, segments + 1))
    for j, left in enumerate(patterns):
        for k, right in enumerate(patterns):
            both = left @ matrix @ right.T
            np.cumsum(np.cumsum(both, axis=0), axis=1, out=sums[j, k, 1:, 1:])
    return sums


def _between(
    sums: Floats, rows: Indices, columns: Indices, left: Indices, right: Indices
) -> Floats:
    """Sums over rectangles of spans, from prefix sums of the pairs of kinds."""
    top, bottom = rows[..., 0], rows[..., 1] + 1
    start, end = columns[..., 0], columns[..., 1] + 1
    found: Floats = (
        sums[left, right, bottom, end]
        - sums[left, right, top, end]
        - sums[left, right, bottom, start]
        + sums[left, right, top, start]
    )
    return found
