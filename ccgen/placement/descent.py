"""Descent: move one sensor at a time to the best of all its spans, and swap two that differ.

With the other sensors' vectors orthonormal, each span that the moving sensor may take changes the
error by a product of two vectors: one pass tells of every span.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ccgen.placement.compare import NEGLIGIBLE
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.question import Question
from ccgen.placement.slots import UNSEEN, coverage

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
        """Descend from a placement until no move and no swap improves it.

        The spans of the free sensors must be allowed ones; how they lie together need not be.

        Returns:
            The placement, shape (n, 2), and its objective in %.
        """
        spans, value = self._moved(start.copy(), np.inf)
        while True:
            swapped, best = self._swapped(spans)
            if best >= value * (1 - _IMPROVEMENT):
                return spans, value
            spans, value = self._moved(swapped, best)

    def _moved(self, spans: Indices, value: float) -> tuple[Indices, float]:
        """Move one sensor at a time until none of them improves the placement."""
        free = self.problem.slots.free
        rested, turn = 0, 0
        while rested < len(free):
            slot = int(free[turn])
            values = self._values(spans, slot)
            best = int(np.argmin(values))
            if values[best] < value * (1 - _IMPROVEMENT):
                value, rested = float(values[best]), 0
                spans[slot] = self.problem.catalogue[best]
            rested += 1
            turn = (turn + 1) % len(free)
        return spans, value

    def _swapped(self, spans: Indices) -> tuple[Indices, float]:
        """The best placement in which two sensors that differ have each other's spans."""
        tried = self.problem.slots.swapped(spans)
        if not len(tried):
            return spans, np.inf
        self.evaluations += len(tried)
        values = self.problem.model.values(tried) + BROKEN * self.problem.violations(tried)
        best = int(np.argmin(values))
        return tried[best], float(values[best])

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
        values += BROKEN * _broken(self.problem, others, slot)
        # What is left of a vanishing objective is rounding; there the shorter span is the better.
        lengths = np.diff(self.problem.catalogue)[:, 0] + 1 + (np.diff(others) + 1).sum()
        vanishing = values < NEGLIGIBLE
        values[vanishing] = NEGLIGIBLE * lengths[vanishing] / (len(spans) * self.problem.segments)
        self.evaluations += len(values)
        for index in np.argsort(values, kind="stable")[:KEPT]:
            met = spans.copy()
            met[slot] = self.problem.catalogue[index]
            ordered = self.problem.slots.ordered(met)
            self.met.setdefault(ordered.tobytes(), (float(values[index]), met))
        return values


def _broken(problem: Question, others: Indices, slot: int) -> Indices:
    """Broken constraints for each span of the catalogue beside the others, shape (S,).

    Args:
        others: shape (n - 1, 2).
        slot: of the moving sensor among the n.
    """
    segments, own, slots = problem.segments, problem.slots, problem.slots.without(slot)
    lacking = slots.lacking(others, segments)
    direction = own.directions[slot]
    helped = lacking > 0
    if direction == UNSEEN:
        helped[:] = False
    else:
        helped &= coverage(others[slots.directions == direction], segments) == 0
    broken = lacking.sum() - _within(helped, problem.catalogue)
    limit = problem.constraints.stacked
    if limit is not None:
        for side in np.unique(own.sides):
            count = coverage(others[slots.sides == side], segments)
            broken = broken + (count > limit).sum()
            if side == own.sides[slot]:
                broken = broken + _within(count == limit, problem.catalogue)
    return np.asarray(broken, dtype=np.intp)


def _within(marked: NDArray[np.bool_], spans: Indices) -> Indices:
    """Number of marked segments within each span."""
    sums = np.concatenate([[0], np.cumsum(marked)])
    return np.asarray(sums[spans[:, 1] + 1] - sums[spans[:, 0]], dtype=np.intp)
