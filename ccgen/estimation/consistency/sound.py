"""What the sensors of a sound joint read: shapes that it takes, and noise on top of them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_SEED = 2020


@dataclass(frozen=True, eq=False)
class SoundReadings:
    """Length changes of n sensors at N shapes, each with independent Gaussian noise.

    Attributes:
        lengths: without noise, shape (N, n), metres.
        variance: of the noise, shape (N, n), metres squared; it differs between shapes where a
            gain is known to a tolerance only.
        weight: of each shape, shape (N,); their sum is 1.
    """

    lengths: Floats
    variance: Floats
    weight: Floats

    def __post_init__(self) -> None:
        count = len(self.weight)
        if self.lengths.shape != self.variance.shape or len(self.lengths) != count or not count:
            raise ValueError(
                f"lengths {self.lengths.shape}, variance {self.variance.shape} and weight "
                f"{self.weight.shape} do not fit; give (N, n), (N, n) and (N,)"
            )

    @property
    def sensors(self) -> int:
        """Number n of sensors."""
        return int(self.lengths.shape[1])

    def of(self, sensors: slice | Integers) -> "SoundReadings":
        """The readings of some sensors."""
        return SoundReadings(self.lengths[:, sensors], self.variance[:, sensors], self.weight)

    def sampled(self, count: int) -> Floats:
        """Readings of shapes and noise drawn evenly, shape (count, n), metres.

        Args:
            count: a power of 2.
        """
        from scipy.special import ndtri

        points = even_points(count, self.sensors + 1)
        rows = chosen(self.weight, points[:, 0])
        noise = ndtri(points[:, 1:]) * np.sqrt(self.variance[rows])
        return np.asarray(self.lengths[rows] + noise)


@lru_cache(maxsize=4)
def even_points(count: int, dimensions: int) -> Floats:
    """Points of a scrambled Sobol sequence, shape (count, dimensions), inside (0, 1)."""
    from scipy.stats import qmc

    points = qmc.Sobol(dimensions, scramble=True, seed=_SEED).random_base2(count.bit_length() - 1)
    even: Floats = np.clip(points, 2.0**-40, 1.0 - 2.0**-40)
    even.setflags(write=False)
    return even


def chosen(weight: Floats, share: Floats) -> Integers:
    """Indices that are as frequent as their weights, for shares spread evenly over (0, 1)."""
    ends = np.cumsum(weight)
    found = np.searchsorted(ends, share * ends[-1], side="right")
    return np.asarray(np.minimum(found, len(weight) - 1), dtype=np.int64)
