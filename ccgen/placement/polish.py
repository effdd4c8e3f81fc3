"""The last steps of a search whose model only stands for the objective."""

import numpy as np

from ccgen.placement.objective import Indices
from ccgen.placement.question import Question

_TRIED = 12
"""Spans of each sensor that the model ranks first."""


def polished(problem: Question, start: Indices) -> tuple[Indices, int]:
    """Move sensors to what the objective itself likes best: one at a time, or two for each other.

    Spans to try are those that the model ranks first.

    Args:
        problem: the question.
        start: an allowed placement, shape (n, 2).

    Returns:
        The placement, and how many were evaluated.
    """
    spans, best = start.copy(), float(problem.percents(start[None])[0])
    free, evaluated, rested, turn = problem.slots.free, 1, 0, 0
    while rested < len(free):
        tried = _likely(problem, spans, int(free[turn]))
        values = problem.percents(tried)
        evaluated += len(tried)
        rested += 1
        if len(values) and values.min() < best:
            spans, best, rested = tried[int(np.argmin(values))], float(values.min()), 1
        turn = (turn + 1) % len(free)
        if rested == len(free):
            swapped = _swapped(problem, spans)
            values = problem.percents(swapped)
            evaluated += len(swapped)
            if len(values) and values.min() < best:
                spans, best, rested = swapped[int(np.argmin(values))], float(values.min()), 0
    return spans, evaluated


def _swapped(problem: Question, spans: Indices) -> Indices:
    """Allowed placements with two sensors' spans swapped, those that the model ranks first."""
    swapped = problem.slots.swapped(spans)
    allowed = swapped[problem.violations(swapped) == 0]
    return np.asarray(allowed[np.argsort(problem.model.values(allowed), kind="stable")[:_TRIED]])


def _likely(problem: Question, spans: Indices, slot: int) -> Indices:
    """Allowed placements with one sensor elsewhere, those that the model ranks first."""
    others = np.delete(spans, slot, axis=0)
    order = np.argsort(problem.model.moved_values(others, problem.catalogue, slot), kind="stable")
    moved = np.repeat(spans[None], len(order), axis=0)
    moved[:, slot] = problem.catalogue[order]
    allowed = moved[problem.violations(moved) == 0]
    return np.asarray(allowed[:_TRIED])
