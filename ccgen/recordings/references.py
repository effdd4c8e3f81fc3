"""Recordings turned into reference shapes: segment angles are the shape themselves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ccgen.errors import InputError
from ccgen.recordings.dense import dense_references
from ccgen.recordings.recording import Recording
from ccgen.recordings.reference import Reference

if TYPE_CHECKING:
    from ccgen.joint import Joint


def references(
    joint: "Joint", recordings: Sequence[Recording], without_block: int | None = None
) -> tuple[Reference, ...]:
    """Turn recordings into reference shapes, and learn of their sensors.

    Args:
        joint: whose recordings they are.
        recordings: as `ccgen.recordings.reading.read_recordings` returns them.
        without_block: 0 to 4; nothing is learned from these rows of recordings to fit to: no gain,
            zero, delay or second moment. Their states and lengths come out all the same.

    Returns:
        A reference for each recording, in their order.

    Raises:
        InputError: a recording that makes no reference; in one line which, and what would.
    """
    for recording in recordings:
        if not recording.dense:
            raise InputError(
                f"{recording.source}: has no segment angles, and this version makes no "
                "reference of bodies; add columns u0 ... v0 ..., or remove it from [[recordings]]"
            )
    return dense_references(joint, recordings, without_block)
