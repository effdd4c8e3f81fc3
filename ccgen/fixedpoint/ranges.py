"""Counts: the ranges that transducers must cover, and the gain from counts to angles."""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from ccgen.digits import at_least, at_most
from ccgen.errors import FormatError
from ccgen.estimation import Weights
from ccgen.fixedpoint.model import Floats, RelativeRange, SensorRanges
from ccgen.joint import AXES, Joint, Sensor
from ccgen.joint.places import sensor_key
from ccgen.sensing.counts import counts_of
from ccgen.sensing.readings import length_changes, normaliser
from ccgen.shapes import Shapes, bent_alike

MARGIN = 1.25
"""A range that is not declared covers what the shapes need and a quarter more."""

DIFFERENCE_LIMIT = 2**31 - 1
"""The estimator holds the difference of a count and a zero in 32 bits."""


def at_range(joint: Joint) -> Shapes:
    """The joint bent as far as it goes, to either side in both axes at once, and stretched so."""
    geometry = joint.geometry
    if not joint.couples:
        farthest = np.full(geometry.segments, geometry.range_of_motion)
        bends = np.array([farthest, -farthest])
        return bent_alike(bends, len(geometry.sections), "range of motion")
    both = (-geometry.range_of_motion, geometry.range_of_motion)
    sides = [both if axis in joint.axes else (0.0,) for axis in AXES]
    corners = np.array(list(product(*sides, geometry.elongation or (0.0,))))
    columns = (geometry.segments, geometry.segments, len(geometry.sections))
    u, v, h = (np.outer(corners[:, k], np.ones(count)) for k, count in enumerate(columns))
    return Shapes(u, v, h, ("range of motion",) * len(corners))


def count_gains(joint: Joint, axis: str, weights: Weights) -> Floats:
    """Angle in rad per count, shape (m, n): eq. (5) with eqs. (1), (2) folded in."""
    return weights.matrix * reading_per_count(joint, axis)


def reading_per_count(joint: Joint, axis: str) -> Floats:
    """Normalised reading that a count of each sensor of an axis is worth, shape (n,), radians."""
    own = joint.own(axis)
    step = np.array([sensor.metres_per_count for sensor in joint.sensors[own]])
    return np.asarray(step / normaliser(joint)[own])


def symmetric_ranges(joint: Joint, axis: str, shapes: Shapes) -> SensorRanges:
    """Counts of signed sensors that are 0 where the joint is straight, and the zeros they may have.

    A zero is accepted where the shapes around it stay within the counts of a reading, so that every
    reading with every such zero is one. Counts are as declared; else they hold the shapes with a
    zero that is off by three quarters of what they need, as far as the transducer has counts.

    Raises:
        FormatError: the transducer's bits or its declared range do not hold the shapes; the
            message names the sensor.
    """
    own = joint.own(axis)
    needed = np.abs(counts_of(joint, shapes)).max(axis=0)[own]
    moves = np.abs(length_changes(joint, shapes.state)).max(axis=0)[own]
    ends = np.zeros((needed.size, 5), dtype=np.int64)
    for j in np.argsort(-moves, kind="stable"):  # messages name the sensor that moves most
        place = SensorPlace(joint, axis, int(j))
        ends[j] = place.range(int(needed[j]), float(moves[j]))
    for j in np.argsort(moves, kind="stable"):  # and that which moves least
        if not needed[j]:
            raise FormatError(
                f"{SensorPlace(joint, axis, int(j)).said('metres_per_count')} moves less than half "
                f"a count over the range of motion; use at most {at_most(float(moves[j]))} m per "
                "count"
            )
    low, high, zero_low, zero_high, span = ends.T
    return SensorRanges(
        low, high, np.zeros_like(low), RelativeRange(-span, span, zero_low, zero_high)
    )


def _count_limit(bits: int) -> int:
    """Largest count of a range that is as wide on both sides of 0."""
    return int(min(2 ** (bits - 1) - 1, DIFFERENCE_LIMIT // 2))


@dataclass(frozen=True)
class SensorPlace:
    """Sensor j of those that an output axis reads, for messages."""

    joint: Joint
    axis: str
    j: int

    @property
    def sensor(self) -> Sensor:
        """The sensor itself."""
        return self.joint.sensors[self.joint.own(self.axis)][self.j]

    def said(self, key: str) -> str:
        """Where a key of the sensor stands, and which sensor it is."""
        place = sensor_key(self.joint, self.joint.own(self.axis).start + self.j, key)
        return f"{self.joint.source}: {place}: {self.which}"

    @property
    def which(self) -> str:
        """Which sensor it is."""
        first, last = self.sensor.start, self.sensor.end - 1
        if self.joint.u is not None or self.joint.v is not None:
            return f"sensor {self.j} of axis {self.sensor.name[0]} (span [{first:g}, {last:g}])"
        return f"sensor {self.sensor.name}"

    def range(self, needed: int, move: float) -> tuple[int, int, int, int, int]:
        """Ends of the sensor's counts, of its zeros, and the most by which they may differ.

        Args:
            needed: largest count of the shapes.
            move: largest change of length, metres.

        Raises:
            FormatError: the transducer's bits or the declared range do not hold it.
        """
        if self.sensor.range is not None:
            return self._declared(needed, *self.sensor.range)
        wanted = math.ceil(needed * MARGIN)
        limit = _count_limit(self.sensor.bits)
        if wanted > limit:
            raise FormatError(self._too_fine(wanted, move))
        high = min((2 * wanted + needed) // 2, limit)
        zero = min(high - needed, 2 * wanted - high)
        return -high, high, -zero, zero, 2 * wanted

    def _declared(self, needed: int, low: int, high: int) -> tuple[int, int, int, int, int]:
        if needed > min(-low, high):
            raise FormatError(
                f"{self.said('range')} reaches ±{needed} counts over the range of motion, "
                f"[{low}, {high}] does not; widen it or raise metres_per_count"
            )
        if high - low > DIFFERENCE_LIMIT:
            raise FormatError(
                f"{self.said('range')} is {high - low} counts wide, the 32-bit difference of a "
                f"count and a zero holds {DIFFERENCE_LIMIT}; narrow it"
            )
        return low, high, low + needed, high - needed, high - low

    def _too_fine(self, wanted: int, move: float) -> str:
        """What is wrong with a sensor that needs more counts than there are, and the remedies."""
        bits, limit = self.sensor.bits, _count_limit(self.sensor.bits)
        remedies = []
        if limit > MARGIN:
            remedies.append(f"at least {at_least(move / int(limit / MARGIN))} m per count")
        enough = next((b for b in range(bits + 1, 33) if wanted <= _count_limit(b)), None)
        if enough is not None:
            widen = " with fixed_point.precision = 32" if enough > self.joint.precision else ""
            remedies.append(f"bits = {enough}{widen}")
        return (
            f"{self.said('metres_per_count')} needs counts of ±{wanted}, {bits} bits hold "
            f"±{limit}{' and their differences' if bits == 32 else ''}; "
            f"use {' or '.join(remedies)}"
        )
