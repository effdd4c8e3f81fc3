"""References of recordings that hold segment angles: the angles are the shape, sensors are learned.

Gains are those of all recordings to fit to; zeros are each recording's own. A recording to score
with takes both from them, its zeros from a stretch of its own where the joint file names one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.recordings.gains import (
    ZERO_STD,
    Calibration,
    Known,
    Sensed,
    borrowed,
    calibrated,
    stretch_zero,
)
from ccgen.recordings.learning import independent_rows
from ccgen.recordings.lengths import Read, expected_changes, read_lengths
from ccgen.recordings.movement import check_rest
from ccgen.recordings.recording import Recording
from ccgen.recordings.reference import Reference, learned_rows
from ccgen.recordings.sensors import RecordedSensors, recorded_sensors

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Part:
    """A recording on its way to a reference."""

    recording: Recording
    state: Floats
    change: Floats
    """Of each length by the state, shape (N, n), metres."""
    learned: Flags
    """Rows from which something may be learned, shape (N,)."""
    read: Read | None

    @property
    def fits(self) -> bool:
        """Whether it tells of the sensors."""
        return self.recording.file.use == "fit" and self.read is not None

    @property
    def lengths(self) -> Floats:
        assert self.read is not None
        return self.read.lengths


def dense_references(
    joint: "Joint",
    recordings: Sequence[Recording],
    without_block: int | None,
    common: Calibration | None = None,
) -> tuple[Reference, ...]:
    """References of recordings with segment angles; arguments as of `references`.

    Args:
        common: what other recordings of the joint told of its sensors.
    """
    sensors = recorded_sensors(joint)
    parts = [_part(joint, recording, sensors, without_block) for recording in recordings]
    telling = [part for part in parts if part.fits]
    common = _calibration(telling) if telling else common
    made = []
    for part in parts:
        if common is not None and part.fits:
            sensed = common.of(telling.index(part))
        elif part.read is not None:
            gain = np.ones(len(sensors.names)) if common is None else common.gain
            own = stretch_zero(part.recording, part.change, part.lengths, gain)
            sensed = borrowed(common, own, sensors)
        else:
            sensed = None
        made.append(_reference(part, sensed))
    return tuple(made)


def _part(
    joint: "Joint", recording: Recording, sensors: RecordedSensors, without_block: int | None
) -> _Part:
    state = dense_states(joint, recording)
    if recording.file.straight is not None:
        bends = state[recording.within(recording.file.straight), : 2 * joint.geometry.segments]
        check_rest(recording.source, recording.file.straight, bends, [], joint.geometry)
    change = expected_changes(state, sensors.matrix)
    learned = learned_rows(recording, without_block)
    read = None
    if recording.counts is not None:
        read = read_lengths(recording, sensors, change, learned)
    return _Part(recording, state, change, learned, read)


def dense_states(joint: "Joint", recording: Recording) -> Floats:
    """States u, v, h of a recording's rows, shape (N, 2m + S); NaN where unknown.

    Raises:
        InputError: counts of a joint that elongates beside angles alone.
    """
    assert recording.u is not None
    assert recording.v is not None
    u, v, h = recording.u, recording.v, recording.h
    if h is None:
        if joint.geometry.elongation is not None and recording.counts is not None:
            raise InputError(
                f"{recording.source}: has counts of a joint that elongates but no column "
                "elongation; add it, as a share of the length"
            )
        h = np.zeros((recording.rows, len(joint.geometry.sections)))
    u = u if "u" in joint.axes else np.nan_to_num(u)
    v = v if "v" in joint.axes else np.nan_to_num(v)
    return np.concatenate([u, v, h], axis=1)


def _calibration(parts: Sequence[_Part]) -> Calibration:
    """Gains of all recordings, zeros of each, from the rows that may be learned from."""
    lengths = [part.lengths[part.learned] for part in parts]
    known = [_known_zero(part) for part in parts]
    return calibrated(
        np.concatenate([part.change[part.learned] for part in parts]),
        np.concatenate(lengths),
        np.repeat(np.arange(len(parts)), [len(rows) for rows in lengths]).astype(np.intp),
        Known(np.stack([zero for zero, _ in known]), np.stack([std for _, std in known])),
        sum(independent_rows(rows) for rows in lengths),
    )


def _known_zero(part: _Part) -> tuple[Floats, Floats]:
    """Zeros as the recording's stretch tells them, or somewhere about its lengths; shape (n,)."""
    lengths = np.where(part.learned[:, None], part.lengths, np.nan)
    empty = np.isnan(lengths).all(axis=0)
    middle = np.nanmedian(np.where(empty, 0.0, lengths), axis=0)
    spread = np.full_like(middle, ZERO_STD)
    own = stretch_zero(part.recording, part.change, lengths, np.ones(len(middle)))
    if own is None:
        return middle, spread
    return np.where(np.isnan(own[0]), middle, own[0]), np.where(np.isnan(own[1]), spread, own[1])


def _reference(part: _Part, sensed: Sensed | None) -> Reference:
    recording, read = part.recording, part.read
    known = part.state[part.learned & ~np.isnan(part.state).any(axis=1)]
    return Reference(
        name=f"recording:{recording.file.file}",
        use=recording.file.use,
        t=recording.t,
        dense=True,
        state=part.state,
        covariance=None,
        second_moment=known.T @ known / max(len(known), 1),
        notes=recording.notes + _said(part),
    ).with_readings(read, sensed)


def _said(part: _Part) -> tuple[str, ...]:
    """What a reader of results should know of the rows, a line each."""
    source, notes = part.recording.source, []
    unknown = int(np.isnan(part.state).any(axis=1).sum())
    if unknown:
        notes.append(f"{source}: {unknown} of {len(part.state)} rows without a whole shape")
    return (*notes, *(part.read.notes(source) if part.read is not None else ()))
