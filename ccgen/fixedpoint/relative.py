"""Ranges relative to a zero that may be captured anywhere the range of motion still fits.

A reading lies within what the shapes need and a quarter more of its zero; a zero is accepted where
the shapes, without that quarter, stay within the transducer's counts.
"""

import math
from dataclasses import dataclass

import numpy as np

from ccgen.digits import at_least, at_most
from ccgen.errors import FormatError
from ccgen.fixedpoint.model import Floats, Integers, RelativeRange, SensorRanges
from ccgen.fixedpoint.ranges import DIFFERENCE_LIMIT, MARGIN, SensorPlace
from ccgen.joint import Joint
from ccgen.joint.specification import CALIBRATED, STATED, count_limits
from ccgen.sensing.counts import nominal_zero
from ccgen.sensing.readings import length_changes
from ccgen.shapes import Shapes


def relative_ranges(joint: Joint, axis: str, shapes: Shapes) -> SensorRanges:
    """Counts, zeros and relative ranges of the sensors that an output axis reads.

    Args:
        joint: its sensors.
        axis: an output axis.
        shapes: that the sensors must follow, and their mirror images.

    Raises:
        FormatError: the transducer's counts do not hold the shapes, or not around the stated zero;
            names the sensor, the key and the remedy.
    """
    own = joint.own(axis)
    needs = [need[own] for need in _needed(joint, shapes)]
    found = [
        _sensor_range(SensorPlace(joint, axis, j), float(low), float(high))
        for j, (low, high) in enumerate(zip(*needs, strict=True))
    ]
    table: Integers = np.array(found, dtype=np.int64)
    low, high, zero = table[:, :3].T
    return SensorRanges(low, high, zero, RelativeRange(*table[:, 3:].T))


def _needed(joint: Joint, shapes: Shapes) -> tuple[Floats, Floats]:
    """Lowest and highest difference of each sensor's count and its zero, shape (n,), 0 included.

    A joint bends to either side alike, so that every bend comes with its mirror image; elongation
    has a direction.
    """
    step = np.array([sensor.metres_per_count for sensor in joint.sensors])
    straight = shapes.state
    bent = straight.copy()
    bent[:, joint.rows("h")] = 0.0
    bends = np.abs(length_changes(joint, bent) / step)
    straight[:, : joint.rows("h").start] = 0.0
    stretches = length_changes(joint, straight) / step
    low = np.minimum((stretches - bends).min(axis=0), 0.0)
    high = np.maximum((stretches + bends).max(axis=0), 0.0)
    return low, high


@dataclass(frozen=True)
class _Counts:
    """Lowest and highest count of a transducer."""

    low: int
    high: int


def _sensor_range(place: SensorPlace, low: float, high: float) -> tuple[int, ...]:
    """Lowest and highest count and zero; then the relative range and the ends of its zeros."""
    sensor = place.sensor
    counts = _Counts(*(sensor.range or count_limits(sensor.bits, sensor.signed)))
    if max(-low, high) < 0.5:
        most = at_most(abs(sensor.metres_per_count) * 2.0 * max(-low, high))
        raise FormatError(
            f"{place.said('metres_per_count')} moves less than half a count over the range of "
            f"motion; use at most {most} m per count"
        )
    zeros = _Counts(counts.low - math.floor(low), counts.high - math.ceil(high))
    farthest = math.ceil(max(-low, high))
    if zeros.low > zeros.high or farthest > DIFFERENCE_LIMIT:
        raise FormatError(_too_few(place, math.ceil(high) - math.floor(low), farthest, counts))
    zero = _zero(place, zeros)
    far = _Counts(math.floor(low * MARGIN), math.ceil(high * MARGIN))
    if sensor.range is not None:  # what is declared counts as a reading, however far
        far = _Counts(min(far.low, counts.low - zero), max(far.high, counts.high - zero))
    # A difference of 32-bit counts that 32 bits do not hold is no reading.
    far = _Counts(max(far.low, -DIFFERENCE_LIMIT), min(far.high, DIFFERENCE_LIMIT))
    return counts.low, counts.high, zero, far.low, far.high, zeros.low, zeros.high


def _zero(place: SensorPlace, zeros: _Counts) -> int:
    """The stated zero; else what is nearest to the nominal one of those that may be one."""
    stated = place.sensor.zero
    if stated is None:
        return max(zeros.low, min(nominal_zero(place.sensor), zeros.high))
    if not zeros.low <= stated <= zeros.high:
        raise FormatError(_runs_out(place, stated, zeros))
    return stated


def _runs_out(place: SensorPlace, zero: int, zeros: _Counts) -> str:
    """What is wrong with a zero, and the remedy: one that was measured is no number to choose."""
    short = "would run out of counts over the range of motion with its zero at"
    joint, origin = place.joint, place.sensor.zero_origin
    if origin == STATED:
        return f"{place.said('zero')} {short} {zero}; write a zero from {zeros.low} to {zeros.high}"
    told, again = "the recordings tell", "record it again"
    if origin == CALIBRATED:
        told, again = f"{joint.calibration} tells", f"run `ccgen calibrate {joint.source}` again"
    return (
        f"{joint.source}: {origin}: {place.which} {short} {zero}, as {told}; set the sensor so "
        f"that it counts {zeros.low} to {zeros.high} where the joint is straight and {again}, or "
        "lower geometry.range_of_motion"
    )


def _too_few(place: SensorPlace, needed: int, farthest: int, counts: _Counts) -> str:
    have = counts.high - counts.low
    share = max(needed / have, farthest / DIFFERENCE_LIMIT)
    coarser = at_least(abs(place.sensor.metres_per_count) * share)
    return (
        f"{place.said('metres_per_count')} needs {needed} counts over the range of motion and has "
        f"{have}; use at least {coarser} m per count, or more bits"
    )
