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

from ccgen.joint.layouts import AnySpans

Floats = NDArray[np.float64]


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
    spans: AnySpans
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


def without_intercept(method: str, spans: AnySpans, matrix: Floats) -> Weights:
    """Weights of a method for which the straight joint reads and estimates zero."""
    return Weights(method, spans, matrix, np.zeros(len(matrix)))
