"""From counts to shapes in double precision: what the fitted weights make of readings."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.errors import ArgumentError
from ccgen.estimation.weights import Floats, Weights
from ccgen.joint import Joint, Sensor
from ccgen.joint.specification import count_limits
from ccgen.kinematics import tip_pose
from ccgen.sensing.readings import normaliser
from ccgen.sensing.simulation import segment_lengths

Serving = Callable[[str, int], Weights | None]
"""Weights that serve for an axis while sensor j, of those that it reads, gives no reading.

None where the axis is lost without it. Called only where such a reading is missing.
"""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimated states of a joint of m segments and S sections; N rows, read-only.

    An axis that is not estimated does not move: it is 0. What missing readings make unknown is NaN.

    Attributes:
        u: bending about x, shape (N, m), radians.
        v: bending about y, shape (N, m), radians.
        h: elongation of each section, shape (N, S), share of its length.
        tip: position of the tip in the base frame, shape (N, 3), metres.
    """

    u: Floats
    v: Floats
    h: Floats
    tip: Floats

    def __post_init__(self) -> None:
        for array in (self.u, self.v, self.h, self.tip):
            array.setflags(write=False)


def estimate(
    joint: Joint,
    sensors: Sequence[Sensor],
    weights: Mapping[str, Weights],
    serving: Serving,
    counts: ArrayLike,
) -> Estimate:
    """Estimate a joint's state from counts.

    Where one sensor of an axis gives no reading, weights without it serve; where two or more do
    not, the axis is lost.

    Args:
        joint: the joint.
        sensors: its n sensors, with the gains and zeros that hold.
        weights: of each axis that is estimated, on normalised readings.
        serving: what serves in their place.
        counts: shape (N, n), in the joint's order of sensors; NaN where there is no reading, as
            is a count that the transducer cannot give.

    Raises:
        ArgumentError: another form, or lengths in the place of counts.
    """
    readings = normalised_readings(joint, sensors, checked_counts(sensors, counts))
    rows, geometry = len(readings), joint.geometry
    parts = {"u": np.zeros((rows, geometry.segments)), "v": np.zeros((rows, geometry.segments))}
    parts["h"] = np.zeros((rows, len(geometry.sections)))
    for axis, fitted in weights.items():
        parts[axis] = _served(axis, fitted, serving, readings[:, joint.own(axis)])
    poses = tip_pose(parts["u"], parts["v"], segment_lengths(joint, parts["h"]))
    return Estimate(**parts, tip=poses[:, :3, 3].copy())


def _served(axis: str, weights: Weights, serving: Serving, readings: Floats) -> Floats:
    """Values of an axis, shape (N, m or S), from the readings of its sensors, shape (N, n)."""
    values = weights.estimate(readings)  # NaN wherever a reading is
    missing = np.isnan(readings)
    alone = missing & (missing.sum(axis=1) == 1)[:, None]
    for j in np.flatnonzero(alone.any(axis=0)).tolist():
        without = serving(axis, j)
        if without is not None:
            rows = alone[:, j]
            values[rows] = without.estimate(np.where(missing[rows], 0.0, readings[rows]))
    return values


def normalised_readings(joint: Joint, sensors: Sequence[Sensor], counts: Floats) -> Floats:
    """Readings (l - l0) / (r p) of counts, shape (N, n), radians; NaN where there is none."""
    zero = np.array([sensor.zero or 0 for sensor in sensors], dtype=np.float64)
    step = np.array([sensor.metres_per_count for sensor in sensors])
    limits = [sensor.range or count_limits(sensor.bits, sensor.signed) for sensor in sensors]
    low, high = np.array(limits, dtype=np.float64).T
    given = np.where((counts >= low) & (counts <= high), counts, np.nan)
    return np.asarray((given - zero) * (step / normaliser(joint)))


def checked_counts(sensors: Sequence[Sensor], counts: ArrayLike) -> Floats:
    """Counts as an array, shape (N, n).

    Raises:
        ArgumentError: another form, or lengths in the place of counts.
    """
    names = ", ".join(sensor.name for sensor in sensors)
    try:
        values: NDArray[np.float64] = np.asarray(counts, dtype=np.float64)
    except (TypeError, ValueError):
        raise ArgumentError(
            f"are no array of numbers; give counts of {names}, shape (N, {len(sensors)})", "counts"
        ) from None
    if values.ndim != 2 or values.shape[1] != len(sensors):
        raise ArgumentError(
            f"have shape {values.shape}, not (N, {len(sensors)}); give a row for each snapshot, in "
            f"the order {names}",
            "counts",
        )
    known = values[np.isfinite(values)]
    if known.size and np.abs(known).max() < 1.0 and known.any():
        raise ArgumentError(
            f"are all below 1, as lengths in metres would be ({known[known != 0][0]:.4g}); give "
            "what the transducers count, lengths over metres_per_count",
            "counts",
        )
    return values
