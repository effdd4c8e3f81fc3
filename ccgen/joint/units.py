"""Numbers of a joint file that are legal and look as if they were meant in millimetres.

Every length in the file is in metres. A joint of 114.76 m is more likely one of 114.76 mm, and so
are a sensor far outside the joint, noise and counts as large as the movement that they measure, and
a camera that misses bodies by a part of the joint.
"""

from collections.abc import Iterator

from ccgen.joint.places import radius_key, sensor_key
from ccgen.joint.specification import Joint, Sensor

_LONG = 10.0
"""Metres that no joint is long, and no sensor away from its axis."""
_WIDE = 5.0
"""Distance from the neutral axis, in lengths of the joint."""
_VAGUE = 0.05
"""Lengths of the joint by which no camera misses a body."""
_COARSE = 0.25
"""Noise, or the step of a count, as a share of the movement."""


def unit_doubts(joint: Joint) -> tuple[str, ...]:
    """What looks like another unit: file, key, what is odd and what to write; a sentence each."""
    said: dict[str, str] = {}
    for key, what in _doubts(joint):
        said.setdefault(key, f"{joint.source}: {key}: {what}")
    return tuple(said.values())


def _doubts(joint: Joint) -> Iterator[tuple[str, str]]:
    """Keys, and what is odd of them; a key that sensors share comes for each of them."""
    length = joint.geometry.length
    if length > _LONG:
        yield (
            "geometry.length",
            f"a joint {length:g} m long is unusual; lengths are in metres, {length:g} mm are "
            f"{length / 1e3:g}",
        )
    for k, recording in enumerate(joint.recordings):
        noise = recording.position_noise or 0.0
        if noise > _VAGUE * length:
            yield (
                f"recordings[{k}].position_noise",
                f"bodies are {noise:g} m off on a joint {length:g} m long; {noise:g} mm are "
                f"{noise / 1e3:g}",
            )
    for j, sensor in enumerate(joint.sensors):
        if sensor.radius > min(_LONG, _WIDE * length):
            yield (
                radius_key(joint, j),
                f"sensor {sensor.name} runs {sensor.radius:g} m from the neutral axis of a joint "
                f"{length:g} m long; radii are in metres, {sensor.radius:g} mm are "
                f"{sensor.radius / 1e3:g}",
            )
        moves = _movement(joint, sensor)
        for key, value, what in (
            ("noise", sensor.noise or 0.0, "noise"),
            ("metres_per_count", abs(sensor.metres_per_count), "one count"),
        ):
            if value > _COARSE * moves:
                yield (
                    sensor_key(joint, j, key),
                    f"{what} of {value:g} m is {value / moves:.2g} times what sensor "
                    f"{sensor.name} moves over the range of motion, {moves:.3g} m; {value:g} mm "
                    f"are {value / 1e3:g}",
                )


def _movement(joint: Joint, sensor: Sensor) -> float:
    """How far a sensor moves where all its segments bend, or elongate, as far as they go; m."""
    geometry = joint.geometry
    stretch = max(map(abs, geometry.elongation or (0.0,)))
    per_segment = sensor.radius * geometry.range_of_motion + stretch * geometry.segment_length
    return sensor.segments * per_segment
