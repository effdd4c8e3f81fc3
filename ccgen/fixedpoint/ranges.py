"""Counts: the ranges that transducers must cover, and the gain from counts to angles."""

from dataclasses import dataclass

import numpy as np

from ccgen.digits import at_least, at_most
from ccgen.errors import FormatError
from ccgen.estimation import Weights
from ccgen.fixedpoint.model import Floats, Integers
from ccgen.joint import AxisSensors, Joint
from ccgen.sensing.counts import counts_of, length_changes, lengths_per_radian
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


def count_gains(weights: Weights, sensors: AxisSensors) -> Floats:
    """Angle in rad per count, shape (m, n): eq. (5) with eqs. (1), (2) folded in."""
    step = sensors.transducer.metres_per_count
    return weights.matrix * (step / lengths_per_radian(sensors))


def count_range(joint: Joint, axis: str, library: ShapeLibrary) -> CountRange:
    """Range of each sensor's counts: as declared, or what the library needs and a quarter more.

    Raises:
        FormatError: the transducer's bits or its declared range do not hold the shapes; the
            message names the sensor.
    """
    sensors = joint.axis(axis)
    needed = np.abs(counts_of(sensors, library.angles)).max(axis=0)
    if sensors.transducer.range is not None:
        return _declared_range(joint, axis, needed, *sensors.transducer.range)
    wanted = np.ceil(needed * MARGIN).astype(np.int64)
    moves = np.abs(length_changes(sensors, library.angles)).max(axis=0)
    most, least = int(np.argmax(moves)), int(np.argmin(moves))
    if wanted[most] > _count_limit(sensors.transducer.bits):
        raise FormatError(_too_fine(joint, axis, most, int(wanted[most]), float(moves[most])))
    if wanted[least] == 0:
        raise FormatError(
            f"{sensor_place(joint, axis, 'metres_per_count', least)} moves less than half a count "
            f"over the range of motion; use at most {at_most(float(moves[least]))} m per count"
        )
    return CountRange(-wanted, wanted)


def _count_limit(bits: int) -> int:
    """Largest count of a range that is as wide on both sides of 0."""
    return int(min(2 ** (bits - 1) - 1, DIFFERENCE_LIMIT // 2))


def _too_fine(joint: Joint, axis: str, j: int, wanted: int, move: float) -> str:
    """What is wrong with a sensor that needs more counts than there are, and the remedies."""
    bits, limit = joint.axis(axis).transducer.bits, _count_limit(joint.axis(axis).transducer.bits)
    remedies = []
    if limit > MARGIN:
        remedies.append(f"at least {at_least(move / int(limit / MARGIN))} m per count")
    enough = next((b for b in range(bits + 1, 33) if wanted <= _count_limit(b)), None)
    if enough is not None:
        widen = " with fixed_point.precision = 32" if enough > joint.precision else ""
        remedies.append(f"bits = {enough}{widen}")
    return (
        f"{sensor_place(joint, axis, 'metres_per_count', j)} needs counts of ±{wanted}, "
        f"{bits} bits hold ±{limit}{' and their differences' if bits == 32 else ''}; "
        f"use {' or '.join(remedies)}"
    )


def _declared_range(joint: Joint, axis: str, needed: Integers, low: int, high: int) -> CountRange:
    j = int(np.argmax(needed))
    sensor = sensor_place(joint, axis, "range", j)
    if needed[j] > min(-low, high):
        raise FormatError(
            f"{sensor} reaches ±{needed[j]} counts over the range of motion, [{low}, {high}] "
            f"does not; widen it or raise metres_per_count"
        )
    if high - low > DIFFERENCE_LIMIT:
        raise FormatError(
            f"{sensor} is {high - low} counts wide, the 32-bit difference of a count and a zero "
            f"holds {DIFFERENCE_LIMIT}; narrow it"
        )
    return CountRange(np.full_like(needed, low), np.full_like(needed, high))


def sensor_place(joint: Joint, axis: str, key: str, j: int) -> str:
    """Where a sensor's key stands, and which sensor it is."""
    sensors = joint.axis(axis)
    a, b = sensors.spans[j]
    place = f"{joint.source}: {sensors.transducer.key(axis, key)}"
    return f"{place}: sensor {j} of axis {axis} (span [{a}, {b}])"
