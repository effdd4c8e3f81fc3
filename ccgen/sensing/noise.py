"""The noise of normalised readings."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ccgen.errors import InputError
from ccgen.joint.layouts import Spans
from ccgen.sensing.readings import Floats

if TYPE_CHECKING:
    from ccgen.joint import Joint


def reading_noise(joint: "Joint", axis: str) -> Floats | None:
    """Standard deviation of the normalised readings, shape (n,), radians; None if not stated.

    A transducer's noise in metres, the same for each sensor of the axis, over p_j r: a long span
    averages it down.
    """
    sensors = joint.axis(axis)
    if sensors.transducer.noise is None:
        return None
    lengths = np.array([b - a + 1 for a, b in sensors.spans])
    noise: Floats = sensors.transducer.noise / (lengths * sensors.radius)
    return noise


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
