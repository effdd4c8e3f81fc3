"""What a node answers: the integer reference model, and "no reading" where it has no estimate."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.fixedpoint import FixedPointModel

Integers = NDArray[np.int64]


def reference_values(model: FixedPointModel, counts: ArrayLike) -> Integers:
    """Values of all axes, as a node with the model's zeros publishes them.

    Args:
        model: of the exported folder.
        counts: shape (k, n), in the joint's order of sensors.

    Returns:
        Shape (k, rows of all axes); the most negative value of a row with a missing sensor.
    """
    taken = np.asarray(counts, dtype=np.int64)
    values = np.full((len(taken), model.values), -(2 ** (model.precision - 1)), dtype=np.int64)
    there = ~missing_readings(model, taken).any(axis=1)
    values[there] = model.estimate(taken[there])
    return values


def missing_readings(model: FixedPointModel, counts: ArrayLike) -> NDArray[np.bool_]:
    """Which counts are no readings, shape (k, n)."""
    taken = np.asarray(counts, dtype=np.int64)
    missing = np.zeros(taken.shape, dtype=np.bool_)
    for axis in model.axes.values():
        missing[:, axis.part] |= axis.missing(taken[:, axis.part])
    return missing
