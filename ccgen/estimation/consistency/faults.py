"""Faults of a single sensor: how large they must be to be seen, and to be told from others.

A fault adds an offset to the reading of sensor j, of either sign, at any shape. An alarm names a
sensor only where the pattern is clear: the largest |z_j| exceeds the second largest of its group
by more than the margin of j, so that a fault is taken for one of some other sensor in at most one
of twenty alarms. Where it is not clear, the alarm stands without a name.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation.consistency.sound import Floats, Integers, SoundReadings

SEEN = 0.99
"""Share of snapshots in which a fault of the told size alarms."""
MISTAKEN = 0.05
"""Largest share of its alarms in which a fault is taken for some other sensor's."""
NAMED = 0.96
"""Share of snapshots in which a fault that counts as isolable names its sensor."""

_SAMPLES = 2**13
_SIZES = (0.7, 1.0, 1.4, 2.0, 4.0)
"""Sizes, in detectable faults, over which a fault is not to be mistaken."""
_GROWTH = 1.05
_LARGEST = 8.0
"""Sensor ranges up to which the smallest isolated fault is looked for."""


@dataclass(frozen=True, eq=False)
class Faults:
    """What is told of faults of each of n sensors.

    Attributes:
        detectable: the smallest offset of either sign that alarms in 99 % of snapshots, shape
            (n,), metres.
        margin: by which |z_j| must exceed the others to name sensor j, shape (n,).
        isolable: whether a fault of that size names its sensor, shape (n,).
        isolated: the smallest offset that does, shape (n,), metres; NaN where none does.
    """

    detectable: Floats
    margin: Floats
    isolable: NDArray[np.bool_]
    isolated: Floats


@dataclass(frozen=True, eq=False)
class _Residuals:
    """Residuals z = T y of K snapshots, those that alarm and those that name.

    Attributes:
        alarming, naming: shape (K, n).
        alarms, names: T of each, shape (n, n).
    """

    alarming: Floats
    naming: Floats
    alarms: Floats
    names: Floats

    def moved(self, sensor: int, offset: float) -> "_Residuals":
        """With a fault in one sensor."""
        return _Residuals(
            self.alarming + offset * self.alarms[:, sensor],
            self.naming + offset * self.names[:, sensor],
            self.alarms,
            self.names,
        )


def faults(alarms: Floats, names: Floats, limits: Floats, sound: SoundReadings) -> Faults:
    """Tell of the faults of one group of sensors.

    Args:
        alarms: T of the residuals that alarm, shape (n, n).
        names: T of the residuals that name a sensor, shape (n, n).
        limits: thresholds of the residuals that alarm, shape (n,).
        sound: readings of a sound joint.
    """
    sampled = sound.sampled(_SAMPLES)
    residuals = _Residuals(sampled @ alarms.T, sampled @ names.T, alarms, names)
    found = np.array([_detectable(residuals.alarming, row, limits) for row in alarms.T])
    margin = _margins(residuals, limits, found)
    largest = _LARGEST * np.abs(sound.lengths).max(axis=0)
    named = [_named_share(residuals, size, limits, margin, j) for j, size in enumerate(found)]
    isolated = [
        _isolated(residuals, limits, margin, j, found[j], largest[j]) for j in range(len(found))
    ]
    return Faults(found, margin, np.array(named) >= NAMED, np.array(isolated))


def _named(residuals: _Residuals, limits: Floats, margin: Floats) -> Integers:
    """The sensor that each snapshot names or -1, shape (K,)."""
    alarm = (np.abs(residuals.alarming) > limits).any(axis=1)
    size = np.abs(residuals.naming)
    first = size.argmax(axis=1)
    clear = _lead(size) > margin[first]
    return np.asarray(np.where(alarm & clear, first, -1), dtype=np.int64)


def _lead(size: Floats) -> Floats:
    """By how much the largest of each row exceeds the second largest, shape (K,)."""
    if size.shape[1] < 2:
        return np.full(len(size), np.inf)
    two = np.partition(size, -2, axis=1)[:, -2:]
    return np.asarray(two[:, 1] - two[:, 0])


def _detectable(residuals: Floats, response: Floats, limits: Floats) -> float:
    """The offset that alarms in a share SEEN of the samples, whichever its sign.

    A sample stays silent for offsets b with |z_k + b t_k| <= h_k for all k: an interval.
    """
    moved = np.flatnonzero(response)
    ends = np.stack([sign * limits[moved] - residuals[:, moved] for sign in (-1, 1)])
    ends = np.sort(ends / response[moved], axis=0)
    lowest, highest = ends[0].max(axis=1), ends[1].min(axis=1)
    return float(max(np.quantile(highest, SEEN), np.quantile(-lowest, SEEN)))


def _margins(residuals: _Residuals, limits: Floats, sizes: Floats) -> Floats:
    """Leads that keep all mistakes about each fault together to a share MISTAKEN of its alarms.

    Four fifths of them are left to the sensors that a fault is often taken for, which all need
    the same lead; the last fifth to those that it is hardly ever taken for, which need none.
    """
    margin = np.zeros(len(limits))
    for k, size in enumerate(sizes):
        for offset in [sign * scale * size for sign in (-1, 1) for scale in _SIZES]:
            seen = residuals.moved(k, offset)
            alarm = (np.abs(seen.alarming) > limits).any(axis=1)
            named = np.abs(seen.naming[alarm])
            first, lead = named.argmax(axis=1), _lead(named)
            if not first.size:
                continue
            needed = np.quantile(np.where(first == k, 0.0, lead), 1.0 - 0.8 * MISTAKEN)
            share = np.bincount(first, minlength=len(limits)) / first.size
            often = share > 0.2 * MISTAKEN / len(limits)
            often[k] = False
            margin[often] = np.maximum(margin[often], needed)
    return margin


def _named_share(
    residuals: _Residuals, size: float, limits: Floats, margin: Floats, sensor: int
) -> float:
    """Share of samples with a fault that name the sensor, for the worse sign."""
    return min(
        float(np.mean(_named(residuals.moved(sensor, sign * size), limits, margin) == sensor))
        for sign in (-1, 1)
    )


def _isolated(
    residuals: _Residuals,
    limits: Floats,
    margin: Floats,
    sensor: int,
    start: float,
    largest: float,
) -> float:
    """The smallest offset from `start` on that names its sensor."""
    size = start
    while size <= largest:
        if _named_share(residuals, size, limits, margin, sensor) >= NAMED:
            return size
        size *= _GROWTH
    return np.nan
