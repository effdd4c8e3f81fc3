"""Which axes are estimated, which sensors each of them reads, and whether those see it."""

import math
from collections.abc import Iterable, Sequence

from ccgen.joint.messages import KeyProblemError, toml_value
from ccgen.joint.spans import segments_said
from ccgen.joint.specification import OUTPUT_AXES, Geometry, Sensor
from ccgen.joint.tables import JointTable

_SEES = {"u": "90 or 270", "v": "0 or 180"}
"""Degrees at which a sensor reads this bending axis alone."""

_EXACT = 1e-12


def output_axes(table: JointTable, elongates: bool) -> tuple[str, ...]:
    """Return the axes to estimate, in their order.

    Args:
        table: the whole file.
        elongates: whether it states an elongation.

    Raises:
        KeyProblemError: an axis twice, no bending axis, or elongation without a range of it.
    """
    stated = table.estimator.axes
    if stated is None:
        return OUTPUT_AXES if elongates else OUTPUT_AXES[:2]
    for i, axis in enumerate(stated):
        if axis in stated[:i]:
            raise KeyProblemError(
                f'estimator.axes[{i}]: "{axis}" stands there twice; write each axis once'
            )
    if stated == ["h"]:
        raise KeyProblemError(
            'estimator.axes: ["h"] leaves out both bending axes; add "u" or "v" to it'
        )
    if "h" in stated and not elongates:
        raise KeyProblemError(
            'geometry.elongation: missing, but estimator.axes has "h"; write '
            "elongation = [0.0, 0.05] (the lowest and the highest share of the length)"
        )
    return tuple(axis for axis in OUTPUT_AXES if axis in stated)


def parts_of(
    sensors: Sequence[Sensor], axes: Sequence[str], elongates: bool
) -> tuple[tuple[int, int], ...]:
    """Return for each axis the first sensor that it reads and the one after the last.

    Where no sensor reads more than one axis, and those of an axis follow each other, an axis reads
    its own sensors; otherwise, and where elongation reaches all of them, each reads all.
    """
    everything = ((0, len(sensors)),) * len(axes)
    if elongates:
        return everything
    seen = [_axes_seen(sensor, axes) for sensor in sensors]
    if any(len(some) > 1 for some in seen):
        return everything
    parts = []
    for axis in axes:
        own = [j for j, some in enumerate(seen) if axis in some]
        if own[-1] - own[0] + 1 != len(own):
            return everything
        parts.append((own[0], own[-1] + 1))
    return tuple(parts)


def check_seen(sensors: Sequence[Sensor], axes: Sequence[str], geometry: Geometry) -> None:
    """Check that the sensors over each segment tell its bending axes from each other.

    Raises:
        KeyProblemError: an axis, or some segments of it, that no sensor sees.
    """
    bending = [axis for axis in axes if axis in _SEES]
    if "h" not in axes and geometry.elongation is None:
        _check_useful(sensors, bending)
    over = [[s for s in sensors if s.start < i + 1 and i < s.end] for i in range(geometry.segments)]
    for axis in bending:
        blind = [i for i, some in enumerate(over) if not any(_part(s, axis) for s in some)]
        if blind:
            raise KeyProblemError(_unseen(sensors, axis, blind, geometry.segments))
    if len(bending) == len(_SEES):
        mixed = [i for i, some in enumerate(over) if not _independent(some)]
        if mixed:
            raise KeyProblemError(_mixed(over[mixed[0]], mixed, geometry.segments))


def _part(sensor: Sensor, axis: str) -> float:
    """Share of a bend about this axis that the sensor reads."""
    value = math.sin(sensor.angle) if axis == "u" else -math.cos(sensor.angle)
    return 0.0 if abs(value) < _EXACT else value


def _axes_seen(sensor: Sensor, axes: Iterable[str]) -> list[str]:
    return [axis for axis in axes if axis in _SEES and _part(sensor, axis)]


def _independent(sensors: Sequence[Sensor]) -> bool:
    """Whether the sensors' directions span both bending axes."""
    first = sensors[0]
    return any(abs(math.sin(s.angle - first.angle)) > _EXACT for s in sensors)


def _check_useful(sensors: Sequence[Sensor], bending: Sequence[str]) -> None:
    for i, sensor in enumerate(sensors):
        if not _axes_seen(sensor, bending):
            raise KeyProblemError(
                f"sensor[{i}].angle: at {_degrees(sensor)} degrees it sees nothing of axis "
                f"{bending[0]}, all that estimator.axes names; remove the sensor, or name the "
                "other axis too"
            )


def _unseen(sensors: Sequence[Sensor], axis: str, blind: list[int], segments: int) -> str:
    """What is wrong where an axis is not seen; the remedy names angles, or the axes."""
    if len(blind) == segments:
        angles = sorted({_degrees(s) for s in sensors}, key=float)
        return (
            f"sensor: none sees axis {axis}, for all are at {' or '.join(angles)} degrees; "
            f'write an angle of {_SEES[axis]} for one, or leave "{axis}" out of estimator.axes'
        )
    return (
        f"sensor: none sees axis {axis} over {segments_said(blind)}; let one that does, such as at "
        f"{_SEES[axis]} degrees, cover {'it' if len(blind) == 1 else 'them'}"
    )


def _mixed(sensors: Sequence[Sensor], mixed: list[int], segments: int) -> str:
    angles = sorted({_degrees(s) for s in sensors}, key=float)
    where = "" if len(mixed) == segments else f" over {segments_said(mixed)}"
    across = f"{(float(angles[0]) + 90.0) % 360.0:g}"
    return (
        f"sensor: all{where} are at {' or '.join(angles)} degrees, which see u and v together "
        f"only; write another angle for one, such as {across}, or "
        f"estimator.axes = {toml_value(['v'])} for a joint that bends in one plane"
    )


def _degrees(sensor: Sensor) -> str:
    return f"{round(math.degrees(sensor.angle), 9) % 360.0:g}"
