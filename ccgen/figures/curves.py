"""A joint as lines in space: its neutral axis, its frames, and its sensors as strings.

Metres in the base frame, z along the unbent axis. Pictures on paper and on screen are drawn from
these alone, so that they show one geometry.
"""

from collections.abc import Sequence

import numpy as np

from ccgen.figures.style import Floats
from ccgen.joint import Joint, Sensor
from ccgen.kinematics import chain
from ccgen.sensing.readings import direction

POINTS_PER_SEGMENT = 8
_LANE = 0.08
"""Radians between sensors that would hide each other."""


def frames_along(u: Floats, v: Floats, lengths: Floats) -> Floats:
    """Frames along the neutral axis, several a segment.

    Args:
        u: bends of the segments about x, shape (m,), radians.
        v: the same about y.
        lengths: of the segments, shape (m,), metres.

    Returns:
        Homogeneous transforms, shape (m * POINTS_PER_SEGMENT + 1, 4, 4), the base first; those of
        the segments' ends are every `POINTS_PER_SEGMENT`-th.
    """
    parts = (np.repeat(x / POINTS_PER_SEGMENT, POINTS_PER_SEGMENT) for x in (u, v, lengths))
    return np.concatenate([np.eye(4)[None], chain(*parts)])


def space_curve(u: Floats, v: Floats, lengths: Floats) -> Floats:
    """Neutral axis of a joint, shape (points, 3), the base included; arguments: `frames_along`."""
    return frames_along(u, v, lengths)[:, :3, 3]


def planar_curve(angles: Floats, segment_length: float) -> tuple[Floats, Floats]:
    """Neutral axis of a joint bent in one plane, several points a segment.

    Args:
        angles: segment angles of the bending axis, shape (m,), radians.
        segment_length: metres.

    Returns:
        Deflection, to the right for a positive angle, and height along the unbent axis, shape
        (points,), metres, the base included.
    """
    bent = np.asarray(angles)
    curve = space_curve(np.zeros_like(bent), bent, np.full_like(bent, segment_length))
    return curve[:, 0], curve[:, 2]


def string_paths(joint: Joint, frames: Floats) -> list[Floats]:
    """Where the sensors run on a bent joint.

    Sensors at one place around the joint whose spans overlap are drawn beside each other, a few
    degrees apart, or one would hide the other.

    Args:
        joint: its geometry and sensors.
        frames: of `frames_along`.

    Returns:
        A line a sensor, shape (points, 3), metres; an end within a segment lies at the nearest
        frame.
    """
    lanes = _lanes(joint.sensors)
    return [
        _path(joint.geometry.segments, frames, sensor, _LANE * lane)
        for sensor, lane in zip(joint.sensors, lanes, strict=True)
    ]


def _path(segments: int, frames: Floats, sensor: Sensor, aside: float) -> Floats:
    first = min(round(sensor.start * POINTS_PER_SEGMENT), segments * POINTS_PER_SEGMENT - 1)
    last = max(round(sensor.end * POINTS_PER_SEGMENT), first + 1)
    sine, cosine = direction(sensor)
    x, y = sensor.radius * cosine, sensor.radius * sine
    turned = np.cos(aside) * x - np.sin(aside) * y, np.sin(aside) * x + np.cos(aside) * y
    return np.asarray((frames[first : last + 1] @ np.array([*turned, 0.0, 1.0]))[:, :3])


def _lanes(sensors: Sequence[Sensor]) -> list[int]:
    """Of each sensor how many lanes it is drawn beside its place: 0, 1, -1, 2 and so on."""
    ends: dict[tuple[float, float], list[float]] = {}
    chosen = [0] * len(sensors)
    for j in sorted(range(len(sensors)), key=lambda j: sensors[j].start):
        sensor = sensors[j]
        taken = ends.setdefault((sensor.angle, sensor.radius), [])
        free = [k for k, end in enumerate(taken) if end <= sensor.start]
        k = free[0] if free else len(taken)
        taken[k : k + 1] = [sensor.end]
        chosen[j] = (k + 1) // 2 if k % 2 else -(k // 2)
    return chosen
