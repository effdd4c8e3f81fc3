"""What every estimation method yields: a weight matrix, applied to normalised readings.

A sensor over segments a to b measures a length change r * (phi_a + ... + phi_b), where r is its
distance from the neutral axis. Divided by r and by the number p = b - a + 1 of its segments it
becomes the normalised reading of equation (5), here the mean bending angle over the span, in
radians. Length changes are used, never lengths: a fit on lengths would hide an intercept in the
weights.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.errors import InputError
from ccgen.layouts import Spans

Floats = NDArray[np.float64]
SpansLike = Spans | NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Weights:
    """Linear estimator of one bending axis: angles = matrix @ readings + intercept.

    Attributes:
        method: name of the method that made it.
        spans: the n sensors' spans.
        matrix: shape (m segments, n sensors), dimensionless.
        intercept: shape (m,), radians.
    """

    method: str
    spans: Spans
    matrix: Floats
    intercept: Floats

    def __post_init__(self) -> None:
        matrix = np.array(self.matrix, dtype=np.float64)
        intercept = np.array(self.intercept, dtype=np.float64)
        if matrix.shape != (intercept.size, len(self.spans)):
            raise ValueError(
                f"weights of shape {matrix.shape} do not fit "
                f"{intercept.size} intercepts and {len(self.spans)} sensors"
            )
        for name, array in (("matrix", matrix), ("intercept", intercept)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def segments(self) -> int:
        """Number m of segments."""
        return int(self.matrix.shape[0])

    @property
    def sensors(self) -> int:
        """Number n of sensors."""
        return int(self.matrix.shape[1])

    def estimate(self, readings: ArrayLike) -> Floats:
        """Segment angles, shape (..., m), radians, from readings, shape (..., n), radians."""
        return np.asarray(readings, dtype=np.float64) @ self.matrix.T + self.intercept


def without_intercept(method: str, spans: Spans, matrix: Floats) -> Weights:
    """Weights of a method for which the straight joint reads and estimates zero."""
    return Weights(method, spans, matrix, np.zeros(len(matrix)))


def readings(angles: ArrayLike, spans: SpansLike) -> Floats:
    """Normalised readings: the mean angle over each span (the entries of equation 8).

    Prefix sums make the work independent of the spans' lengths, so that whole populations of
    placements can be read at once.

    Args:
        angles: segment angles, shape (..., m), radians.
        spans: shape (n, 2), or (*batch, n, 2) for a batch of placements; first and last segment.

    Returns:
        Shape (..., *batch, n), radians.

    Raises:
        InputError: a span is reversed or outside the joint.
    """
    phi = np.asarray(angles, dtype=np.float64)
    ends = np.asarray(spans, dtype=np.intp)
    first, last = ends[..., 0], ends[..., 1]
    segments = phi.shape[-1]
    wrong = (first < 0) | (last < first) | (last >= segments)
    if wrong.any():
        a, b = ends[wrong][0]
        raise InputError(f"span [{a}, {b}] does not fit; give 0 <= first <= last <= {segments - 1}")
    sums = np.zeros((*phi.shape[:-1], segments + 1))
    np.cumsum(phi, axis=-1, out=sums[..., 1:])
    means: Floats = (sums[..., last + 1] - sums[..., first]) / (last - first + 1)
    return means


def reading_matrix(segments: int, spans: Spans) -> Floats:
    """Matrix H, shape (n, m), with readings = H @ angles."""
    return readings(np.eye(segments), spans).T


def checked_noise(noise_rad: ArrayLike, spans: Spans) -> Floats:
    """Noise of the readings as an array, shape (n,): one standard deviation each, radians.

    Raises:
        InputError: not one number a sensor, negative or not finite.
    """
    noise = np.asarray(noise_rad, dtype=np.float64)
    if noise.shape != (len(spans),) or not (np.isfinite(noise) & (noise >= 0)).all():
        raise InputError(
            f"noise {noise.tolist()} is not usable; give {len(spans)} standard deviations, "
            "one a sensor, each at least 0"
        )
    return noise
