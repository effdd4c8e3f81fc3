"""Counts of ideal transducers: of shapes, at random, and at the corners of the declared range.

Counts of shapes that a joint takes show how well the estimate follows; counts without a shape
prove that target and reference model agree wherever they are used.
"""

from collections.abc import Sequence
from itertools import product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import AxisSensors, Joint
from ccgen.sensing.motion import Motion
from ccgen.sensing.readings import Floats, readings

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


def lengths_per_radian(sensors: AxisSensors) -> Floats:
    """Length change in metres per radian of normalised reading, p_j r; shape (n,)."""
    return np.array([(b - a + 1) * sensors.radius for a, b in sensors.spans])


def counts_of(sensors: AxisSensors, angles: Floats) -> Integers:
    """Counts that ideal transducers read at these shapes, zero at the straight pose.

    Args:
        sensors: spans, radius and transducer.
        angles: shape (k, m), rad.

    Returns:
        Shape (k, n).
    """
    return np.rint(length_changes(sensors, angles) / sensors.transducer.metres_per_count).astype(
        np.int64
    )


def length_changes(sensors: AxisSensors, angles: Floats) -> Floats:
    """Changes of length in metres at these shapes; shape (k, n)."""
    return np.asarray(readings(angles, sensors.spans) * lengths_per_radian(sensors))


def counts(joint: Joint, axes: Sequence[DeclaredRange], shapes: Motion) -> Integers:
    """What ideal transducers count at these shapes, clipped to their range.

    Args:
        joint: the joint.
        axes: the declared ranges of the u and of the v sensors.
        shapes: k snapshots.

    Returns:
        Shape (k, nu + nv), u sensors first.
    """
    u, v = axes
    return np.concatenate(
        [_axis_counts(joint.u, u, shapes.u), _axis_counts(joint.v, v, shapes.v)], axis=1
    )


def random_counts(axes: Sequence[DeclaredRange], count: int, seed: int = 0) -> Integers:
    """Counts spread evenly over the whole declared range; shape (count, sum of sensors)."""
    random = np.random.default_rng(seed)
    parts = [
        random.integers(axis.minimum, axis.maximum, (count, axis.sensors), endpoint=True)
        for axis in axes
    ]
    return np.concatenate(parts, axis=1)


def corner_counts(axes: Sequence[DeclaredRange]) -> Integers:
    """Every corner of every axis' declared range, at least once each; shape (k, sum of sensors).

    All axes turn their corners at the same time, for they do not meet in any angle; the last two
    rows are the zeros and the zeros' neighbours.
    """
    rows = 2 ** max(axis.sensors for axis in axes)
    return np.concatenate([_axis_corners(axis, rows) for axis in axes], axis=1)


def _axis_corners(axis: DeclaredRange, rows: int) -> Integers:
    ends = list(zip(axis.minimum.tolist(), axis.maximum.tolist(), strict=True))
    corners = np.array(list(product(*ends)), dtype=np.int64)
    beside = np.minimum(axis.zero + 1, axis.maximum)
    turned = np.resize(corners, (rows, axis.sensors))
    return np.concatenate([turned, axis.zero[None, :], beside[None, :]])


def _axis_counts(sensors: AxisSensors, axis: DeclaredRange, angles: Floats) -> Integers:
    wanted = axis.zero + counts_of(sensors, angles)
    return np.asarray(np.clip(wanted, axis.minimum, axis.maximum), dtype=np.int64)
