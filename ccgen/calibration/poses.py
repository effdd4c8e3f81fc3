"""What poses that are known without cameras tell of sensors: the straight joint, and known angles.

A stretch in which the joint is straight tells zeros and noise. A few rows of known angles, each a
pose that the joint was held in, tell gains and zeros.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.calibration.told import Told
from ccgen.errors import InputError
from ccgen.joint import Joint
from ccgen.recordings.learning import independent_rows
from ccgen.recordings.movement import check_resting_sensors
from ccgen.recordings.recording import Recording

Floats = NDArray[np.float64]

_ROBUST = 1.4826
"""Standard deviation of normal noise over its median absolute deviation."""
_COVERED = 0.97725
"""Of a normal distribution below two deviations."""
_FAR = 6.0
"""Deviations beyond which a reading at rest is none of the joint's."""


@dataclass(frozen=True, eq=False)
class Held:
    """What poses told of n sensors, and their noise, shape (n,), metres; NaN where not known."""

    told: Told
    noise: Floats
    noise_std: Floats


def straight_joint(joint: Joint, recording: Recording) -> Held:
    """What counts alone tell while the joint is straight.

    Args:
        joint: its n sensors, of nominal gain.
        recording: with counts, and neither angles nor bodies.

    Raises:
        InputError: the joint file does not say when it is straight, or sensors move then.
    """
    assert recording.counts is not None
    interval, counts = recording.file.straight, recording.counts
    if interval is None:
        raise InputError(
            f"{recording.source}: holds counts alone, and [[recordings]] does not say when the "
            "joint was straight; write straight = [0.0, 2.0] (seconds), or add angles or stations"
        )
    step = np.array([sensor.metres_per_count for sensor in joint.sensors])
    lengths = counts.values[recording.within(interval, counts.t)] * step
    check_resting_sensors(recording.source, interval, lengths, joint)
    rows = [_at_rest(lengths[:, j], abs(float(step[j]))) for j in range(len(step))]
    zero, zero_std, noise, noise_std = np.array(rows).T
    unknown = np.full(len(step), np.nan)
    return Held(Told.of(unknown, unknown, zero, zero_std), noise, noise_std)


def _at_rest(lengths: Floats, step: float) -> tuple[float, float, float, float]:
    """Mean and noise of readings at rest, with their deviations; counting adds noise of its own."""
    seen = lengths[~np.isnan(lengths)]
    if not len(seen):
        return (np.nan,) * 4
    middle = float(np.median(seen))
    scale = max(_ROBUST * float(np.median(np.abs(seen - middle))), step)
    kept = seen[np.abs(seen - middle) <= _FAR * scale]
    independent = independent_rows(kept[:, None])
    noise = float(kept.std())
    zero_std = float(np.hypot(noise, step / np.sqrt(12.0)) / np.sqrt(independent))
    return float(kept.mean()), zero_std, noise, noise / np.sqrt(2.0 * independent)


def known_poses(expected: Floats, lengths: Floats, noise: Floats) -> Held:
    """What rows of known shapes tell, each a pose of its own.

    Args:
        expected: changes of length, shape (N, n), metres; NaN where unknown.
        lengths: readings at nominal gain, shape (N, n), metres; NaN where there is none.
        noise: of readings as far as it is known, the step of the counts included, shape (n,),
            metres; poses that lie further from a line count as noisier.
    """
    columns = [_line(x, y, s) for x, y, s in zip(expected.T, lengths.T, noise, strict=True)]
    information, potential, found, found_std = zip(*columns, strict=True)
    return Held(
        Told(np.stack(information), np.stack(potential)), np.array(found), np.array(found_std)
    )


def _line(expected: Floats, lengths: Floats, known: float) -> tuple[Floats, Floats, float, float]:
    """Information about a line through known poses, and how far readings lie from it."""
    from scipy.stats import t

    there = ~np.isnan(expected) & ~np.isnan(lengths)
    x, y = expected[there], lengths[there]
    design = np.stack([x, np.ones_like(x)], axis=1)
    free = len(x) - int(np.linalg.matrix_rank(design)) if len(x) else 0
    noise, noise_std, scale = np.nan, np.nan, known
    if free > 0:
        fitted = np.linalg.lstsq(design, y, rcond=None)[0]
        noise = float(np.sqrt(np.square(y - design @ fitted).sum() / free))
        noise_std = noise / np.sqrt(2.0 * free)
        # So few rows tell little of their noise: two deviations still hold what 95 % do.
        scale = max(known, noise * float(t.ppf(_COVERED, free)) / 2.0)
    return design.T @ design / scale**2, design.T @ y / scale**2, noise, noise_std
