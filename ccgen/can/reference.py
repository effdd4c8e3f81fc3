"""What a node may answer to a snapshot of which a listener does not know what went before."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.fixedpoint.consistency import GroupCheck
from ccgen.fixedpoint.guarded import Followed, GuardedModel
from ccgen.fixedpoint.watch import BACK_AFTER, OUT_AFTER, Watch

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

_SETTLING = 2 * BACK_AFTER
"""Snapshots that tell what a node held of its sensors before."""


def other_values(guarded: GuardedModel, counts: ArrayLike, values: ArrayLike) -> int:
    """How many values of answers no node with the model's zeros publishes.

    Which sensor the checks leave out hangs on the snapshots before. So a group of sensors may be
    served with every sensor that has a reading, or without any single one of them.

    Args:
        guarded: of the exported folder.
        counts: shape (k, n), in the joint's order of sensors.
        values: shape (k, rows of all axes).
    """
    taken, told = np.asarray(counts, dtype=np.int64), np.asarray(values, dtype=np.int64)
    missing = guarded.missing(taken)
    differs = _differing(guarded, taken, missing, told)
    for group in guarded.groups:
        for sensor in range(group.own.start, group.own.stop):
            absent = missing.copy()
            absent[:, sensor] = True
            differs = np.minimum(differs, _differing(guarded, taken, absent, told))
    return int(differs.sum())


def followed_by(
    guarded: GuardedModel, counts: ArrayLike, values: ArrayLike, answered: Flags
) -> tuple[Followed, tuple[int, ...]]:
    """What a node answers to snapshots that it follows one after the other.

    Its checks may have followed others before. Where its answers are not those of a node that
    starts, they are those of the state from which the first of them differ least.

    Args:
        guarded: of the exported folder.
        counts: shape (k, n), in the joint's order of sensors.
        values: what it answered, shape (k, rows of all axes).
        answered: where it did, shape (k,).

    Returns:
        What the model answers, and the sensors that the node had left out before the first.
    """
    taken, told = np.asarray(counts, dtype=np.int64), np.asarray(values, dtype=np.int64)
    fresh = guarded.follow(taken)
    if not (fresh.values != told)[answered].any():
        return fresh, ()
    known = answered[:_SETTLING]

    def wrong(watches: list[Watch]) -> int:
        followed = guarded.follow(taken[:_SETTLING], watches=watches)
        return int((followed.values != told[:_SETTLING])[known].sum())

    watches = list(guarded.start())
    for i, group in enumerate(guarded.groups):
        tried = [[*watches[:i], watch, *watches[i + 1 :]] for watch in _watches(group)]
        watches = min(tried, key=wrong)
    left_out = tuple(
        group.own.start + watch.sensor
        for group, watch in zip(guarded.groups, watches, strict=True)
        if watch.out
    )
    return guarded.follow(taken, watches=watches), left_out


def _watches(group: GroupCheck) -> list[Watch]:
    """Every state that a group can be in, that of the start first."""
    sensors = range(group.own.stop - group.own.start)
    named = [Watch(sensor, run) for sensor in sensors for run in range(1, OUT_AFTER)]
    out = [Watch(sensor, run, True) for sensor in sensors for run in range(BACK_AFTER)]
    return [Watch(), *named, *out]


def _differing(
    guarded: GuardedModel, counts: Integers, absent: Flags, values: Integers
) -> Integers:
    """Of each axis how many values differ, shape (k, axes)."""
    wrong = guarded.estimate(counts, absent) != values
    parts = guarded.model.split(wrong.astype(np.int64))
    return np.stack([part.sum(axis=-1) for part in parts.values()], axis=-1)


class Comparison:
    """Answers held against the reference model, once it is known that they have the model's zeros.

    Attributes:
        compared: answers that were held against it.
        mismatches: values of those that differ.
    """

    def __init__(self, guarded: GuardedModel) -> None:
        self._guarded = guarded
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
            self.mismatches += other_values(self._guarded, self._counts, self._values)
            self.compared += len(self._counts)
        self.forget()

    def forget(self) -> None:
        """Let what was kept go: it was estimated with other zeros."""
        self._counts.clear()
        self._values.clear()
