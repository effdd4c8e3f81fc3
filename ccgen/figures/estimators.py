"""Estimators as figures draw them: shapes of one axis in, the other one straight."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ccgen.estimation import Weights
from ccgen.estimation.errors import deviations
from ccgen.figures.curves import planar_curve
from ccgen.figures.style import Floats
from ccgen.joint import Joint
from ccgen.sensing.readings import normalised_response, readings


@dataclass(frozen=True, eq=False)
class Estimator:
    """What weights make of shapes.

    Attributes:
        weights: of the axis.
        read: normalised readings, shape (n,), radians, of segment angles, shape (m,), radians.
        noise: standard deviations of these readings at these angles; None where not stated.
    """

    weights: Weights
    read: Callable[[Floats], Floats]
    noise: Callable[[Floats], Floats] | None = None

    def angles(self, shape: Floats) -> Floats:
        """Estimated segment angles, shape (m,), radians, of the true ones."""
        return self.weights.estimate(self.read(shape))

    def spread(self, shape: Floats, segment_length: float) -> Floats:
        """Root mean square by which noise moves the points of the estimated `planar_curve`.

        To first order in the noise, so that each sensor adds for itself.

        Args:
            shape: true segment angles, shape (m,), radians.
            segment_length: metres.

        Returns:
            Shape (points,), metres.
        """
        estimated = self.angles(shape)
        square = np.zeros(len(planar_curve(estimated, segment_length)[0]))
        if self.noise is not None:
            for move in (self.weights.matrix * self.noise(shape)).T:
                ahead = np.array(planar_curve(estimated + move, segment_length))
                behind = np.array(planar_curve(estimated - move, segment_length))
                square += np.square((ahead - behind) / 2.0).sum(axis=0)
        return np.asarray(np.sqrt(square))


def own_estimator(
    joint: Joint, axis: str, weights: Weights, lengths_noise: Floats | None = None
) -> Estimator:
    """Weights for the sensors that an axis of a joint reads.

    Args:
        joint: its sensors.
        axis: "u" or "v".
        weights: of that axis.
        lengths_noise: as for `ccgen.estimation.errors.deviations`.
    """
    own, rows = joint.own(axis), joint.rows(axis)
    seen = normalised_response(joint)
    part = seen[own, rows]

    def noise(shape: Floats) -> Floats:
        state = np.zeros((1, seen.shape[1]))
        state[0, rows] = shape
        return deviations(joint, state, lengths_noise)[0, own]

    stated = all(sensor.noise is not None for sensor in joint.sensors[own])
    known = stated or lengths_noise is not None
    return Estimator(weights, lambda shape: part @ shape, noise if known else None)


def spans_estimator(weights: Weights) -> Estimator:
    """Weights for sensors of which nothing is known but their spans."""
    return Estimator(weights, lambda shape: readings(shape, weights.spans))
