"""What a joint's sensors read while all of them are sound: its shapes, its noise, its tolerances.

The rate of false alarms is that of the tails: a few hundred shapes do not show how far out the
next one lies. Where shapes are drawn from the joint's loads, many more draws of the same loads
stand for them, and where few of those give most of the alarms, shapes that are rarer still.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation.consistency.alarms import sharing, thresholds
from ccgen.estimation.consistency.residuals import alarm_matrix
from ccgen.estimation.consistency.sound import Floats, SoundReadings
from ccgen.estimation.consistency.tails import Visited, with_tails
from ccgen.sensing.noise import length_variance
from ccgen.sensing.readings import length_changes

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.joint.loads import LoadRanges
    from ccgen.shapes import Shapes

CASES, LOADS = "cases", "loads"

DRAWS = 2048
"""Shapes that are drawn evenly, or as many as estimators are fitted to where those are more."""

SHARING = 100.0
"""Shapes that are to share the alarms: their rate is told to a tenth."""
_RAREST = 0.5
"""Of the rate of false alarms: shapes that are rarer do not raise it much, whatever they are."""


def why_unchecked(joint: "Joint", shapes: "Shapes") -> str | None:
    """Say what keeps a joint's sensors from being checked; None if nothing does.

    Args:
        joint: the joint.
        shapes: that its estimators are fitted to.
    """
    silent = [sensor.name for sensor in joint.sensors if not sensor.noise]
    if silent:
        return f"the noise of sensor {silent[0]} is not stated; state its noise"
    if joint.loads is None and set(shapes.source) == {CASES}:
        return (
            "the load cases alone do not show what sound sensors read; state the joint's loads in "
            "[loads]"
        )
    return None


def sound_readings(joint: "Joint", shapes: "Shapes") -> SoundReadings:
    """Readings of a sound joint, for one that `why_unchecked` has nothing against.

    Args:
        joint: its sensors, noise, tolerances and loads.
        shapes: that its estimators are fitted to; load cases do not count, every other source
            counts alike.

    Raises:
        ReachError: no draw of the loads gives a shape.
    """
    parts = [shapes.of_source(name) for name in dict.fromkeys(shapes.source)]
    stated = [rows for rows in parts if rows.source[0] != CASES]
    if joint.loads is not None and all(rows.source[0] == LOADS for rows in stated):
        return _of_loads(joint, joint.loads)
    states = np.concatenate([rows.state for rows in stated])
    weight = [np.full(len(rows), 1.0 / len(stated) / len(rows)) for rows in stated]
    return _sound(joint, _lengths(joint, states), np.concatenate(weight))


def _of_loads(joint: "Joint", loads: "LoadRanges") -> SoundReadings:
    """Readings at shapes of the joint's loads, the rare ones that alarm among them."""
    from ccgen.shapes.loads.drawn import shapes_at
    from ccgen.shapes.loads.library import loads_library

    drawn = loads_library(replace(joint, loads=replace(loads, samples=max(DRAWS, loads.samples))))
    assert drawn is not None, "the joint states loads"
    lengths = _lengths(joint, drawn.shapes.state)
    sound = _sound(joint, lengths, np.full(len(lengths), 1.0 / len(lengths)))
    groups = [slice(*part) for part in dict.fromkeys(joint.parts) if part[1] - part[0] > 1]
    if not groups:
        return sound
    held = np.concatenate([np.arange(group.start, group.stop) for group in groups])
    matrix = alarm_matrix(sound, groups)[np.ix_(held, held)]
    limits = thresholds(matrix, sound.of(held), joint.false_alarms)
    geometry = joint.geometry

    def read(points: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        rows, valid = shapes_at(
            loads, geometry.sections, geometry.length, geometry.range_of_motion, points.T
        )
        return _lengths(joint, rows.state), valid

    def reach(read: Floats) -> Floats:
        deviation = np.sqrt(_variance(joint, read)[:, held] @ np.square(matrix).T)
        farthest = np.abs(read[:, held] @ matrix.T) + deviation
        return np.asarray((farthest / limits).max(axis=1))

    def enough(read: Floats, weight: Floats) -> bool:
        told = _sound(joint, read, weight).of(held)
        return sharing(matrix, told, joint.false_alarms) >= SHARING

    start, rarest = Visited(drawn.loads.points.T, lengths), _RAREST * joint.false_alarms
    return _sound(joint, *with_tails(start, read, reach, enough, rarest))


def _sound(joint: "Joint", lengths: Floats, weight: Floats) -> SoundReadings:
    return SoundReadings(lengths, _variance(joint, lengths), weight)


def _variance(joint: "Joint", lengths: Floats) -> Floats:
    """Of what readings add to lengths: noise, the step of the counts, gains in their tolerance."""
    tolerance = np.array([sensor.gain_tolerance for sensor in joint.sensors])
    return np.asarray(length_variance(joint) + np.square(tolerance * lengths))


def _lengths(joint: "Joint", states: Floats) -> Floats:
    """Changes of length at states, without bending about an axis that the joint leaves out."""
    kept = states.copy()
    for axis in ("u", "v"):
        if axis not in joint.axes:
            kept[:, joint.rows(axis)] = 0.0
    return length_changes(joint, kept)
