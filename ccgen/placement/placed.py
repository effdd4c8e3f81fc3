"""Placements for a whole joint: by each method, for the axes together or one by one."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ccgen.errors import ArgumentError, InputError
from ccgen.estimation.recorded import recorded
from ccgen.estimation.sources import Source, simulated_sources
from ccgen.joint import AXES
from ccgen.joint.places import has_own_table
from ccgen.placement.compare import NEGLIGIBLE
from ccgen.placement.constraints import Constraints
from ccgen.placement.evolution import Evolution
from ccgen.placement.methods import METHODS, place_by
from ccgen.placement.problem import Placement, Problem, check_placeable, joint_problem
from ccgen.placement.question import Question
from ccgen.placement.search import Search
from ccgen.placement.stated import StatedProblem
from ccgen.sensing.noise import stated_noise

if TYPE_CHECKING:
    from ccgen.joint import Joint

OBJECTIVES = ("paper", "angles", "tip")
"""The paper's: the error of WAM on the load cases, without noise. The expected error of segments'
angles, or of the tip, by all that the joint states."""

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
    problem: Problem | StatedProblem
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

    Args:
        joint: the joint.
        sensors: number of sensors of an axis, instead of the joint's.
        method: one of `METHODS`; by default all that apply are compared.
        axis: "u" or "v" alone.
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
    tables = _tables(joint, axis)
    constraints, objective = constraints or Constraints(), objective or "angles"
    for _, axes in tables:
        check_placeable(joint, axes[0])
    judged, sources = _judges(joint, objective)
    problems: list[Problem | StatedProblem] = []
    for _, axes in tables:
        count = sensors or len(joint.axis(axes[0]).spans)
        problems.append(
            _problem(joint, axes[0], count, constraints, objective)
            if sources is None
            else StatedProblem(judged, axes, sources, count, constraints, objective == "tip")
        )
    answers: dict[Hashable, tuple[tuple[Placement, ...], tuple[str, ...]]] = {}
    placed = []
    for (table, axes), problem in zip(tables, problems, strict=True):
        asked, name = problem.key, f"{axes[0]}: " if len(tables) > 1 else ""
        if asked in answers:  # what two axes ask alike is answered, and refused, once
            placed.append(Placed(table, axes, problem, answers[asked][0]))
            continue

        def ask(method: str, problem: Question = problem, name: str = name) -> Placement:
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


def _judges(joint: "Joint", objective: str) -> "tuple[Joint, list[Source] | None]":
    """What placements are judged by, where that is more than the load cases and noise.

    Recordings tell shapes wherever sensors are; noise they tell where the joint states none, alike
    for all sensors, since the best places for them are not known yet.
    """
    more = (
        joint.loads is not None
        or bool(joint.recordings)
        or any(sensor.gain_tolerance for sensor in joint.sensors)
    )
    if objective == "paper" or (objective == "angles" and not more):
        return joint, None
    if not joint.recordings:
        return joint, simulated_sources(joint)
    from ccgen.recordings.reading import read_recordings

    found = recorded(joint, read_recordings(joint))
    sources = [*simulated_sources(joint, bool(found.shaped)), *found.sources()]
    noise = stated_noise(found.joint)
    if stated_noise(joint) is None and noise is not None:
        usual = float(np.sqrt(np.mean(np.square(noise))))
        sensors = tuple(replace(sensor, noise=usual) for sensor in joint.sensors)
        joint = replace(joint, sensors=sensors)
    return joint, [source.spread if source.moment is not None else source for source in sources]


def _problem(
    joint: "Joint", axis: str, sensors: int, constraints: Constraints, objective: str
) -> Problem:
    """By the load cases, with noise where it is stated, whatever the joint's own estimator."""
    noise = stated_noise(joint)
    stated = noise is not None and bool(noise.all())
    with_noise = objective != "paper" and (stated or joint.method == "noise-aware")
    return joint_problem(joint, axis, sensors, constraints, with_noise)


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
