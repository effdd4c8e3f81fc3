"""Counts of ideal transducers: of shapes, at random, and at the corners of the declared range.

Counts of shapes that a joint takes show how well the estimate follows; counts without a shape
prove that target and reference model agree wherever they are used.
"""

from collections.abc import Sequence
from itertools import product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint, Sensor
from ccgen.joint.specification import count_limits
from ccgen.sensing.readings import length_changes
from ccgen.shapes import Shapes

Integers = NDArray[np.int64]


class DeclaredRange(Protocol):
    """What sensors of an axis may count: minimum, maximum and zero, shape (n,) each."""

    @property
    def minimum(self) -> Integers:
        """Lowest counts."""

    @property
    def maximum(self) -> Integers:
        """Highest counts."""

    @property
    def zero(self) -> Integers:
        """Counts at the straight pose."""

    @property
    def sensors(self) -> int:
        """Number n of sensors."""


def counts_of(joint: Joint, shapes: Shapes) -> Integers:
    """Counts that ideal transducers read at these shapes, zero at the straight pose.

    Returns:
        Shape (k, n) for k shapes, in the joint's order of sensors.
    """
    step = np.array([sensor.metres_per_count for sensor in joint.sensors])
    return np.asarray(np.rint(length_changes(joint, shapes.state) / step), dtype=np.int64)


def raw_counts(joint: Joint, shapes: Shapes) -> Integers:
    """Counts that ideal transducers give, with their zeros; nominal ones where none is stated.

    Returns:
        As `counts_of`.
    """
    zeros = np.array([nominal_zero(sensor) for sensor in joint.sensors], dtype=np.int64)
    return np.asarray(counts_of(joint, shapes) + zeros)


def nominal_zero(sensor: Sensor) -> int:
    """The stated zero; else 0, or the middle of counts that do not reach to either side of it."""
    if sensor.zero is not None:
        return sensor.zero
    low, high = sensor.range or count_limits(sensor.bits, sensor.signed)
    return 0 if low < 0 < high else (low + high) // 2


def within(sensor: Sensor, count: int) -> bool:
    """Whether the transducer gives a count as a reading."""
    low, high = sensor.range or count_limits(sensor.bits, sensor.signed)
    return low <= count <= high


def counts(joint: Joint, axes: Sequence[DeclaredRange], shapes: Shapes) -> Integers:
    """What ideal transducers count at these shapes, clipped to their range.

    Args:
        joint: the joint.
        axes: the declared ranges of the u and of the v sensors.
        shapes: k snapshots.

    Returns:
        Shape (k, n), in the joint's order of sensors.
    """
    zero, low, high = (
        np.concatenate([getattr(axis, name) for axis in axes])
        for name in ("zero", "minimum", "maximum")
    )
    return np.asarray(np.clip(zero + counts_of(joint, shapes), low, high), dtype=np.int64)


def random_counts(axes: Sequence[DeclaredRange], count: int, seed: int = 0) -> Integers:
    """Counts spread evenly over the whole declared range; shape (count, sum of sensors)."""
    random = np.random.default_rng(seed)
    parts = [
        random.integers(axis.minimum, axis.maximum, (count, axis.sensors), endpoint=True)
        for axis in axes
    ]
    return np.concatenate(parts, axis=1)


def corner_counts(axes: Sequence[DeclaredRange]) -> Integers:
    """Corners of every axis' declared range, at least once each; shape (k, sum of sensors).

    All corners of up to 8 sensors; of more, so many that the ends of any three of them meet in
    every combination, and each sensor alone at either end. All axes turn their corners at the same
    time, for they do not meet in any angle; the last two rows are the zeros and the zeros'
    neighbours.
    """
    chosen = [_upper_ends(axis.sensors) for axis in axes]
    rows = max(len(one) for one in chosen)
    return np.concatenate(
        [_axis_corners(axis, upper, rows) for axis, upper in zip(axes, chosen, strict=True)], axis=1
    )


_ALL_CORNERS = 8
"""Sensors of which all corners are taken."""


def _upper_ends(sensors: int) -> NDArray[np.bool_]:
    """Which sensors are at the upper end of their range, shape (k, sensors)."""
    if sensors <= _ALL_CORNERS:
        return np.array(list(product((False, True), repeat=sensors)))
    # Parities of the bits of 2 j + 1 in each row's number: columns of which any three are
    # independent over GF(2), an orthogonal array of strength three (Rao 1947).
    columns = 2 * np.arange(sensors) + 1
    bits = int(columns[-1]).bit_length()
    shared = np.arange(2**bits)[:, None] & columns
    parity = np.bitwise_xor.reduce([shared >> k & 1 for k in range(bits)], axis=0)
    alone = np.eye(sensors, dtype=bool)
    return np.concatenate([parity.astype(bool), alone, ~alone])


def _axis_corners(axis: DeclaredRange, upper: NDArray[np.bool_], rows: int) -> Integers:
    corners = np.where(upper, axis.maximum, axis.minimum)
    beside = np.minimum(axis.zero + 1, axis.maximum)
    turned = np.resize(corners, (rows, axis.sensors))
    return np.concatenate([turned, axis.zero[None, :], beside[None, :]])
