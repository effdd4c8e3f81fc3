"""The best of a few placements, without approximation."""

import numpy as np

from ccgen.joint.layouts import Spans
from ccgen.placement.certificate import Certificate
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.problem import Problem, as_spans

ROUNDING = 1e-6
"""Share of an objective by which the ways of computing it may differ by rounding."""


NEGLIGIBLE = 1e-10
"""Objective in % below which only rounding differs: as many independent readings as segments."""

_AT_ONCE = 256


def best_of(problem: Problem, candidates: Indices) -> tuple[Spans, float]:
    """The best of some placements, shape (P, n, 2), and its `Problem.percent`.

    Of equals, and of those with a negligible objective, it is the one with the shortest spans, then
    the one whose spans come first; the order of the placements and of the sensors in each does
    not matter.
    """
    distinct = sorted(
        {as_spans(one) for one in candidates}, key=lambda spans: (total_length(spans), spans)
    )
    ordered = np.array(distinct, dtype=np.intp)
    likely = int(np.argmin(problem.model.values(ordered)))
    chosen, lowest = ordered[likely], np.inf
    rivals = within(problem, ordered, problem.percent(distinct[likely]))
    for start in range(0, len(rivals), _AT_ONCE):
        percents = np.maximum(problem.percents(rivals[start : start + _AT_ONCE]), NEGLIGIBLE)
        least = int(np.argmin(percents))
        if percents[least] < lowest:
            chosen, lowest = rivals[start + least], float(percents[least])
        if lowest <= NEGLIGIBLE:
            break
    spans = as_spans(chosen)
    return spans, problem.percent(spans)


def total_length(spans: Spans) -> int:
    """Segments that the spans cover, each as often as it is covered."""
    return sum(last - first + 1 for first, last in spans)


def within(problem: Problem, placements: Indices, limit: float) -> Indices:
    """Those of some placements whose objective in % cannot be proven to exceed a limit.

    A negligible limit counts as `NEGLIGIBLE`.
    """
    return placements[_lower_bounds(problem, placements) <= max(limit, NEGLIGIBLE) * (1 + ROUNDING)]


def _lower_bounds(problem: Problem, placements: Indices) -> Floats:
    if problem.noise:
        # These weights are least-squares ones, and their objective is exact.
        return problem.model.values(placements)
    return Certificate(problem).lower_bounds(placements)
