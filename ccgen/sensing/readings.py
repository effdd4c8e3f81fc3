"""What sensors read of a shape: length changes, and the normalised readings of equation (5).

A sensor over segments a to b, at distance r from the neutral axis and at angle alpha around it,
measures a length change

    y = sum_i [ r (u_i sin(alpha) - v_i cos(alpha)) + h0 e_i ],    i = a ... b,

exact for constant curvature, with h0 the length of a segment and e_i the elongation, alike within
a section: linear in the state (u, v, e), y = H x. Divided by r and by the number p = b - a + 1 of
its segments it becomes the normalised reading, for the paper's two sets (90 and 180 degrees) the
mean bending angle over the span, in radians.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.double_double import DoubleDouble, matmul, sine_and_versine
from ccgen.errors import InputError
from ccgen.joint.layouts import AnySpans

if TYPE_CHECKING:
    from ccgen.joint import Joint, Sensor

_EXACT = 1e-15
"""Sines and cosines below are those of right angles, off by the rounding of pi."""

Floats = NDArray[np.float64]
SpansLike = AnySpans | NDArray[np.intp]


def readings(angles: ArrayLike, spans: SpansLike) -> Floats:
    """Normalised readings: the mean angle over each span (the entries of equation 8).

    Prefix sums make the work independent of the spans' lengths, so that whole populations of
    placements can be read at once.

    Args:
        angles: segment angles, shape (..., m), radians.
        spans: shape (n, 2), or (*stack, n, 2) for a stack of placements; first and last segment.

    Returns:
        Shape (..., *stack, n), radians.

    Raises:
        InputError: a span is reversed, outside the joint or ends within a segment.
    """
    phi = np.asarray(angles, dtype=np.float64)
    segments = phi.shape[-1]
    first, last = _ends(spans, segments)
    sums = np.zeros((*phi.shape[:-1], segments + 1))
    np.cumsum(phi, axis=-1, out=sums[..., 1:])
    means: Floats = (sums[..., last + 1] - sums[..., first]) / (last - first + 1)
    return means


def exact_readings(angles: Floats, spans: AnySpans) -> DoubleDouble:
    """Normalised readings in twice the precision, for fits; shape (N, n) from angles (N, m).

    Raises:
        InputError: a span is reversed or outside the joint.
    """
    segments = angles.shape[-1]
    first, last = _ends(spans, segments)
    numbers = np.arange(segments)[:, None]
    covered = (numbers >= first) & (numbers <= last)
    return matmul(angles, covered.astype(np.float64)) / (last - first + 1.0)


def reading_matrix(segments: int, spans: AnySpans) -> Floats:
    """Matrix H, shape (n, m), with readings = H @ angles."""
    return readings(np.eye(segments), spans).T


def response(joint: "Joint") -> Floats:
    """Matrix H, shape (n, 2m + S), metres: length changes = H @ state.

    Columns are u of all segments and v of all segments (metres per radian), then the elongation
    of each section (metres per share of its length).
    """
    covered = coverage(joint)
    radius = np.array([sensor.radius for sensor in joint.sensors])
    sine, cosine = np.array([direction(sensor) for sensor in joint.sensors]).T
    sections = np.repeat(np.eye(len(joint.geometry.sections)), joint.geometry.sections, axis=0)
    return np.concatenate(
        [
            (radius * sine)[:, None] * covered,
            -(radius * cosine)[:, None] * covered,
            joint.geometry.segment_length * matmul(covered, sections).hi,
        ],
        axis=1,
    )


def coverage(joint: "Joint") -> Floats:
    """Share of each segment that each sensor covers, 0 to 1; shape (n, m)."""
    base = np.arange(joint.geometry.segments, dtype=np.float64)
    start, end = np.array([(sensor.start, sensor.end) for sensor in joint.sensors]).T
    covered = np.minimum(end[:, None], base + 1.0) - np.maximum(start[:, None], base)
    return np.asarray(np.clip(covered, 0.0, 1.0))


def direction(sensor: "Sensor") -> tuple[float, float]:
    """Sine and cosine of the sensor's angle, exact for right angles."""
    return _direction(sensor.angle)


@lru_cache(maxsize=256)
def _direction(angle: float) -> tuple[float, float]:
    exact_sine, versine = sine_and_versine(DoubleDouble.of(angle))
    sine, cosine = float(exact_sine.hi), float((1 - versine).hi)
    if abs(sine) < _EXACT:
        return 0.0, math.copysign(1.0, cosine)
    if abs(cosine) < _EXACT:
        return math.copysign(1.0, sine), 0.0
    return sine, cosine


def normaliser(joint: "Joint") -> Floats:
    """Length change in metres of a normalised reading of 1, r_j p_j; shape (n,)."""
    return np.array([sensor.segments * sensor.radius for sensor in joint.sensors])


def normalised_response(joint: "Joint") -> Floats:
    """Matrix of the normalised readings, shape (n, 2m + S): readings = it @ state."""
    return np.asarray(response(joint) / normaliser(joint)[:, None])


def length_changes(joint: "Joint", state: ArrayLike) -> Floats:
    """Changes of length at these states.

    Prefix sums along the joint, so that equal spans read the same to the last bit whatever else
    there is to read.

    Args:
        joint: its sensors and geometry.
        state: shape (..., 2m + S), radians and shares of the length.

    Returns:
        Shape (..., n), metres.
    """
    segments, sections = joint.geometry.segments, joint.geometry.sections
    x = np.asarray(state, dtype=np.float64)
    u, v, h = x[..., :segments], x[..., segments : 2 * segments], x[..., 2 * segments :]
    means = [_means(part, joint) for part in (u, v, np.repeat(h, sections, axis=-1))]
    sine, cosine = np.array([direction(sensor) for sensor in joint.sensors]).T
    lengths = np.array([sensor.segments for sensor in joint.sensors])
    bending = (sine * means[0] - cosine * means[1]) * normaliser(joint)
    return np.asarray(bending + joint.geometry.segment_length * lengths * means[2])


def _means(values: Floats, joint: "Joint") -> Floats:
    """Mean over each sensor's span of values a segment, shape (..., n)."""
    sums = np.zeros((*values.shape[:-1], values.shape[-1] + 1))
    np.cumsum(values, axis=-1, out=sums[..., 1:])

    def until(border: Floats) -> Floats:
        whole = np.minimum(np.floor(border).astype(np.intp), values.shape[-1] - 1)
        share = border - whole
        return np.asarray((1.0 - share) * sums[..., whole] + share * sums[..., whole + 1])

    start, end = np.array([(sensor.start, sensor.end) for sensor in joint.sensors]).T
    return np.asarray((until(end) - until(start)) / (end - start))


def _ends(spans: SpansLike, segments: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First and last segments of spans, each of shape (..., n), checked."""
    ends = np.asarray(spans)
    if not (ends == np.rint(ends)).all():
        raise InputError("spans with parts of segments have no mean angle; give whole segments")
    ends = ends.astype(np.intp)
    first, last = ends[..., 0], ends[..., 1]
    wrong = (first < 0) | (last < first) | (last >= segments)
    if wrong.any():
        a, b = ends[wrong][0]
        raise InputError(f"span [{a}, {b}] does not fit; give 0 <= first <= last <= {segments - 1}")
    return first, last
