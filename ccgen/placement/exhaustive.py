"""Every placement that keeps to the constraints, in chunks.

Free sensors are ordered by their spans (first, then last segment). The first segment that is
still bare must be covered by the next sensor, since later ones begin further out; and no later
one reaches back before it. What leaves a gap, more sensors over a segment than allowed, or too
little room for the sensors to come, is dropped as soon as it does.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ccgen.placement.objective import Indices
from ccgen.placement.question import Question
from ccgen.placement.slots import coverage

_CHUNK = 1 << 16

_EFFORT = 16
"""Partial placements looked at for each placement of the limit, before counting gives up."""


def count_allowed(problem: Question, limit: float = math.inf) -> int | None:
    """Number of placements that keep to the constraints.

    Returns:
        The number, or None where there are more than the limit, or where a limit on stacked
        sensors makes it take too long to tell.
    """
    if not _may_stack(problem):
        return _count_covering(problem, limit)
    walk = Walk(problem, _EFFORT * limit)
    count = 0
    for chunk in walk.chunks():
        count += len(chunk)
        if count > limit:
            return None
    return count if walk.complete else None


def covering(problem: Question) -> Iterator[Indices]:
    """Chunks of all placements that keep to the constraints, fixed sensors first, (P, n, 2)."""
    return Walk(problem).chunks()


def _may_stack(problem: Question) -> bool:
    """Whether the limit on stacked sensors rules anything out."""
    stacked = problem.constraints.stacked
    return stacked is not None and stacked < problem.sensors


def _count_covering(problem: Question, limit: float) -> int | None:
    """Number of placements without a bare segment; None where it exceeds the limit."""
    bare = _next_bare(problem)
    first, last = problem.catalogue.T
    free = problem.sensors - len(problem.constraints.fixed)
    segments = problem.segments
    # ways[i, r]: partial placements that end with span i and reach to segment r - 1. Counts stay
    # exact in floats up to 2^53.
    ways = np.zeros((max(1, len(first)), segments + 1))
    ways[0, 0] = 1
    for _ in range(free):
        upto = np.cumsum(ways, axis=0)
        ways = np.zeros_like(ways)
        for i, (a, b) in enumerate(zip(first, last, strict=True)):
            growing = np.where(bare >= a, upto[i], 0.0)
            ways[i, b + 1] = growing[: b + 2].sum()
            ways[i, b + 2 :] = growing[b + 2 :]
        # Each of these leads to one more at least, by the same span once more.
        if ways[:, bare == segments].sum() > limit:
            return None
    count = ways[:, bare == segments].sum()
    return int(count) if count <= limit else None


@dataclass
class Walk:
    """Goes through the placements of a problem, depth first.

    Attributes:
        problem: the joint, its sensors and constraints.
        effort: most partial placements to look at.
        complete: whether every placement was met; known when the chunks have ended.
    """

    problem: Question
    effort: float = math.inf
    complete: bool = True
    _tried: int = 0
    _bare: Indices = field(init=False)
    _fewest: Indices = field(init=False)
    _covers: NDArray[np.int16] = field(init=False)
    _stacked: int = field(init=False)

    def __post_init__(self) -> None:
        self._bare = _next_bare(self.problem)
        self._fewest = _fewest(self.problem, self._bare)
        catalogue = self.problem.catalogue
        self._covers = coverage(catalogue[:, None], self.problem.segments).astype(np.int16)
        stacked = self.problem.constraints.stacked
        self._stacked = min(stacked or self.problem.sensors, self.problem.sensors)

    def chunks(self) -> Iterator[Indices]:
        """Chunks of placements that keep to the constraints, fixed sensors first, (P, n, 2)."""
        fixed = np.array(self.problem.constraints.fixed, dtype=np.intp).reshape(-1, 2)
        free = self.problem.sensors - len(fixed)
        count = coverage(fixed[None], self.problem.segments).astype(np.int16)
        root = np.zeros((1, 0), dtype=np.intp)
        kept = self._viable(count, np.zeros(1, np.intp), np.zeros(1, np.intp), free)
        for numbers in self._completed(root[kept], count[kept], free):
            head = np.broadcast_to(fixed, (len(numbers), *fixed.shape))
            spans = np.concatenate([head, self.problem.catalogue[numbers]], axis=1)
            yield spans[self.problem.violations(spans) == 0]

    def _completed(
        self, partial: Indices, count: NDArray[np.int16], missing: int
    ) -> Iterator[Indices]:
        """Complete partial placements by `missing` more sensors.

        Args:
            partial: numbers of spans, shape (P, k).
            count: sensors over each segment, shape (P, m).
            missing: number of sensors to come.
        """
        if missing == 0:
            yield partial
            return
        first, last = self.problem.catalogue.T
        reach = (last[partial] + 1).max(axis=1, initial=0)
        begin = self._earliest(partial, count)
        end = np.searchsorted(first, self._bare[reach], side="right")
        counts = np.maximum(end - begin, 0)
        for piece in _pieces(counts):
            self._tried += int(counts[piece].sum())
            if self._tried > self.effort:
                self.complete = False
                return
            rows = np.repeat(np.arange(piece.start, piece.stop), counts[piece])
            offset = np.repeat(np.cumsum(counts[piece]) - counts[piece], counts[piece])
            numbers = begin[rows] + np.arange(len(rows)) - offset
            reached = np.maximum(reach[rows], last[numbers] + 1)
            grown = count[rows] + self._covers[numbers]
            kept = self._viable(grown, reached, first[numbers], missing - 1)
            if kept.any():
                longer = np.column_stack([partial[rows[kept]], numbers[kept]])
                yield from self._completed(longer, grown[kept], missing - 1)

    def _earliest(self, partial: Indices, count: NDArray[np.int16]) -> Indices:
        """Number of the first span that the next sensor may have, shape (P,)."""
        first = self.problem.catalogue[:, 0]
        if not partial.shape[1]:
            return np.zeros(len(partial), dtype=np.intp)
        # A span that begins before the first segment with room would overfill that one.
        room = count < self._stacked
        room &= np.arange(self.problem.segments) >= first[partial[:, -1]][:, None]
        inside = np.searchsorted(first, room.argmax(axis=1), side="left")
        return np.where(room.any(axis=1), np.maximum(partial[:, -1], inside), len(first))

    def _viable(
        self, count: NDArray[np.int16], reach: Indices, begin: Indices, missing: int
    ) -> NDArray[np.bool_]:
        """Whether partial placements may still be completed, shape (P,).

        Args:
            count: sensors over each segment, shape (P, m).
            reach: one behind the last segment covered, shape (P,).
            begin: first segment of the last span, shape (P,).
            missing: number of sensors to come.
        """
        viable = (self._fewest[reach] <= missing) & (count <= self._stacked).all(axis=1)
        if missing:
            left = np.arange(self.problem.segments) >= begin[:, None]
            room = np.where(left, self._stacked - count, 0).sum(axis=1)
            viable &= room >= missing * self._covers.sum(axis=1).min()
        return np.asarray(viable)


def _pieces(counts: Indices) -> Iterator[slice]:
    """Cut rows into runs that grow to about a chunk each."""
    totals = np.cumsum(counts)
    start = 0
    while start < len(counts):
        done = totals[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(totals, done + _CHUNK, side="right")))
        yield slice(start, stop)
        start = stop


def _next_bare(problem: Question) -> Indices:
    """First bare segment at or after r once all before r are covered, for r = 0 to m."""
    segments = problem.segments
    covered = np.zeros(segments, dtype=bool)
    for a, b in problem.constraints.fixed:
        covered[a : b + 1] = True
    bare = np.full(segments + 1, segments, dtype=np.intp)
    for r in range(segments - 1, -1, -1):
        bare[r] = bare[r + 1] if covered[r] else r
    return bare


def _fewest(problem: Question, bare: Indices) -> Indices:
    """Fewest spans that cover the rest once all before r are covered, for r = 0 to m."""
    segments = problem.segments
    first, last = problem.catalogue.T
    fewest = np.zeros(segments + 1, dtype=np.intp)
    for r in range(segments - 1, -1, -1):
        if bare[r] == segments:
            continue
        ends = last[(first <= bare[r]) & (last >= bare[r])]
        # More than there can be sensors, where nothing covers the bare segment.
        fewest[r] = 1 + fewest[ends + 1].min(initial=problem.sensors)
    return fewest
