"""The best placement: proven by enumeration where that is feasible, else by descents."""

import itertools
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ccgen.errors import InputError, require_least
from ccgen.joint.layouts import AnySpans
from ccgen.placement.bound import lower_bound
from ccgen.placement.compare import NEGLIGIBLE, best_of, within
from ccgen.placement.descent import BROKEN, Descent
from ccgen.placement.exhaustive import Walk, count_allowed, covering
from ccgen.placement.objective import Indices
from ccgen.placement.polish import polished
from ccgen.placement.problem import Placement, Problem
from ccgen.placement.question import Question, as_spans
from ccgen.placement.settings import Report, silent

_FINALISTS = 32
"""Best placements met whose objective is computed again without approximation."""

_FIRST = 5_000_000
"""Partial placements to look at for one that is allowed, where no usual start led to one."""

_POLISHED = 8
"""Placements that are improved further where the descents only had a model of the objective."""

_DISTURBED = 2
"""Sensors that are moved at random from the best placement, to leave a local minimum."""


@dataclass(frozen=True)
class Search:
    """Settings of the search.

    Attributes:
        enumerated: most placements to enumerate; 2 sensors need m^2, 3 on 20 segments 65,570,
            4 on 12 segments 290,863.
        starts: how many descents.
        seed: of its random numbers.
    """

    enumerated: int = 300_000
    starts: int = 24
    seed: int = 0

    def check(self) -> None:
        """Refuse settings that the search cannot run with.

        Raises:
            InputError: which, and what would be right.
        """
        require_least(0, "enumerated", self.enumerated)
        require_least(1, "starts", self.starts)
        require_least(0, "seed", self.seed)


def search(
    problem: Question,
    settings: Search | None = None,
    known: Sequence[AnySpans] = (),
    report: Report = silent,
) -> Placement:
    """Find the best placement that keeps to the constraints.

    Args:
        problem: the joint, its sensors and constraints.
        settings: how hard to try.
        known: allowed placements that descents start from too.
        report: called with the placements, or the descents, that are done.

    Raises:
        InputError: impossible settings, no such placement (proven), or none was found.
    """
    settings = settings or Search()
    settings.check()
    if not isinstance(problem, Problem):
        return descend(problem, settings, known, report)
    # A single placement is no search, whatever the limit.
    count = count_allowed(problem, max(1, settings.enumerated))
    if count is None:
        return descend(problem, settings, known, report)
    return enumerate_all(problem, report, count)


def enumerate_all(problem: Problem, report: Report = silent, count: int = 0) -> Placement:
    """Find the best placement of all, and prove it where its objective is more than rounding.

    For the paper's objective every placement is evaluated with squares in place of the soft-L1
    loss; those that the difference cannot rule out are then compared by `Problem.percents`.

    Args:
        problem: the joint, its sensors and constraints.
        report: called with the placements done, each of which is looked at twice.
        count: how many there are; for the report only.

    Raises:
        InputError: no placement keeps to the constraints.
    """
    best, lowest, evaluations = None, np.inf, 0
    for chunk in filter(len, covering(problem)):
        values = problem.model.values(chunk)
        evaluations += len(values)
        least = int(np.argmin(values))
        if values[least] < lowest:
            best, lowest = chunk[least], float(values[least])
        report(evaluations // 2, count)
    if best is None:
        raise _impossible(problem)
    limit = problem.percent(as_spans(best))
    rivals, compared = [best[None]], 0
    for chunk in covering(problem):
        rivals.append(within(problem, chunk, limit))
        compared += len(chunk)
        report((evaluations + compared) // 2, count)
    spans, percent = best_of(problem, np.concatenate(rivals))
    if percent <= NEGLIGIBLE and evaluations > 1:
        return Placement("search", spans, percent, evaluations)
    return Placement("search", spans, percent, evaluations, "proven", 0.0)


def descend(
    problem: Question, settings: Search, known: Sequence[AnySpans] = (), report: Report = silent
) -> Placement:
    """Descend from known and usual placements, from random ones, and from disturbed best ones.

    Every start has spans that are allowed; where no usual one leads to an allowed placement, the
    first that enumeration meets is a start too.

    Raises:
        InputError: there is no placement that keeps to the constraints (proven), or none was found.
    """
    random = np.random.default_rng(settings.seed)
    descent = Descent(problem)
    starts = [_onto_catalogue(problem, spans) for spans in _usual(problem, known)]
    usual, rested = len(starts), list(starts)
    best, lowest = None, np.inf
    for number in itertools.count():
        if number == usual and lowest >= BROKEN:
            starts += _first_allowed(problem)
        total = max(settings.starts, len(starts))
        if number == total:
            break
        if number < len(starts):
            start = starts[number]
        elif best is None or number % 2:
            start = _random(problem, random)
        else:
            start = _disturb(problem, best, random)
        resting, value = descent.run(start)
        rested.append(resting)
        if value < lowest:
            best, lowest = resting, value
        report(number + 1, total)
    finalists = descent.finalists(_FINALISTS)
    if not len(finalists):
        raise InputError(
            f"the search met no placement of {_counted(problem)} that covers the joint and keeps to"
            " the constraints; loosen them or use more sensors"
        )
    if not isinstance(problem, Problem):
        return _polished(problem, np.concatenate([finalists, rested]), descent.evaluations)
    spans, percent = best_of(problem, finalists)
    floor = lower_bound(problem.model, problem.sensors)
    if not 0 < floor <= percent or percent <= NEGLIGIBLE:
        return Placement("search", spans, percent, descent.evaluations)
    return Placement("search", spans, percent, descent.evaluations, "bound", 1 - floor / percent)


def _polished(problem: Question, likely: Indices, evaluations: int) -> Placement:
    """The best placement near to the best of likely ones, by an objective that has no bound.

    Args:
        problem: the question.
        likely: shape (P, n, 2); at least one of them is allowed.
        evaluations: how many placements were evaluated for them.
    """
    allowed = likely[problem.violations(likely) == 0]
    distinct = np.array(list({problem.arranged(one): one for one in allowed}.values()))
    ranked = distinct[np.argsort(problem.percents(distinct), kind="stable")]
    found = [polished(problem, one) for one in ranked[:_POLISHED]]
    spans, percent = best_of(problem, np.array([one for one, _ in found]))
    evaluations += len(distinct) + sum(count for _, count in found)
    return Placement("search", spans, percent, evaluations)


def _first_allowed(problem: Question) -> list[Indices]:
    """The first placement that enumeration meets; none where that takes too long.

    Sensors that differ are not enumerated.

    Raises:
        InputError: no placement keeps to the constraints.
    """
    if not problem.slots.are_alike:
        return []
    walk = Walk(problem, _FIRST)
    for chunk in walk.chunks():
        if len(chunk):
            return [chunk[0]]
    if walk.complete:
        raise _impossible(problem)
    return []


def _impossible(problem: Question) -> InputError:
    return InputError(
        f"no placement of {_counted(problem)} covers the joint and keeps to the constraints;"
        " loosen them or use more sensors"
    )


def _counted(problem: Question) -> str:
    return "1 sensor" if problem.sensors == 1 else f"{problem.sensors} sensors"


def _usual(problem: Question, known: Sequence[AnySpans]) -> list[Indices]:
    """Known placements and the usual layouts, in which held sensors are where they are held."""
    starts = [_fixed_first(problem, spans) for spans in known]
    for layout in reversed(problem.layouts):
        if layout == "single":  # all that end to end may be
            continue
        with suppress(InputError):
            spans = np.rint(problem.laid_out(layout)).astype(np.intp)
            starts.append(_held(problem, spans))
    return starts


def _held(problem: Question, spans: Indices) -> Indices:
    """A placement with the sensors that stay where they are."""
    for slot, span in problem.slots.held.items():
        spans[slot] = span
    return spans


def _onto_catalogue(problem: Question, spans: Indices) -> Indices:
    """A placement with the nearest allowed span in place of each of its free sensors' spans."""
    moved = spans.copy()
    for slot in problem.slots.free:
        distances = np.abs(problem.catalogue - spans[slot]).sum(axis=1)
        moved[slot] = problem.catalogue[np.argmin(distances)]
    return moved


def _fixed_first(problem: Question, spans: AnySpans) -> Indices:
    free = list(spans)
    for span in problem.constraints.fixed:
        free.remove(span)
    return np.array([*problem.constraints.fixed, *free], dtype=np.intp)


def _random(problem: Question, random: np.random.Generator) -> Indices:
    free = problem.slots.free
    spans = _held(problem, np.zeros((problem.sensors, 2), dtype=np.intp))
    spans[free] = problem.catalogue[random.integers(len(problem.catalogue), size=len(free))]
    return spans


def _disturb(problem: Question, spans: Indices, random: np.random.Generator) -> Indices:
    """A placement with some free sensors moved anywhere."""
    free = problem.slots.free
    moved = free[random.choice(len(free), size=min(len(free), _DISTURBED), replace=False)]
    disturbed = spans.copy()
    disturbed[moved] = problem.catalogue[random.integers(len(problem.catalogue), size=len(moved))]
    return disturbed
