"""Choice of the fixed-point format by proof, and the model in that format.

An angle of 1 rad is 2^f; an accumulator of 1 rad is 2^(f + shift). The fraction bits f are the
most with which the shapes and a quarter more fit the angle's width: nothing that a sound joint
does saturates. The shift is the largest for which every weight fits its width and the accumulator
cannot overflow, whatever the counts and zeros in range; nor can it one step lower, where kernels
begin that saturate.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ccgen.double_double import matmul
from ccgen.errors import FormatError
from ccgen.estimation import Weights, in_the_papers_way
from ccgen.fixedpoint import bounds
from ccgen.fixedpoint.model import (
    AxisModel,
    FixedPointModel,
    Floats,
    Integers,
    SensorRanges,
)
from ccgen.fixedpoint.ranges import MARGIN, SensorPlace, count_gains, symmetric_ranges
from ccgen.fixedpoint.relative import relative_ranges
from ccgen.joint import Joint
from ccgen.sensing.counts import counts_of
from ccgen.shapes import Shapes


@dataclass(frozen=True, eq=False)
class _Format:
    """Weights and bias in one format, and what is proven of it."""

    fraction_bits: int
    shift: int
    weights: Integers
    bias: Integers
    accumulator: int
    weight_error: Fraction

    @property
    def largest_angle(self) -> int:
        return -(-self.accumulator >> self.shift)  # a negative one is rounded away from 0


@dataclass(frozen=True, eq=False)
class _Axis:
    """One axis before quantisation: rad per count, intercept in rad, largest |count - zero|."""

    gains: Floats
    intercept: Floats
    span: Integers
    precision: int

    @property
    def angle_limit(self) -> int:
        return int(2 ** (self.precision - 1) - 1)


def quantise(joint: Joint, weights: Mapping[str, Weights], shapes: Shapes) -> FixedPointModel:
    """Fixed-point model of all output axes in the joint's precision.

    Args:
        joint: the specification.
        weights: by output axis.
        shapes: that the sensors must follow; sets undeclared ranges and the angle's format.

    Raises:
        FormatError: no format fits; names the sensor, the key and the remedy.
    """
    models = {axis: quantise_axis(joint, axis, weights[axis], shapes) for axis in joint.axes}
    return FixedPointModel(joint.name, joint.precision, models)


def quantise_axis(
    joint: Joint, name: str, weights: Weights, shapes: Shapes, coarser: int = 0
) -> AxisModel:
    """Fixed-point model of one output axis.

    Args:
        joint: the specification.
        name: of the axis.
        weights: of that axis.
        shapes: as of `quantise`.
        coarser: bits of the largest shift to give up, for larger weights beside these.

    Raises:
        FormatError: as of `quantise`.
    """
    ranges = sensor_ranges(joint, name, shapes)
    axis = _Axis(count_gains(joint, name, weights), weights.intercept, ranges.span, joint.precision)
    counts = counts_of(joint, shapes)[:, joint.own(name)]
    ideal = (matmul(counts, axis.gains.T) + axis.intercept).hi
    best = _choose(axis, float(np.abs(ideal).max()))
    if best is not None and coarser:
        best = _format(axis, best.fraction_bits, max(best.shift - coarser, 0))
    if best is None:
        raise FormatError(_no_format(joint, name, ranges.span))
    percent = 100.0 / (1.0 if name == "h" else joint.geometry.range_of_motion)
    angles = (counts @ best.weights.T + best.bias) >> best.shift
    angles = np.clip(angles, -axis.angle_limit, axis.angle_limit)
    return AxisModel(
        axis=name,
        precision=joint.precision,
        weights=best.weights,
        bias=best.bias,
        shift=best.shift,
        fraction_bits=best.fraction_bits,
        minimum=ranges.minimum,
        maximum=ranges.maximum,
        zero=ranges.zero,
        saturates=best.largest_angle > axis.angle_limit,
        headroom_bits=bounds.headroom_bits(best.accumulator, 2 * joint.precision),
        worst_error_percent_rom=percent
        * float(best.weight_error + bounds.rounding_error(best.shift, best.fraction_bits)),
        rms_error_percent_rom=percent
        * bounds.rms(np.ldexp(angles.astype(np.float64), -best.fraction_bits) - ideal),
        first=joint.own(name).start,
        relative=ranges.relative,
    )


def sensor_ranges(joint: Joint, axis: str, shapes: Shapes) -> SensorRanges:
    """Symmetric ranges for the paper's sets; for all else ranges around a zero of their own.

    Raises:
        FormatError: the counts of a sensor do not hold the shapes.
    """
    plain = all(sensor.signed and sensor.zero is None for sensor in joint.sensors)
    if plain and in_the_papers_way(joint):
        return symmetric_ranges(joint, axis, shapes)
    return relative_ranges(joint, axis, shapes)


def _no_format(joint: Joint, axis: str, span: Integers) -> str:
    j = int(np.argmax(span))
    return (
        f"{SensorPlace(joint, axis, j).said('range')} is {span[j]} counts wide and leaves "
        f"no {joint.precision}-bit format for the weights; narrow the range"
        + ("" if joint.precision == 32 else " or use precision = 32")
    )


def _choose(axis: _Axis, largest_shape: float) -> _Format | None:
    """The finest format that holds this angle (rad) and a quarter more, if any does."""
    # The largest f with 2^f <= the quotient, exact at powers of two.
    finest = math.frexp(axis.angle_limit / (MARGIN * largest_shape))[1] - 1
    candidates = (_format(axis, fraction_bits) for fraction_bits in range(finest, -1, -1))
    return next((found for found in candidates if found is not None), None)


def _format(axis: _Axis, fraction_bits: int, most: int | None = None) -> _Format | None:
    """The largest shift, at most `most`, for which weights and accumulator fit, if any does."""
    weight_limit = 2 ** (axis.precision - 1) - 1
    accumulator_limit = 2 ** (2 * axis.precision - 1) - 1
    largest = 2 * axis.precision - 1 if most is None else most
    for shift in range(largest, -1, -1):
        scale = fraction_bits + shift
        rounded = np.rint(np.ldexp(axis.gains, scale))
        if np.abs(rounded).max() > weight_limit:
            continue
        offsets = [round(Fraction(float(c)) * Fraction(2) ** scale) for c in axis.intercept]
        half = 1 << (shift - 1) if shift else 0
        weights = rounded.astype(np.int64)
        bias = np.array([o + half for o in offsets], dtype=np.int64)
        accumulator = bounds.largest_accumulator(weights, bias, axis.span)
        if accumulator + (1 << shift) <= accumulator_limit:
            error = bounds.weight_error(
                axis.gains, axis.intercept, weights, offsets, scale, axis.span
            )
            return _Format(fraction_bits, shift, weights, bias, accumulator, error)
    return None
