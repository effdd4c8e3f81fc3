"""The last steps of a search whose model only stands for the objective."""

import numpy as np

from ccgen.placement.objective import Indices
from ccgen.placement.question import Question

_TRIED = 12
"""Spans of each sensor that the model ranks first."""


def polished(problem: Question, start: Indices) -> tuple[Indices, int]:
    """Move one sensor at a time to what the objective itself likes best among likely spans.

    Args:
        problem: the question.
        start: an allowed placement, fixed sensors first, shape (n, 2).

    Returns:
        The placement, and how many were evaluated.
    """
    spans, best = start.copy(), float(problem.percents(start[None])[0])
    fixed, evaluated, rested, slot = len(problem.constraints.fixed), 1, 0, 0
    free = len(spans) - fixed
    while free and rested < free:
        tried = _likely(problem, spans, fixed + slot)
        values = problem.percents(tried)
        evaluated += len(tried)
        rested += 1
        if len(values) and values.min() < best:
            spans, best, rested = tried[int(np.argmin(values))], float(values.min()), 1
        slot = (slot + 1) % free
    return spans, evaluated


def _likely(problem: Question, spans: Indices, slot: int) -> Indices:
    """Allowed placements with one sensor elsewhere, those that the model ranks first."""
    others = np.delete(spans, slot, axis=0)
    order = np.argsort(problem.model.moved_values(others, problem.catalogue, slot), kind="stable")
    moved = np.repeat(spans[None], len(order), axis=0)
    moved[:, slot] = problem.catalogue[order]
    allowed = moved[problem.violations(moved) == 0]
    return np.asarray(allowed[:_TRIED])
