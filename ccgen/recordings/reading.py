"""All recordings that a joint file names, read."""

from typing import TYPE_CHECKING

from ccgen.recordings.recording import Extent, Recording, read_recording
from ccgen.recordings.sensors import recorded_sensors

if TYPE_CHECKING:
    from ccgen.joint import Joint


def read_recordings(joint: "Joint", poses: bool = False) -> tuple[Recording, ...]:
    """Read the recordings of a joint, in the order of its file.

    Args:
        joint: whose file names them.
        poses: as of `read_recording`.

    Raises:
        InputError: as `read_recording`.
    """
    geometry = joint.geometry
    extent = Extent(
        geometry.segments, len(geometry.sections), geometry.length, geometry.range_of_motion
    )
    sensors = recorded_sensors(joint)
    return tuple(read_recording(file, sensors, extent, poses) for file in joint.recordings)
