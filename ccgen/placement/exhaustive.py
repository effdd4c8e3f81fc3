"""Every placement that keeps to the constraints, in batches.

Free sensors are ordered by their spans (first, then last segment). The first segment that is
still bare must be covered by the next sensor, since later ones begin further out: that prunes
everything that leaves a gap, and nothing else.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ccgen.placement.cost import Indices
from ccgen.placement.problem import Problem

_BATCH = 1 << 16


def count_covering(problem: Problem, limit: float = math.inf) -> int:
    """Number of placements without a bare segment (before the limit on stacked sensors).

    Counting ends early with some number above the limit where there are more.
    """
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
            break
    return int(ways[:, bare == segments].sum())


def covering(problem: Problem) -> Iterator[Indices]:
    """Batches of all placements that keep to the constraints, fixed sensors first, (P, n, 2)."""
    fixed = np.array(problem.constraints.fixed, dtype=np.intp).reshape(-1, 2)
    free = problem.sensors - len(fixed)
    for numbers in _complete(problem, np.zeros((1, 0), dtype=np.intp), free):
        head = np.broadcast_to(fixed, (len(numbers), *fixed.shape))
        spans = np.concatenate([head, problem.catalogue[numbers]], axis=1)
        yield spans[problem.violations(spans) == 0]


def _complete(problem: Problem, partial: Indices, missing: int) -> Iterator[Indices]:
    """Partial placements, as numbers of spans, shape (P, k), completed by `missing` more."""
    if missing == 0:
        yield partial
        return
    bare = _next_bare(problem)
    first, last = problem.catalogue.T
    begin = partial[:, -1] if partial.shape[1] else np.zeros(len(partial), dtype=np.intp)
    reach = (last[partial] + 1).max(axis=1, initial=0)
    end = np.searchsorted(first, bare[reach], side="right")
    counts = np.maximum(end - begin, 0)
    for piece in _pieces(counts):
        rows = np.repeat(np.arange(piece.start, piece.stop), counts[piece])
        offset = np.repeat(np.cumsum(counts[piece]) - counts[piece], counts[piece])
        numbers = begin[rows] + np.arange(len(rows)) - offset
        grown = np.column_stack([partial[rows], numbers])
        if missing == 1:
            reached = np.maximum(reach[rows], last[numbers] + 1)
            grown = grown[bare[reached] == problem.segments]
        if len(grown):
            yield from _complete(problem, grown, missing - 1)


def _pieces(counts: Indices) -> Iterator[slice]:
    """Cut rows into runs that grow to about a batch each."""
    totals = np.cumsum(counts)
    start = 0
    while start < len(counts):
        done = totals[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(totals, done + _BATCH, side="right")))
        yield slice(start, stop)
        start = stop


def _next_bare(problem: Problem) -> NDArray[np.intp]:
    """First bare segment at or after r once all before r are covered, for r = 0 to m."""
    segments = problem.segments
    covered = np.zeros(segments, dtype=bool)
    for a, b in problem.constraints.fixed:
        covered[a : b + 1] = True
    bare = np.full(segments + 1, segments, dtype=np.intp)
    for r in range(segments - 1, -1, -1):
        bare[r] = bare[r + 1] if covered[r] else r
    return bare
