"""The noise of readings: what is stated, what counting adds, what a gain leaves unknown."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.double_double import matmul
from ccgen.errors import InputError
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.readings import Floats, normaliser, response

if TYPE_CHECKING:
    from ccgen.joint import Joint


Integers = NDArray[np.int64]

_STILL = 6.0
"""Standard deviations."""
_LARGEST_STILL = 2**22
"""Counts; the sum of 255 such distances fits 32 bits."""


def stated_noise(joint: "Joint") -> Floats | None:
    """Stated standard deviation of each length, shape (n,), metres; None if one is not stated."""
    noise = [sensor.noise for sensor in joint.sensors if sensor.noise is not None]
    return np.array(noise) if len(noise) == len(joint.sensors) else None


def length_variance(joint: "Joint", second_moment: Floats | None = None) -> Floats:
    """Variance of each length's error, shape (n,), metres squared.

    The stated noise (none where it is not stated), the step of the counts squared over 12, and
    the gain tolerance squared times the mean square of the length change itself.

    Args:
        joint: its sensors.
        second_moment: of the states, shape (2m + S, 2m + S), radians and shares; without it
            gains count as known.
    """
    sensors = joint.sensors
    noise = np.array([sensor.noise or 0.0 for sensor in sensors])
    step = np.array([sensor.metres_per_count for sensor in sensors])
    variance = np.square(noise) + np.square(step) / 12.0
    if second_moment is None:
        return np.asarray(variance)
    H = response(joint)
    tolerance = np.array([sensor.gain_tolerance for sensor in sensors])
    lengths = (matmul(H, second_moment) * H).sum(axis=1).hi
    return np.asarray(variance + np.square(tolerance) * lengths)


def still_counts(joint: "Joint", moved: Integers) -> Integers:
    """How far two readings of a joint at rest may lie apart, counts, shape (n,).

    Six standard deviations of their difference, and one count; where no noise is stated, a
    hundredth of what the joint's motion moves it by.

    Args:
        joint: its sensors.
        moved: counts from one end of its motion to the other, shape (n,).
    """
    step = np.array([abs(sensor.metres_per_count) for sensor in joint.sensors])
    noisy = 1.0 + np.ceil(_STILL * np.sqrt(2.0 * length_variance(joint)) / step)
    stated = np.array([sensor.noise is not None for sensor in joint.sensors])
    counts = np.where(stated, noisy, np.maximum(noisy, moved // 100))
    return np.asarray(np.minimum(counts, _LARGEST_STILL), dtype=np.int64)


def second_moment(states: Floats) -> Floats:
    """E[x x^T] of states, shape (N, D), about zero; shape (D, D), the same bits everywhere."""
    return matmul(states.T, states).hi / len(states)


def reading_noise(joint: "Joint", axis: str) -> Floats | None:
    """Stated standard deviation of the normalised readings of an output axis; None if not stated.

    A transducer's noise in metres over p_j r: a long span averages it down. Weights of the paper's
    sets are fitted with it.

    Returns:
        Shape (n,) for the n sensors that the axis reads, radians.
    """
    noise = stated_noise(joint)
    if noise is None:
        return None
    own = joint.own(axis)
    return np.asarray(noise[own] / normaliser(joint)[own])


def told_noise(joint: "Joint", axis: str, second_moment: Floats | None = None) -> Floats | None:
    """Like `reading_noise`, with the step of the counts and the tolerance of the gains.

    Every error that is told holds under it; so do weights of sensors that couple.

    Args:
        joint: its sensors.
        axis: an output axis.
        second_moment: of the states, as of `length_variance`.
    """
    if stated_noise(joint) is None:
        return None
    own = joint.own(axis)
    return np.asarray(np.sqrt(length_variance(joint, second_moment))[own] / normaliser(joint)[own])


def checked_noise(noise_rad: ArrayLike, spans: AnySpans) -> Floats:
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
