"""What one source tells of each sensor's gain and zero, and what all of them tell together.

A reading is gain times change of length plus zero plus noise, in metres at the nominal metres per
count. What a source tells is normal in the two: information about (gain, zero) and what that points
to, which add up over sources.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_UNKNOWN = 1e-12
"""Share of the larger information that counts as none."""


@dataclass(frozen=True, eq=False)
class Told:
    """What a source tells of n sensors.

    Attributes:
        information: about gain and zero (metres), shape (n, 2, 2).
        potential: information times the values, shape (n, 2).
    """

    information: Floats
    potential: Floats

    @classmethod
    def of(cls, gain: Floats, gain_std: Floats, zero: Floats, zero_std: Floats) -> "Told":
        """From gains and zeros (metres) with their deviations, shape (n,) each; NaN: not told."""
        values, stds = np.stack([gain, zero], axis=1), np.stack([gain_std, zero_std], axis=1)
        known = np.isfinite(values) & np.isfinite(stds) & (stds > 0)
        weight = np.where(known, 1.0 / np.square(np.where(known, stds, 1.0)), 0.0)
        information = weight[:, :, None] * np.eye(2)
        return cls(information, weight * np.where(known, values, 0.0))


@dataclass(frozen=True, eq=False)
class Found:
    """Gains and zeros with their deviations, shape (n,) each; infinite deviations: not determined.

    Attributes:
        gain: of the reading, by the nominal one.
        gain_std: of that.
        zero: reading of the straight joint, metres at nominal gain.
        zero_std: of that.
    """

    gain: Floats
    gain_std: Floats
    zero: Floats
    zero_std: Floats


def together(sources: Sequence[Told]) -> Found:
    """What sources tell together."""
    information = np.sum([source.information for source in sources], axis=0)
    potential = np.sum([source.potential for source in sources], axis=0)
    solved = [_solved(i, p) for i, p in zip(information, potential, strict=True)]
    gain, gain_std, zero, zero_std = np.array(solved).T
    return Found(gain, gain_std, zero, zero_std)


def _solved(information: Floats, potential: Floats) -> tuple[float, float, float, float]:
    """Gain and zero with their deviations; a gain that is not told takes the nominal 1."""
    a, b, c = information[0, 0], information[0, 1], information[1, 1]
    left = a - b * b / c if c > 0 else a  # about the gain, once the zero is free
    if left <= _UNKNOWN * max(a, _UNKNOWN):
        zero = (potential[1] - b) / c if c > 0 else np.nan
        return 1.0, np.inf, float(zero), float(c**-0.5) if c > 0 else np.inf
    if c <= 0:
        return float(potential[0] / a), float(a**-0.5), np.nan, np.inf
    covariance = np.linalg.inv(information)
    gain, zero = covariance @ potential
    std = np.sqrt(np.diag(covariance))
    return float(gain), float(std[0]), float(zero), float(std[1])
