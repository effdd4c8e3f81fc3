"""The best of a few placements, without approximation."""

import numpy as np

from ccgen.layouts import Spans
from ccgen.placement.certificate import Certificate
from ccgen.placement.cost import Floats, Indices
from ccgen.placement.problem import Problem, as_spans

ROUNDING = 1e-6
"""Share of a cost by which the ways of computing it may differ by rounding."""


def best_of(problem: Problem, candidates: Indices) -> tuple[Spans, float]:
    """The best of some placements, shape (P, n, 2), and its `Problem.percent`.

    Of equals it is the one whose spans come first; the order of the placements and of the sensors
    in each does not matter.
    """
    distinct = sorted({as_spans(one) for one in candidates})
    ordered = np.array(distinct, dtype=np.intp)
    likely = int(np.argmin(problem.model.costs(ordered)))
    limit = problem.percent(distinct[likely])
    rivals = within(problem, ordered, limit)
    percents = problem.percents(rivals)
    chosen = as_spans(rivals[int(np.argmin(percents))])
    return chosen, problem.percent(chosen)


def within(problem: Problem, placements: Indices, limit: float) -> Indices:
    """Those of some placements whose cost in % cannot be proven to exceed a limit."""
    return placements[_lower_bounds(problem, placements) <= limit * (1 + ROUNDING)]


def _lower_bounds(problem: Problem, placements: Indices) -> Floats:
    if problem.noise:
        # These weights are least-squares ones, and their cost is exact.
        return problem.model.costs(placements)
    return Certificate(problem).lower_bounds(placements)
