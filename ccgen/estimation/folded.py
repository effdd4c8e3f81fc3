"""Mean of the absolute value of a normal variable."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def folded_mean(mean: Floats, deviation: Floats) -> Floats:
    """Mean of |x| for normal x: s sqrt(2/pi) exp(-mu^2 / 2 s^2) + mu erf(mu / (s sqrt 2)).

    Args:
        mean: mu, any shape.
        deviation: s >= 0, broadcasts against the mean.
    """
    from scipy.special import erf

    size = np.abs(mean)
    spread = np.broadcast_to(deviation * np.sqrt(2.0), size.shape)
    ratio = np.divide(size, spread, out=np.full_like(size, np.inf), where=spread > 0)
    folded: Floats = spread * np.exp(-np.square(ratio)) / np.sqrt(np.pi) + size * erf(ratio)
    return folded
