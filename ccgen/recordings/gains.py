"""Gains and zeros of sensors where references know the whole shape: a regression for each sensor.

A reading is gain times expected change of length, plus a zero that each recording has of its own,
plus noise; readings far off are trusted less, by the weights of Student's distribution. Errors of a
joint that moves slowly are alike from row to row, so standard deviations are those of as many rows
as are independent.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.recording import Recording
from ccgen.recordings.sensors import RecordedSensors

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

GAIN_STD = 0.3
"""Of gains about 1, before a reference says better."""
ZERO_STD = 0.1
"""Of zeros, metres, before a recording says better."""

_FREEDOM = 4.0  # degrees of freedom of Student's distribution
_NORMAL = 0.8310  # its scale that fits normal noise of standard deviation 1
_TURNS = 30
_LEAST_NOISE = 1e-7
_PLAY = 0.4
"""Of the noise in a stretch: by so much a joint at rest may stay away from the mean."""
LEAST_STD = 1e-5
"""Metres: no zero is known better by a stretch."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """What turns changes of length into readings: length = gain * change + zero + noise.

    Attributes:
        gain, gain_std: shape (n,).
        zero, zero_std: of each recording, shape (groups, n), metres.
        noise: one standard deviation of a reading, play and all, shape (n,), metres.
        trust: how far each reading was trusted, 0 to 1 and a little more; shape (N, n).
    """

    gain: Floats
    gain_std: Floats
    zero: Floats
    zero_std: Floats
    noise: Floats
    trust: Floats

    def of(self, group: int) -> "Sensed":
        """What is known of the sensors in one recording."""
        return Sensed(self.gain, self.gain_std, self.zero[group], self.zero_std[group], self.noise)


@dataclass(frozen=True, eq=False)
class Sensed:
    """Gains, zeros and noise of the sensors in one recording, shape (n,) each, zeros in metres."""

    gain: Floats
    gain_std: Floats
    zero: Floats
    zero_std: Floats
    noise: Floats


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of zeros beforehand, each of shape (groups, n), metres."""

    zero: Floats
    zero_std: Floats


def stretch_zero(
    recording: Recording, change: Floats, lengths: Floats, gain: Floats
) -> tuple[Floats, Floats] | None:
    """Zeros by the stretch in which the joint was straight, or in which its shape sets them.

    Rows average noise, but not what play leaves: that counts as a share of the noise.

    Args:
        recording: whose file names the stretch.
        change: expected of each length, shape (N, n), metres; NaN where unknown.
        lengths: shape (N, n), metres; NaN where there is none.
        gain: shape (n,).

    Returns:
        Zeros and their standard deviations, shape (n,), metres; NaN for a sensor without readings
        there; None where the file names no stretch.
    """
    file = recording.file
    interval = file.zero_from or file.straight
    if interval is None:
        return None
    rows = recording.within(interval)
    moved = 0.0 if file.zero_from is None else gain * change[rows]
    off = lengths[rows] - moved
    empty = np.isnan(off).all(axis=0)
    off[:, empty] = 0.0
    zero = np.nanmedian(off, axis=0)
    noise = 1.4826 * np.nanmedian(np.abs(off - zero), axis=0)
    count = np.maximum((~np.isnan(off)).sum(axis=0), 1)
    std = np.maximum(noise * np.sqrt(1 / count + _PLAY**2), LEAST_STD)
    return np.where(empty, np.nan, zero), np.where(empty, np.nan, std)


def borrowed(
    common: Calibration | None,
    own: tuple[Floats, Floats] | None,
    sensors: RecordedSensors,
) -> Sensed:
    """What is known of the sensors in a recording from which nothing is learned.

    Args:
        common: what other recordings told; None without any.
        own: zeros by a stretch of its own, as `stretch_zero` returns them.
        sensors: what is stated of them, which serves where nothing was learned.
    """
    if common is None:
        sensed = Sensed(
            np.ones_like(sensors.noise),
            np.full_like(sensors.noise, GAIN_STD),
            np.zeros_like(sensors.noise),
            np.full_like(sensors.noise, ZERO_STD),
            sensors.noise,
        )
    else:
        between = np.square(common.zero_std).mean(axis=0) + common.zero.var(axis=0)
        sensed = replace(common.of(0), zero=common.zero.mean(axis=0), zero_std=np.sqrt(between))
    if own is None:
        return sensed
    zero, std = own
    there = ~np.isnan(zero)
    return replace(
        sensed,
        zero=np.where(there, zero, sensed.zero),
        zero_std=np.where(there, std, sensed.zero_std),
    )


def calibrated(
    expected: Floats, lengths: Floats, group: Indices, known: Known, independent: float
) -> Calibration:
    """Regress readings on the changes of length that references let expect.

    Args:
        expected: shape (N, n), metres; NaN where unknown.
        lengths: shape (N, n), metres; NaN where there is none.
        group: recording of each row, shape (N,).
        known: of zeros beforehand.
        independent: rows as which all of them count.
    """
    share = min(1.0, independent / max(len(expected), 1))
    parts = [
        _one(expected[:, j], lengths[:, j], group, known.zero[:, j], known.zero_std[:, j], share)
        for j in range(expected.shape[1])
    ]
    gain, gain_std, zero, zero_std, noise, trust = zip(*parts, strict=True)
    return Calibration(
        np.array(gain),
        np.array(gain_std),
        np.stack(zero, axis=1),
        np.stack(zero_std, axis=1),
        np.array(noise),
        np.stack(trust, axis=1),
    )


def _one(
    expected: Floats, lengths: Floats, group: Indices, zero: Floats, zero_std: Floats, share: float
) -> tuple[float, float, Floats, Floats, float, Floats]:
    """Gain, zeros, noise and trust of one sensor."""
    there = ~np.isnan(expected) & ~np.isnan(lengths)
    design = np.zeros((int(there.sum()), 1 + len(zero)))
    design[:, 0] = expected[there]
    design[np.arange(len(design)), 1 + group[there]] = 1.0
    prior = np.concatenate([[1.0], zero])
    precision = np.diag(1.0 / np.square(np.concatenate([[GAIN_STD], zero_std])))
    trust, found, noise = np.ones(len(design)), prior, np.inf
    information = precision
    residual = lengths[there] - design @ prior
    for turn in range(_TURNS if len(design) else 0):
        weighed = trust[:, None] * design
        scale = 1.0 if turn == 0 else noise
        information = share * (weighed.T @ design) / scale**2 + precision
        gradient = share * (weighed.T @ (lengths[there] - design @ prior)) / scale**2
        found = prior + np.linalg.solve(information, gradient)
        residual = lengths[there] - design @ found
        noise = _noise(residual, noise)
        trust = (_FREEDOM + 1) / (_FREEDOM + np.square(residual / noise))
    std = np.sqrt(np.diag(np.linalg.inv(information)))
    whole = np.zeros(len(expected))
    whole[there] = trust
    noise = noise if len(design) else float("nan")
    return float(found[0]), float(std[0]), found[1:], std[1:], noise, whole


def _noise(residual: Floats, before: float) -> float:
    """Scale of residuals, those far off counting less."""
    if not np.isfinite(before):
        return max(1.4826 * float(np.median(np.abs(residual))), _LEAST_NOISE)
    ratio = np.square(residual / (before * _NORMAL))
    trust = (_FREEDOM + 1) / (_FREEDOM + ratio)
    return max(float(np.sqrt(np.mean(trust * np.square(residual)))) / _NORMAL, _LEAST_NOISE)
