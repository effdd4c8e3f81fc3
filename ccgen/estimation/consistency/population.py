"""What a joint's sensors read while all of them are sound: its shapes, its noise, its tolerances.

The rate of false alarms is that of the tails: a few hundred shapes do not show how far out the
next one lies. Where shapes are drawn from the joint's loads, half of the weight is on those that
estimators are fitted to and half on many more draws of the same loads, so that neither alarms more
than twice as often as stated.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.consistency.sound import SoundReadings
from ccgen.sensing.noise import length_variance
from ccgen.sensing.readings import length_changes

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import Shapes

CASES, LOADS = "cases", "loads"

MORE_DRAWS = 4096


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
    parts = [(shapes.of_source(name), 1.0) for name in dict.fromkeys(shapes.source)]
    stated = [(rows, weight) for rows, weight in parts if rows.source[0] != CASES]
    if joint.loads is not None and all(rows.source[0] == LOADS for rows, _ in stated):
        stated += [(rows, 1.0) for rows in _drawn(joint, bool(stated))]
    total = sum(weight for _, weight in stated)
    states = np.concatenate([rows.state for rows, _ in stated])
    for axis in ("u", "v"):
        if axis not in joint.axes:
            states[:, joint.rows(axis)] = 0.0
    lengths = length_changes(joint, states)
    tolerance = np.array([sensor.gain_tolerance for sensor in joint.sensors])
    return SoundReadings(
        lengths=lengths,
        variance=length_variance(joint) + np.square(tolerance * lengths),
        weight=np.concatenate([np.full(len(r), w / total / len(r)) for r, w in stated]),
    )


def _drawn(joint: "Joint", stated: bool) -> list["Shapes"]:
    """The joint's drawn shapes, unless they are stated already, and many more of them."""
    from ccgen.shapes.loads.library import loads_library

    loads = joint.loads
    if loads is None:
        return []
    more = replace(joint, loads=replace(loads, samples=max(MORE_DRAWS, loads.samples)))
    found = [loads_library(one) for one in ([more] if stated else [joint, more])]
    return [drawn.shapes for drawn in found if drawn is not None]
