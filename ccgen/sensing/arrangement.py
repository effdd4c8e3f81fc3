"""Where sensors run, as drawings and tables tell it."""

import math

from ccgen.joint import Joint, Sensor


def angle_degrees(sensor: Sensor) -> float:
    """Angle around the neutral axis from +x, 0 or more and below 360 degrees."""
    return round(math.degrees(sensor.angle), 9) % 360.0


def unrolled(joint: Joint) -> list[Sensor]:
    """The sensors in the order of their angles, those of one angle from the base on."""
    return sorted(joint.sensors, key=lambda sensor: (angle_degrees(sensor), sensor.start))
