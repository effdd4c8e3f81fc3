"""The sensors of a joint as a recording sees them: names, counts, and what they measure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import AXES, Joint
from ccgen.sensing.counts import lengths_per_radian
from ccgen.sensing.readings import reading_matrix

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
    """Return the sensors of a joint: u0 ..., then v0 ..., for the paper's sets."""
    m = joint.geometry.segments
    names: list[str] = []
    parts: list[tuple[Floats, ...]] = []
    for i, axis in enumerate(AXES):
        sensors = joint.axis(axis)
        n, transducer = len(sensors.spans), sensors.transducer
        names += [f"{axis}{j}" for j in range(n)]
        low, high = transducer.range or (
            -(2 ** (transducer.bits - 1)),
            2 ** (transducer.bits - 1) - 1,
        )
        matrix = np.zeros((n, 2 * m + 1))
        matrix[:, i * m : (i + 1) * m] = (
            reading_matrix(m, sensors.spans) * lengths_per_radian(sensors)[:, None]
        )
        matrix[:, 2 * m] = [(b - a + 1) * joint.geometry.segment_length for a, b in sensors.spans]
        noise = np.nan if transducer.noise is None else transducer.noise
        parts.append(
            (
                np.full(n, transducer.metres_per_count),
                np.full(n, float(low)),
                np.full(n, float(high)),
                matrix,
                np.full(n, noise),
            )
        )
    step, low_all, high_all, whole, noise_all = (
        np.concatenate(part) for part in zip(*parts, strict=True)
    )
    return RecordedSensors(tuple(names), step, low_all, high_all, whole, noise_all)
