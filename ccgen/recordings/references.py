"""Recordings turned into reference shapes: angles are the shape, bodies and markers tell of it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.recordings.bodies import body_references
from ccgen.recordings.dense import dense_references
from ccgen.recordings.gains import Calibration
from ccgen.recordings.movement import check_resting_sensors
from ccgen.recordings.progress import Report, in_silence
from ccgen.recordings.recording import Recording
from ccgen.recordings.reference import Reference

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]
_Kind = Callable[
    ["Joint", Sequence[Recording], int | None, Calibration | None], tuple[Reference, ...]
]


def references(
    joint: "Joint",
    recordings: Sequence[Recording],
    without_block: int | None = None,
    whole: Sequence[Reference] = (),
    report: Report = in_silence,
) -> tuple[Reference, ...]:
    """Turn recordings into reference shapes, and learn of their sensors.

    Recordings with segment angles know the whole shape: gains that they tell are known beforehand
    for those with bodies.

    Args:
        joint: whose recordings they are.
        recordings: as `ccgen.recordings.reading.read_recordings` returns them.
        without_block: 0 to 4; nothing is learned from these rows of recordings to fit to: no gain,
            zero, delay or second moment. Their states and lengths come out all the same.
        whole: the references without anything left out; what is found anew without a block is
            sought from there on.
        report: told of the progress.

    Returns:
        A reference for each recording, in their order.

    Raises:
        InputError: a recording that makes no reference; in one line which, and what would.
    """
    known = [_with_shape(joint, recording) for recording in recordings]
    dense = [i for i, recording in enumerate(known) if recording.dense]
    bodies = [i for i, recording in enumerate(known) if not recording.dense]
    begin = [whole[i] for i in bodies] if whole else []
    kinds: list[tuple[list[int], _Kind]] = [
        (dense, dense_references),
        (bodies, partial(body_references, whole=begin, report=report)),
    ]
    if not any(known[i].file.use == "fit" and known[i].counts is not None for i in dense):
        kinds.reverse()
    common: Calibration | None = None
    made: dict[int, Reference] = {}
    for numbers, kind in kinds:
        some = kind(joint, [known[i] for i in numbers], without_block, common)
        made |= dict(zip(numbers, some, strict=True))
        common = _told(some)
    return tuple(made[i] for i in range(len(known)))


def _with_shape(joint: "Joint", recording: Recording) -> Recording:
    """A recording of counts alone with the one shape that is known of it: straight.

    Raises:
        InputError: it names no straight stretch, or sensors move in it.
    """
    if recording.dense or any(body.station is not None for body in recording.bodies):
        return recording
    straight = recording.file.straight
    if straight is None:
        raise InputError(
            f"{recording.source}: tells nothing of the joint's shape; add angles or bodies, or "
            "straight = [t0, t1], the seconds in which the joint was straight"
        )
    if recording.counts is not None:
        step = np.array([sensor.metres_per_count for sensor in joint.sensors])
        there = recording.within(straight, recording.counts.t)
        lengths = recording.counts.values[there] * step
        check_resting_sensors(recording.source, straight, lengths, joint)
    rows, m = recording.within(straight), joint.geometry.segments
    known = np.where(rows, 0.0, np.nan)[:, None]
    h = np.tile(known, len(joint.geometry.sections))
    return replace(recording, u=np.tile(known, m), v=np.tile(known, m), h=h)


def _told(references: Sequence[Reference]) -> Calibration | None:
    """What references to fit to tell of the sensors; None where they tell nothing."""
    telling = [one for one in references if one.use == "fit" and one.gain is not None]
    if not telling:
        return None

    def each(name: str) -> Floats:
        return np.stack([getattr(one, name) for one in telling])

    first = telling[0]
    return Calibration(
        each("gain")[0],
        each("gain_std")[0],
        each("zero"),
        each("zero_std"),
        each("noise")[0],
        np.ones_like(first.state[:, :0]),
    )
