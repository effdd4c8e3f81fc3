"""From readings of all sensors to the whole state."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.weights import Floats, Weights

if TYPE_CHECKING:
    from ccgen.joint import Joint


def estimated(joint: "Joint", weights: Mapping[str, Weights], readings: Floats) -> Floats:
    """States from normalised readings of all sensors.

    Args:
        joint: the joint.
        weights: of its output axes.
        readings: shape (..., n).

    Returns:
        Shape (..., 2m + S); 0 where no axis estimates it.
    """
    geometry = joint.geometry
    state = np.zeros((*readings.shape[:-1], 2 * geometry.segments + len(geometry.sections)))
    for axis, own in weights.items():
        state[..., joint.rows(axis)] = own.estimate(readings[..., joint.own(axis)])
    return state
