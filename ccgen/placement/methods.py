"""Placements by the name of the method."""

from ccgen.errors import InputError
from ccgen.joint.layouts import LAYOUTS, spans_for
from ccgen.placement.evolution import Evolution, evolve
from ccgen.placement.problem import Placement
from ccgen.placement.question import Question
from ccgen.placement.search import Search, search
from ccgen.placement.settings import Report, silent

METHODS = (*LAYOUTS, "evolutionary", "search")


def place_by(
    problem: Question,
    method: str,
    evolution: Evolution | None = None,
    search_settings: Search | None = None,
    report: Report = silent,
) -> Placement:
    """Place the sensors by the method of that name, one of `METHODS`.

    Args:
        problem: the joint, its sensors and constraints.
        method: the name.
        evolution: settings of the evolutionary algorithm.
        search_settings: settings of the search.
        report: called now and then by methods that take long.

    Raises:
        InputError: unknown method, or no placement by it that keeps to the constraints.
    """
    if method == "evolutionary":
        return evolve(problem, evolution, report)
    if method == "search":
        return search(problem, search_settings, report=report)
    if method not in LAYOUTS:
        raise InputError(f"unknown method {method!r}; give one of {', '.join(METHODS)}")
    return _layout(problem, method)


def _layout(problem: Question, method: str) -> Placement:
    if method == "single" and problem.sensors != 1:
        raise InputError(f"the layout single has 1 sensor, not {problem.sensors}")
    try:
        spans = spans_for(method, problem.segments, problem.sensors)
    except ValueError as error:
        raise InputError(str(error)) from error
    if not problem.allows(spans):
        raise InputError(f"the layout {method} does not keep to the constraints; use the search")
    return Placement(method, spans, problem.percent(spans), 1)
