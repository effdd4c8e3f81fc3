"""Placements for a whole joint: by each method, for the axes together or one by one."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from ccgen.errors import ArgumentError, InputError
from ccgen.joint import AXES
from ccgen.joint.places import has_own_table
from ccgen.placement.compare import NEGLIGIBLE
from ccgen.placement.constraints import Constraints
from ccgen.placement.evolution import Evolution
from ccgen.placement.methods import METHODS, place_by
from ccgen.placement.problem import Placement, Problem, check_placeable, joint_problem
from ccgen.placement.search import Search
from ccgen.sensing.noise import stated_noise

if TYPE_CHECKING:
    from ccgen.joint import Joint

OBJECTIVES = ("paper", "noise")
"""The error of WAM without noise; the expected one of the noise-aware estimator."""

Report = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


def silent(what: str, done: int, total: int) -> None:
    """Ignore progress."""


@dataclass(frozen=True)
class Placed:
    """Placements for the sensors of one table of the joint file.

    Attributes:
        table: its name: "sensors", "sensors.u" or "sensors.v".
        axes: the axes that it is for.
        problem: what was asked.
        found: a placement by each method.
        refused: why other methods have none.
    """

    table: str
    axes: tuple[str, ...]
    problem: Problem
    found: tuple[Placement, ...]
    refused: tuple[str, ...] = ()

    @property
    def best(self) -> Placement:
        """The lowest error; of equals the last, which is the one that may be proven."""
        return min(reversed(self.found), key=lambda one: max(one.percent, NEGLIGIBLE))

    @property
    def estimator(self) -> str:
        """The estimation method whose errors the placements were judged by."""
        return "noise-aware" if self.problem.noise else "wam"


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

    Args:
        joint: the joint.
        sensors: number of sensors of an axis, instead of the joint's.
        method: one of `METHODS`; by default all that apply are compared.
        axis: "u" or "v" alone.
        objective: one of `OBJECTIVES`; by default noise where the joint states it.
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
    tables = _tables(joint, axis)
    with_noise = (objective or _usual_objective(joint)) == "noise"
    problems = [
        _problem(joint, axes[0], sensors, constraints or Constraints(), with_noise)
        for _, axes in tables
    ]
    answers: dict[tuple[int, float], tuple[tuple[Placement, ...], tuple[str, ...]]] = {}
    placed = []
    for (table, axes), problem in zip(tables, problems, strict=True):
        asked, name = (problem.sensors, problem.noise), f"{axes[0]}: " if len(tables) > 1 else ""
        if asked in answers:  # what two axes ask alike is answered, and refused, once
            placed.append(Placed(table, axes, problem, answers[asked][0]))
            continue

        def ask(method: str, problem: Problem = problem, name: str = name) -> Placement:
            told = partial(report, name + method)
            return place_by(problem, method, evolution, search, told)

        try:
            answers[asked] = _compare(ask, problem.sensors, method)
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
        ("method", method, METHODS),
        ("axis", axis, AXES),
        ("objective", objective, OBJECTIVES),
    ):
        if value is not None and value not in known:
            raise ArgumentError(f"{value!r} is unknown; give one of {', '.join(known)}", name)


def _usual_objective(joint: "Joint") -> str:
    """Noise that is stated counts, whatever the joint's estimator, which placing may change."""
    noise = stated_noise(joint)
    stated = noise is not None and bool(noise.all())
    return "noise" if stated or joint.method == "noise-aware" else "paper"


def _tables(joint: "Joint", axis: str | None) -> list[tuple[str, tuple[str, ...]]]:
    """The tables of the joint file that spans belong into, and the axes that each is for.

    Spans of [sensors] have no effect on an axis that has its own, and its own count, noise or
    radius make it a different question.
    """
    bending = tuple(one for one in AXES if one in joint.axes)
    if axis is None and not any(has_own_table(joint, one) for one in bending):
        return [("sensors", bending)]
    chosen = bending if axis is None else (axis,)
    return [(f"sensors.{one}", (one,)) for one in chosen]


def _problem(
    joint: "Joint", axis: str, sensors: int | None, constraints: Constraints, with_noise: bool
) -> Problem:
    check_placeable(joint, axis)
    count = len(joint.axis(axis).spans) if sensors is None else sensors
    return joint_problem(joint, axis, count, constraints, with_noise)


def _compare(
    ask: Callable[[str], Placement], sensors: int, method: str | None
) -> tuple[tuple[Placement, ...], tuple[str, ...]]:
    """Placements by one method, or by each that finds one; and why the others find none.

    Raises:
        InputError: by no method.
    """
    if method is not None:
        return (ask(method),), ()
    found, refused = [], []
    for name in METHODS:
        if name == "single" and sensors != 1:
            continue
        try:
            found.append(ask(name))
        except InputError as error:
            refused.append(error)
    if not found:
        # The search's, which alone may know that there is none.
        raise refused[-1]
    return tuple(found), tuple(map(str, refused))
