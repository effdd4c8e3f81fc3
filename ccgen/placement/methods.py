"""Placements by the name of the method."""

from ccgen.errors import InputError
from ccgen.joint.layouts import LAYOUTS
from ccgen.placement.evolution import Evolution, evolve
from ccgen.placement.problem import Placement
from ccgen.placement.question import Question
from ccgen.placement.search import Search, search
from ccgen.placement.settings import Report, silent

SEARCHED = ("evolutionary", "search")
METHODS = (*LAYOUTS, *SEARCHED)

STATED = "stated"
"""The method that leaves sensors of [[sensor]] where the joint file has them."""


def place_by(
    problem: Question,
    method: str,
    evolution: Evolution | None = None,
    search_settings: Search | None = None,
    report: Report = silent,
) -> Placement:
    """Place the sensors by the method of that name, one of `METHODS` or `STATED`.

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
    if method not in (STATED, *LAYOUTS):
        raise InputError(f"unknown method {method!r}; give one of {', '.join(METHODS)}")
    spans = problem.laid_out(method)
    if not problem.allows(spans):
        raise InputError(f"the layout {method} does not keep to the constraints; use the search")
    return Placement(method, spans, problem.percent(spans), 1)
