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


class Comparison:
    """Answers held against the reference model, once it is known that they have the model's zeros.

    Attributes:
        compared: answers that were held against it.
        mismatches: values of those that differ.
    """

    def __init__(self, model: FixedPointModel) -> None:
        self._model = model
        self._counts: list[tuple[int, ...]] = []
        self._values: list[tuple[int, ...]] = []
        self.compared = self.mismatches = 0

    def take(self, counts: tuple[int, ...], values: tuple[int, ...]) -> None:
        """Keep an answer until it is known whether it can be compared.

        Args:
            counts: of all sensors, in the joint's order.
            values: of all axes.
        """
        self._counts.append(counts)
        self._values.append(values)

    def hold(self) -> None:
        """Compare what was kept."""
        if self._counts:
            wanted = reference_values(self._model, self._counts)
            answered = np.array(self._values, dtype=np.int64)
            self.mismatches += int(np.count_nonzero(wanted != answered))
            self.compared += len(self._counts)
        self.forget()

    def forget(self) -> None:
        """Let what was kept go: it was estimated with other zeros."""
        self._counts.clear()
        self._values.clear()
