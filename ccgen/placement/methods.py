"""Placements by the name of the method."""

from ccgen.errors import InputError
from ccgen.layouts import LAYOUTS, spans_for
from ccgen.placement.evolution import Evolution, evolve
from ccgen.placement.problem import Placement, Problem
from ccgen.placement.search import Search, search

METHODS = (*LAYOUTS, "evolutionary", "search")


def place(
    problem: Problem,
    method: str,
    evolution: Evolution | None = None,
    search_settings: Search | None = None,
) -> Placement:
    """Place the sensors by the method of that name, one of `METHODS`.

    Raises:
        InputError: unknown method, or no placement by it that keeps to the constraints.
    """
    if method == "evolutionary":
        return evolve(problem, evolution)
    if method == "search":
        return search(problem, search_settings)
    if method not in LAYOUTS:
        raise InputError(f"unknown method {method!r}; give one of {', '.join(METHODS)}")
    return _layout(problem, method)


def _layout(problem: Problem, method: str) -> Placement:
    if method == "single" and problem.sensors != 1:
        raise InputError(f"the layout single has 1 sensor, not {problem.sensors}")
    try:
        spans = spans_for(method, problem.segments, problem.sensors)
    except ValueError as error:
        raise InputError(str(error)) from error
    if not problem.allows(spans):
        raise InputError(f"the layout {method} does not keep to the constraints; use the search")
    return Placement(method, spans, problem.percent(spans), 1)
