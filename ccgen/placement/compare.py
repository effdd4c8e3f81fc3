"""The best of a few placements, without approximation."""

import numpy as np

from ccgen.joint.layouts import Spans
from ccgen.placement.certificate import Certificate
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.problem import Problem
from ccgen.placement.question import Question

ROUNDING = 1e-6
"""Share of an objective by which the ways of computing it may differ by rounding."""

RESOLUTION = 1e-12
"""Objective in % below which the fast ways of computing it are nothing but rounding."""

NEGLIGIBLE = 1e-10
"""Objective in % below which placements count as equally good: the shapes show as many independent
readings as there are sensors, or the range of motion is so small that they are hardly bent."""

_AT_ONCE = 256

_SETTLED = 64
"""Placements that the fast ways leave alike whose weights are fitted to the last digit."""

_EQUAL = 1e-12
"""Share of an objective by which weights that are fitted so may still differ."""


def best_of(problem: Question, candidates: Indices) -> tuple[Spans, float]:
    """The best of some placements, shape (P, n, 2), and its `percent`.

    Of equals, and of those with a negligible objective, it is the one with the shortest spans, then
    the one whose spans come first; the order of the placements and of the sensors in each does
    not matter.
    """
    distinct = sorted(
        {problem.arranged(one) for one in candidates},
        key=lambda spans: (total_length(spans), spans),
    )
    ordered = np.array(distinct, dtype=np.intp)
    if not isinstance(problem, Problem):
        percents = problem.percents(ordered)
        return _settled(problem, ordered, np.maximum(percents, NEGLIGIBLE))
    likely = int(np.argmin(problem.model.values(ordered)))
    rivals = within(problem, ordered, problem.percent(distinct[likely]))
    rivals = rivals if len(rivals) else ordered[likely : likely + 1]
    parts: list[Floats] = []
    for start in range(0, len(rivals), _AT_ONCE):
        parts.append(problem.percents(rivals[start : start + _AT_ONCE]))
        if parts[-1].min() <= NEGLIGIBLE:
            break
    return _settled(problem, rivals, np.maximum(np.concatenate(parts), NEGLIGIBLE))


def _settled(problem: Question, rivals: Indices, percents: Floats) -> tuple[Spans, float]:
    """The best of those whose objective is the lowest but for rounding, and its `percent`.

    Args:
        problem: the joint and its sensors.
        rivals: placements, the shortest first.
        percents: their objective, none below the negligible one; may be shorter.
    """
    lowest = float(percents.min())
    if lowest <= NEGLIGIBLE:
        spans = problem.arranged(rivals[int(np.argmin(percents))])
        return spans, problem.percent(spans)
    close = np.flatnonzero(percents <= lowest * (1 + ROUNDING) + RESOLUTION)
    nearest = close[np.argsort(percents[close], kind="stable")][:_SETTLED]
    likely = [problem.arranged(rivals[k]) for k in sorted(nearest)]
    exact = [(spans, problem.percent(spans)) for spans in likely]
    limit = min(percent for _, percent in exact) * (1 + _EQUAL)
    return next((spans, percent) for spans, percent in exact if percent <= limit)


def total_length(spans: Spans) -> int:
    """Segments that the spans cover, each as often as it is covered."""
    return sum(last - first + 1 for first, last in spans)


def within(problem: Problem, placements: Indices, limit: float) -> Indices:
    """Those of some placements whose objective in % cannot be proven to exceed a limit.

    A negligible limit counts as `NEGLIGIBLE`.
    """
    allowed = max(limit, NEGLIGIBLE) * (1 + ROUNDING) + RESOLUTION
    return placements[_lower_bounds(problem, placements) <= allowed]


def _lower_bounds(problem: Problem, placements: Indices) -> Floats:
    if problem.noise:
        # These weights are least-squares ones, and their objective is exact.
        return problem.model.values(placements)
    return Certificate(problem).lower_bounds(placements)
