"""Descent: move one sensor at a time to the best of all its spans.

With the other sensors' vectors orthonormal, each span that the moving sensor may take changes the
error by a product of two vectors: one pass tells of every span.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ccgen.placement.compare import NEGLIGIBLE
from ccgen.placement.constraints import coverage
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.question import Question

BROKEN = 200.0
"""What a broken constraint adds in %: more than any placement that keeps to them all has."""

KEPT = 8
"""Spans of each move that are kept for the exact comparison in the end."""

_IMPROVEMENT = 1e-9


@dataclass
class Descent:
    """Moves sensors of a problem downhill; counts what it evaluates and keeps the best it meets."""

    problem: Question
    evaluations: int = 0
    met: dict[bytes, tuple[float, Indices]] = field(default_factory=dict)

    def run(self, start: Indices) -> tuple[Indices, float]:
        """Descend from a placement, fixed sensors first, until no single move improves it.

        The spans of the free sensors must be allowed ones; how they lie together need not be.

        Returns:
            The placement, shape (n, 2), and its objective in %.
        """
        spans, value = start.copy(), np.inf
        fixed, sensors = len(self.problem.constraints.fixed), len(start)
        rested, slot = 0, fixed
        while rested < sensors - fixed:
            values = self._values(spans, slot)
            best = int(np.argmin(values))
            if values[best] < value * (1 - _IMPROVEMENT):
                value, rested = float(values[best]), 0
                spans[slot] = self.problem.catalogue[best]
            rested += 1
            slot = slot + 1 if slot + 1 < sensors else fixed
        return spans, value

    def finalists(self, count: int) -> Indices:
        """The best placements met that keep to the constraints, shape (at most count, n, 2)."""
        ranked = sorted(self.met.items(), key=lambda item: (item[1][0], item[0]))
        best = [spans for _, (_, spans) in ranked[:count]]
        spans = np.array(best, dtype=np.intp).reshape(-1, self.problem.sensors, 2)
        allowed: Indices = spans[self.problem.violations(spans) == 0]
        return allowed

    def _values(self, spans: Indices, slot: int) -> Floats:
        others = np.delete(spans, slot, axis=0)
        values = self.problem.model.moved_values(others, self.problem.catalogue, slot)
        values += BROKEN * _broken(self.problem, others)
        # What is left of a vanishing objective is rounding; there the shorter span is the better.
        lengths = np.diff(self.problem.catalogue)[:, 0] + 1 + (np.diff(others) + 1).sum()
        vanishing = values < NEGLIGIBLE
        values[vanishing] = NEGLIGIBLE * lengths[vanishing] / (len(spans) * self.problem.segments)
        self.evaluations += len(values)
        for index in np.argsort(values, kind="stable")[:KEPT]:
            met = spans.copy()
            met[slot] = self.problem.catalogue[index]
            ordered = met[np.lexsort((met[:, 1], met[:, 0]))]
            self.met.setdefault(ordered.tobytes(), (float(values[index]), met))
        return values


def _broken(problem: Question, others: Indices) -> Indices:
    """Broken constraints for each span of the catalogue beside the others, shape (S,)."""
    count = coverage(others[None], problem.segments)[0]
    bare = count == 0
    broken = bare.sum() - _within(bare, problem.catalogue)
    limit = problem.constraints.stacked
    if limit is not None:
        broken = broken + (count > limit).sum() + _within(count == limit, problem.catalogue)
    return np.asarray(broken, dtype=np.intp)


def _within(marked: NDArray[np.bool_], spans: Indices) -> Indices:
    """Number of marked segments within each span."""
    sums = np.concatenate([[0], np.cumsum(marked)])
    return np.asarray(sums[spans[:, 1] + 1] - sums[spans[:, 0]], dtype=np.intp)
