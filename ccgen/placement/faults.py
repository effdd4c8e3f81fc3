"""How small a fault of a sensor may be until the others no longer contradict it, by placement."""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.consistency.alarms import thresholds
from ccgen.estimation.consistency.faults import faults
from ccgen.estimation.consistency.residuals import parity
from ccgen.estimation.consistency.sound import SoundReadings
from ccgen.estimation.weights import Floats
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.readings import readings

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import Shapes


def visible_faults(angles: Floats, spans: AnySpans, noise_rad: Floats, rate: float) -> Floats:
    """The smallest fault of each sensor that 99 % of snapshots show.

    Args:
        angles: shapes that the joint takes at work, shape (N, m), radians.
        spans: the n sensors' spans.
        noise_rad: deviation of each normalised reading, shape (n,), radians, above 0.
        rate: of false alarms, of snapshots.

    Returns:
        As `seen_faults`.
    """
    return seen_faults(readings(angles, spans), noise_rad, rate)


def seen_faults(read: Floats, noise_rad: Floats, rate: float) -> Floats:
    """The smallest fault of each sensor of a group that 99 % of snapshots show.

    Args:
        read: normalised readings of shapes that the joint takes at work, shape (N, n), radians.
        noise_rad: deviation of each, shape (n,), radians, above 0.
        rate: of false alarms, of snapshots.

    Returns:
        Shape (n,), % of the sensor's largest reading; NaN where no fault that small is seen.
    """
    count, sensors = read.shape
    if sensors < 2:
        return np.full(sensors, np.nan)
    noise = np.broadcast_to(np.square(noise_rad), read.shape)
    sound = SoundReadings(read, noise, np.full(count, 1.0 / count))
    found = parity(sound)
    limits = thresholds(found.alarming, sound, rate)
    told = faults(found.alarming, found.naming, limits, sound)
    largest = np.abs(read).max(axis=0)
    seen = (told.detectable <= largest) & (largest > 0.0)
    percent = np.full(sensors, np.nan)
    percent[seen] = 100.0 * told.detectable[seen] / largest[seen]
    return percent


def wide_shapes(joint: "Joint") -> "Shapes":
    """Shapes of a joint at work: of its loads, or of any loads where none are stated.

    Raises:
        ReachError: no draw of the joint's loads gives a shape.
    """
    from ccgen.shapes.loads.library import loads_library, other_library

    drawn = loads_library(joint)
    return other_library(joint) if drawn is None else drawn.shapes
