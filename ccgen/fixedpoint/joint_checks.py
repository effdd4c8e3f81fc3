"""The checks of a joint's sensors, and what is told of each sensor."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ccgen.errors import FormatError
from ccgen.estimation.consistency.population import sound_readings, why_unchecked
from ccgen.fixedpoint.checking import CheckedGroup, Transducers, checked_groups, detects
from ccgen.fixedpoint.consistency import GroupCheck
from ccgen.fixedpoint.model import FixedPointModel
from ccgen.joint import Joint
from ccgen.shapes import Shapes


@dataclass(frozen=True)
class SensorCheck:
    """What is told of faults of one sensor.

    Attributes:
        sensor: its name.
        detectable_m: the smallest offset that is seen in 99 % of snapshots, metres; None where
            no offset up to the sensor's largest reading is.
        detectable_percent: of the sensor's largest reading.
        isolable: whether a fault of that size names its sensor, in 95 % of snapshots.
        isolated_m: the smallest offset that does; None where none does.
    """

    sensor: str
    detectable_m: float | None
    detectable_percent: float | None
    isolable: bool
    isolated_m: float | None


@dataclass(frozen=True, eq=False)
class JointChecks:
    """The checks of a joint.

    Attributes:
        groups: integer checks.
        sensors: what is told, in the joint's order; empty where nothing is checked.
        notes: why sensors are not checked, a sentence each.
    """

    groups: tuple[GroupCheck, ...] = ()
    sensors: tuple[SensorCheck, ...] = ()
    notes: tuple[str, ...] = ()


def joint_checks(joint: Joint, shapes: Shapes, model: Callable[[], FixedPointModel]) -> JointChecks:
    """Hold the sensors of a joint against each other.

    Args:
        joint: the joint; `check` and `false_alarms` say whether and how often.
        shapes: that its estimators are fitted to.
        model: makes the model with the ranges of its counts, where they are needed.

    Raises:
        ReachError: no draw of the loads gives a shape.
    """
    if not joint.check:
        return JointChecks()
    why = why_unchecked(joint, shapes)
    if why is not None:
        return JointChecks(notes=(f"the sensors are not checked: {why}",))
    try:
        transducers = _transducers(joint, model())
    except FormatError:
        return JointChecks(notes=(_NO_COUNTS,))
    sound = sound_readings(joint, shapes)
    groups = [slice(*part) for part in dict.fromkeys(joint.parts)]
    found = checked_groups(sound, groups, transducers, joint.false_alarms)
    told = {}
    for one in found:
        largest = np.abs(sound.lengths[:, one.check.own]).max(axis=0)
        seen = detects(one.faults, sound.lengths[:, one.check.own])
        for j in range(one.check.sensors):
            told[one.check.first + j] = _told(joint, one, j, bool(seen[j]), float(largest[j]))
    names = [sensor.name for sensor in joint.sensors]
    rows = [told.get(j, SensorCheck(name, None, None, False, None)) for j, name in enumerate(names)]
    return JointChecks(
        groups=tuple(one.check for one in found),
        sensors=tuple(rows),
        notes=tuple(_unchecked(joint, group, told) for group in groups if group.start not in told),
    )


_NO_COUNTS = "the sensors are not checked: no fixed point holds their counts"


def _told(joint: Joint, group: CheckedGroup, j: int, seen: bool, largest: float) -> SensorCheck:
    name = joint.sensors[group.check.first + j].name
    isolated = float(group.faults.isolated[j])
    named = None if np.isnan(isolated) else isolated
    if not seen:
        return SensorCheck(name, None, None, False, named)
    size = float(group.faults.detectable[j])
    return SensorCheck(name, size, 100.0 * size / largest, bool(group.faults.isolable[j]), named)


def _unchecked(joint: Joint, group: slice, told: dict[int, SensorCheck]) -> str:
    names = ", ".join(sensor.name for sensor in joint.sensors[group])
    return (
        f"sensors {names} are not checked: they are too few to contradict each other beyond noise "
        "and shapes; add sensors, or let spans overlap"
    )


def _transducers(joint: Joint, model: FixedPointModel) -> Transducers:
    span = np.zeros(len(joint.sensors), dtype=np.int64)
    for axis in model.axes.values():
        span[axis.part] = axis.span
    step = np.array([sensor.metres_per_count for sensor in joint.sensors])
    return Transducers(step, span, joint.precision)
