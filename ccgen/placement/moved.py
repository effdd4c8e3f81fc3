"""A joint whose sensors are elsewhere."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from ccgen.errors import InputError
from ccgen.joint.layouts import AnySpans

if TYPE_CHECKING:
    from ccgen.joint import Joint, Sensor


def with_spans(joint: "Joint", spans: Mapping[str, AnySpans]) -> "Joint":
    """The joint with any number of sensors like an axis' first at other spans.

    Args:
        joint: one with sets of the paper's kind, alike within an axis.
        spans: of each bending axis that is left, in the order of the joint's axes.
    """
    sensors: list[Sensor] = []
    parts = []
    for axis, own in spans.items():
        like, first = joint.sensors[joint.own(axis).start], len(sensors)
        sensors += [
            replace(like, name=f"{axis}{j}", start=float(a), end=b + 1.0)
            for j, (a, b) in enumerate(own)
        ]
        parts.append((first, len(sensors)))
    return replace(joint, sensors=tuple(sensors), axes=tuple(spans), parts=tuple(parts))


def moved(joint: "Joint", axis: str, spans: AnySpans) -> "Joint | None":
    """The joint with one axis alone, whose sensors have other spans.

    Args:
        joint: one with a set of the paper's kind for that axis.
        axis: "u" or "v".
        spans: any number of them.

    Returns:
        None where the sensors differ in more than their spans.
    """
    sensors = joint.sensors[joint.own(axis)]
    if len({(s.noise, s.radius, s.metres_per_count, s.gain_tolerance) for s in sensors}) > 1:
        return None
    return with_spans(joint, {axis: spans})


def alike(joint: "Joint", axis: str, key: str) -> float:
    """Value of a key that is the same for all sensors of an axis; 0 where none states it.

    Raises:
        InputError: they differ, so that it is not known which sensor goes where.
    """
    values = {getattr(sensor, key) for sensor in joint.sensors[joint.own(axis)]}
    if len(values) > 1:
        raise InputError(
            f"{joint.source}: {key}: differs among the sensors of axis {axis}, whose spans are to "
            "be chosen; write one value for all"
        )
    return float(values.pop() or 0.0)
