"""Counts: the ranges that transducers must cover, and the gain from counts to angles."""

from dataclasses import dataclass

import numpy as np

from ccgen.errors import FormatError
from ccgen.estimation import Weights, readings
from ccgen.fixedpoint.model import Floats, Integers
from ccgen.joint import AxisSensors, Joint
from ccgen.shapes import ShapeLibrary

MARGIN = 1.25
"""A range that is not declared covers what the shapes need and a quarter more."""


DIFFERENCE_LIMIT = 2**31 - 1
"""The estimator holds the difference of a count and a zero in 32 bits."""


@dataclass(frozen=True, eq=False)
class CountRange:
    """Declared range of each sensor: shape (n,) counts, both ends included."""

    minimum: Integers
    maximum: Integers

    @property
    def span(self) -> Integers:
        """Largest |count - zero| when both lie in range; shape (n,)."""
        return self.maximum - self.minimum


def lengths_per_radian(sensors: AxisSensors) -> Floats:
    """Length change in metres per radian of normalised reading, p_j r; shape (n,)."""
    return np.array([(b - a + 1) * sensors.radius for a, b in sensors.spans])


def count_gains(weights: Weights, sensors: AxisSensors) -> Floats:
    """Angle in rad per count, shape (m, n): eq. (5) with eqs. (1), (2) folded in."""
    step = sensors.transducer.metres_per_count
    return weights.matrix * (step / lengths_per_radian(sensors))


def counts_of(sensors: AxisSensors, angles: Floats) -> Integers:
    """Counts that ideal transducers read at these shapes, zero at the straight pose.

    Args:
        sensors: spans, radius and transducer.
        angles: shape (k, m), rad.

    Returns:
        Shape (k, n).
    """
    lengths = readings(angles, sensors.spans) * lengths_per_radian(sensors)
    return np.rint(lengths / sensors.transducer.metres_per_count).astype(np.int64)


def count_range(joint: Joint, axis: str, library: ShapeLibrary) -> CountRange:
    """Range of each sensor's counts: as declared, or what the library needs and a quarter more.

    Raises:
        FormatError: the transducer's bits or its declared range do not hold the shapes; the
            message names the sensor.
    """
    sensors = joint.axis(axis)
    transducer = sensors.transducer
    limit = 2 ** (transducer.bits - 1) - 1
    needed = np.abs(counts_of(sensors, library.angles)).max(axis=0)
    if transducer.range is not None:
        return _declared_range(joint, axis, needed, *transducer.range)
    wanted = np.ceil(needed * MARGIN).astype(np.int64)
    for j, (a, b) in enumerate(sensors.spans):
        if wanted[j] > limit:
            step = transducer.metres_per_count * float(wanted[j]) / limit
            raise FormatError(
                f"{joint.source}: sensors.transducer.metres_per_count: sensor {j} of axis {axis} "
                f"(span [{a}, {b}]) needs counts of ±{wanted[j]}, {transducer.bits} bits hold "
                f"±{limit}; use at least {step:.3g} m per count"
                + (" or fixed_point.precision = 32" if joint.precision == 16 else "")
            )
        if wanted[j] == 0:
            raise FormatError(
                f"{joint.source}: sensors.transducer.metres_per_count: sensor {j} of axis {axis} "
                f"(span [{a}, {b}]) moves less than half a count over the range of motion; "
                f"use a finer transducer"
            )
    return CountRange(-wanted, wanted)


def _declared_range(joint: Joint, axis: str, needed: Integers, low: int, high: int) -> CountRange:
    j = int(np.argmax(needed))
    a, b = joint.axis(axis).spans[j]
    sensor = f"{joint.source}: sensors.transducer.range: sensor {j} of axis {axis} (span [{a}, {b}]"
    if needed[j] > min(-low, high):
        raise FormatError(
            f"{sensor}) reaches ±{needed[j]} counts over the range of motion, [{low}, {high}] "
            f"does not; widen it or raise sensors.transducer.metres_per_count"
        )
    if high - low > DIFFERENCE_LIMIT:
        raise FormatError(
            f"{sensor}) is {high - low} counts wide, the 32-bit difference of a count and a zero "
            f"holds {DIFFERENCE_LIMIT}; narrow it"
        )
    return CountRange(np.full_like(needed, low), np.full_like(needed, high))
