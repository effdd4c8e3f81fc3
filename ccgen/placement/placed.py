"""Placements for a whole joint: by each method, for the axes together or one by one."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from ccgen.errors import ArgumentError, InputError
from ccgen.joint import AXES
from ccgen.placement.asked import OBJECTIVES, Placeable, asked_of
from ccgen.placement.compare import NEGLIGIBLE
from ccgen.placement.constraints import Constraints
from ccgen.placement.evolution import Evolution
from ccgen.placement.methods import METHODS, SEARCHED, STATED, place_by
from ccgen.placement.problem import Placement
from ccgen.placement.question import Question
from ccgen.placement.search import Search

if TYPE_CHECKING:
    from ccgen.joint import Joint

Report = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


def silent(what: str, done: int, total: int) -> None:
    """Ignore progress."""


@dataclass(frozen=True)
class Placed:
    """Placements for the sensors of one table of the joint file.

    Attributes:
        table: its name: "sensors", "sensors.u" or "sensors.v"; "sensor" for all sensors of a joint
            that are placed one by one.
        axes: the bending axes that it is for.
        problem: what was asked.
        found: a placement by each method.
        refused: why other methods have none.
    """

    table: str
    axes: tuple[str, ...]
    problem: Placeable
    found: tuple[Placement, ...]
    refused: tuple[str, ...] = ()

    @property
    def best(self) -> Placement:
        """The lowest error; of equals the last, which is the one that may be proven."""
        return min(reversed(self.found), key=lambda one: max(one.percent, NEGLIGIBLE))

    @property
    def estimator(self) -> str:
        """The estimation method whose errors the placements were judged by."""
        return self.problem.estimator


def place(
    joint: "Joint",
    sensors: int | None = None,
    method: str | None = None,
    axis: str | None = None,
    objective: str | None = None,
    constraints: Constraints | None = None,
    evolution: Evolution | None = None,
    search: Search | None = None,
    report: Report = silent,
) -> tuple[Placed, ...]:
    """Place the sensors of a joint; one answer for both axes where they have one table.

    Sensors of [[sensor]], and all sensors of a joint that elongates, are placed one by one: each
    keeps its angle, radius and transducer.

    Args:
        joint: the joint.
        sensors: number of sensors of an axis, instead of the joint's; for the paper's sets.
        method: one of `METHODS`, or `STATED` for sensors one by one; by default all that apply are
            compared.
        axis: "u" or "v" alone; for the paper's sets.
        objective: one of `OBJECTIVES`; by default angles.
        constraints: what the builder allows.
        evolution, search: settings of the methods that search.
        report: called now and then.

    Raises:
        ArgumentError: a value that cannot be. InputError: a joint whose spans are not free to
            choose, no noise stated, or no placement that keeps to the constraints. ReachError: a
            shape that no load reaches.
    """
    _check(sensors, method, axis, objective)
    evolution, search = evolution or Evolution(), search or Search()
    evolution.check()
    search.check()
    questions = asked_of(joint, sensors, axis, objective, constraints or Constraints())
    answers: dict[Hashable, tuple[tuple[Placement, ...], tuple[str, ...]]] = {}
    placed = []
    for table, axes, problem in questions:
        asked, name = problem.key, f"{axes[0]}: " if len(questions) > 1 else ""
        if asked in answers:  # what two axes ask alike is answered, and refused, once
            placed.append(Placed(table, axes, problem, answers[asked][0]))
            continue

        def ask(method: str, problem: Question = problem, name: str = name) -> Placement:
            told = partial(report, name + method)
            return place_by(problem, method, evolution, search, told)

        try:
            answers[asked] = _compare(ask, problem, method)
        except InputError as error:
            raise InputError(f"{name}{error}") from error
        found, refused = answers[asked]
        placed.append(Placed(table, axes, problem, found, tuple(name + one for one in refused)))
    return tuple(placed)


def _check(
    sensors: int | None, method: str | None, axis: str | None, objective: str | None
) -> None:
    from ccgen.joint.sensor_tables import MOST_SENSORS_OF_AXIS

    if sensors is not None and not 1 <= sensors <= MOST_SENSORS_OF_AXIS:
        raise ArgumentError(
            f"{sensors} sensors on an axis; a joint file takes 1 to {MOST_SENSORS_OF_AXIS}",
            "sensors",
        )
    for name, value, known in (
        ("method", method, (*METHODS, STATED)),
        ("axis", axis, AXES),
        ("objective", objective, OBJECTIVES),
    ):
        if value is not None and value not in known:
            raise ArgumentError(f"{value!r} is unknown; give one of {', '.join(known)}", name)


def _compare(
    ask: Callable[[str], Placement], problem: Question, method: str | None
) -> tuple[tuple[Placement, ...], tuple[str, ...]]:
    """Placements by one method, or by each that finds one; and why the others find none.

    Raises:
        InputError: by no method.
    """
    if method is not None:
        return (ask(method),), ()
    found, refused = [], []
    for name in (*problem.layouts, *SEARCHED):
        try:
            found.append(ask(name))
        except InputError as error:
            refused.append(error)
    if not found:
        # The search's, which alone may know that there is none.
        raise refused[-1]
    return tuple(found), tuple(map(str, refused))
