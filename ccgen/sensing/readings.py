"""What sensors read of a shape: the normalised readings of the paper's equation (5).

A sensor over segments a to b measures a length change r * (phi_a + ... + phi_b), where r is its
distance from the neutral axis. Divided by r and by the number p = b - a + 1 of its segments it
becomes the mean bending angle over the span, in radians.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.errors import InputError
from ccgen.joint.layouts import Spans

Floats = NDArray[np.float64]
SpansLike = Spans | NDArray[np.intp]


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
