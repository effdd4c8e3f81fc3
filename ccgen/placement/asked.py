"""What is asked where sensors are placed: a question for each table of the joint file."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ccgen.errors import ArgumentError
from ccgen.estimation.recorded import recorded
from ccgen.estimation.sources import Source, simulated_sources
from ccgen.joint import AXES
from ccgen.joint.places import has_own_table
from ccgen.placement.constraints import Constraints
from ccgen.placement.listed import ListedProblem
from ccgen.placement.problem import Problem, check_placeable, joint_problem, read_one_by_one
from ccgen.placement.sets import SetsProblem
from ccgen.sensing.noise import stated_noise

if TYPE_CHECKING:
    from ccgen.joint import Joint

OBJECTIVES = ("paper", "angles", "tip")
"""The paper's: the error of WAM on the load cases, without noise. The expected error of segments'
angles, or of the tip, by all that the joint states."""

Placeable = Problem | SetsProblem | ListedProblem

Asked = tuple[str, tuple[str, ...], Placeable]
"""The table that spans belong into, the bending axes that it is for, and the question."""


def asked_of(
    joint: "Joint",
    sensors: int | None,
    axis: str | None,
    objective: str | None,
    constraints: Constraints,
) -> Sequence[Asked]:
    """The questions about a joint; arguments as of `ccgen.placement.place`.

    Raises:
        InputError: a joint whose spans are not free to choose, or what cannot be asked of it.
    """
    if not read_one_by_one(joint):
        return _sets(joint, sensors, axis, objective or "angles", constraints)
    _check_listed(sensors, axis, objective, constraints)
    return [_listed(joint, constraints, objective == "tip")]


def _check_listed(
    sensors: int | None, axis: str | None, objective: str | None, constraints: Constraints
) -> None:
    """Refuse what only the paper's sets have.

    Raises:
        ArgumentError: which argument.
    """
    theirs = "is for the sets of [sensors]; sensors that are placed one by one"
    if sensors is not None:
        raise ArgumentError(f"{theirs} are those of the file; leave it out", "sensors")
    if axis is not None:
        raise ArgumentError(f"{theirs} may read every axis; leave it out", "axis")
    if objective == "paper":
        raise ArgumentError(f"'paper' {theirs} take {' or '.join(OBJECTIVES[1:])}", "objective")
    if constraints.fixed:
        raise ArgumentError(f"{theirs} stay by their names; give those to staying", "fixed")


def _listed(joint: "Joint", constraints: Constraints, by_tip: bool) -> Asked:
    """The question for all sensors of a joint, one by one."""
    judged, sources = _judged(joint)
    problem = ListedProblem(joint=judged, sources=sources, constraints=constraints, by_tip=by_tip)
    return "sensor", problem.bending, problem


def _sets(
    joint: "Joint",
    sensors: int | None,
    axis: str | None,
    objective: str,
    constraints: Constraints,
) -> list[Asked]:
    """A question for each table of the paper's sets."""
    if constraints.staying:
        raise ArgumentError(
            "is for sensors that are placed one by one; give spans that stay to fixed", "staying"
        )
    tables = _tables(joint, axis)
    for _, axes in tables:
        check_placeable(joint, axes[0])
    counts = [sensors or len(joint.axis(axes[0]).spans) for _, axes in tables]
    if not _needs_more(joint, objective):
        return [
            (table, axes, _problem(joint, axes[0], count, constraints, objective))
            for (table, axes), count in zip(tables, counts, strict=True)
        ]
    judged, sources = _judged(joint)
    return [
        (
            table,
            axes,
            SetsProblem(
                joint=judged,
                sources=sources,
                constraints=constraints,
                by_tip=objective == "tip",
                axes=axes,
                sensors=count,
            ),
        )
        for (table, axes), count in zip(tables, counts, strict=True)
    ]


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


def _needs_more(joint: "Joint", objective: str) -> bool:
    """Whether placements are judged by more than the load cases and noise."""
    more = (
        joint.loads is not None
        or bool(joint.recordings)
        or any(sensor.gain_tolerance for sensor in joint.sensors)
    )
    return objective == "tip" or (objective == "angles" and more)


def _judged(joint: "Joint") -> "tuple[Joint, list[Source]]":
    """The joint with the noise of its sensors, and the shapes that placements are judged by.

    Recordings tell shapes wherever sensors are; noise they tell where the joint states none, alike
    for all sensors, since the best places for them are not known yet.
    """
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
