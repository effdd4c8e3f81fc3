"""The sensors of a joint as a recording sees them: names, counts, and what they measure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint, Sensor
from ccgen.sensing.readings import response

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RecordedSensors:
    """All n sensors of a joint in its order."""

    names: tuple[str, ...]
    """As columns and signals name them."""
    metres_per_count: Floats
    """Nominal gain, shape (n,); negative where the count falls as the sensor lengthens."""
    lowest: Floats
    """Count at or below which there is no reading, shape (n,)."""
    highest: Floats
    """Count at or above which there is no reading, shape (n,)."""
    matrix: Floats
    """Change of length for a unit of state, shape (n, 2 segments + sections), metres."""
    noise: Floats
    """One standard deviation as stated, shape (n,), metres; NaN where it is not."""


def recorded_sensors(joint: Joint) -> RecordedSensors:
    """Return the sensors of a joint as its recordings name them: u0 ... v0 ... of the sets."""
    sensors = joint.sensors
    ends = np.array([_ends(sensor) for sensor in sensors], dtype=np.float64)
    return RecordedSensors(
        names=tuple(sensor.name for sensor in sensors),
        metres_per_count=np.array([sensor.metres_per_count for sensor in sensors]),
        lowest=ends[:, 0],
        highest=ends[:, 1],
        matrix=response(joint),
        noise=np.array([np.nan if sensor.noise is None else sensor.noise for sensor in sensors]),
    )


def _ends(sensor: Sensor) -> tuple[int, int]:
    """Counts at which the transducer's range ends."""
    half = 2 ** (sensor.bits - 1)
    return sensor.range or ((-half, half - 1) if sensor.signed else (0, 2 * half - 1))
