"""Which recordings of a joint tell of its sensors, and what each of them holds.

A recording with segment angles or bodies is followed through its reference shapes; counts alone
tell of the straight joint; a few rows of angles are poses that somebody knew.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.calibration.poses import Held, known_poses, straight_joint
from ccgen.calibration.seen import Seen
from ccgen.errors import InputError
from ccgen.joint import Joint
from ccgen.recordings.checks import FEWEST_ROWS
from ccgen.recordings.clocks import sampled
from ccgen.recordings.dense import dense_states
from ccgen.recordings.lengths import expected_changes
from ccgen.recordings.reading import read_recordings
from ccgen.recordings.recording import Recording
from ccgen.recordings.reference import Reference
from ccgen.recordings.references import references
from ccgen.sensing.noise import length_variance
from ccgen.sensing.readings import response

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Followed:
    """A recording whose shapes are known throughout, for n sensors and N rows.

    Attributes:
        recording: as its files hold it.
        reference: its shapes, and what was learned of the sensors.
        expected: changes of length of the shapes, shape (N, n), metres; NaN where unknown.
        lengths: readings at nominal gain, shape (N, n), metres; NaN where missing or stuck.
        raw: the same with those that stick.
        read: readings at nominal gain at the sensors' own times, shape (K, n), metres.
        beside: changes of length at those times, shape (K, n), metres; NaN where unknown.
    """

    recording: Recording
    reference: Reference
    expected: Floats
    lengths: Floats
    raw: Floats
    read: Floats
    beside: Floats

    @property
    def gain(self) -> Floats:
        """As learned, by the nominal one, shape (n,)."""
        return self._learned("gain")

    @property
    def gain_std(self) -> Floats:
        """Of the gain, shape (n,)."""
        return self._learned("gain_std")

    @property
    def zero(self) -> Floats:
        """Reading of the straight joint, shape (n,), metres."""
        return self._learned("zero")

    @property
    def zero_std(self) -> Floats:
        """Of the zero, shape (n,), metres."""
        return self._learned("zero_std")

    @property
    def noise(self) -> Floats:
        """One standard deviation of a reading, shape (n,), metres."""
        return self._learned("noise")

    def misfit(self, own: bool) -> Floats:
        """Readings less what was learned of them: at their own times, or at the reference's.

        Returns:
            Shape (K, n) or (N, n), metres; NaN where one of them is missing.
        """
        read, expected = (self.read, self.beside) if own else (self.lengths, self.expected)
        return np.asarray(read - self.gain * expected - self.zero)

    def _learned(self, name: str) -> Floats:
        value = getattr(self.reference, name)
        assert value is not None  # of a recording with counts
        return np.asarray(value)


@dataclass(frozen=True, eq=False)
class Posed:
    """A few rows of known angles, poses that the joint was held in.

    Attributes:
        recording: as its files hold it.
        expected: changes of length, shape (N, n), metres; NaN where unknown.
        lengths: readings at nominal gain, shape (N, n), metres; NaN where there is none.
        held: what they told.
    """

    recording: Recording
    expected: Floats
    lengths: Floats
    held: Held


@dataclass(frozen=True, eq=False)
class Sources:
    """What tells of a joint's sensors.

    Attributes:
        step: nominal metres per count of the n sensors, shape (n,).
        followed: recordings with reference shapes.
        posed: poses of known angles.
        straight: what the straight joint told.
        notes: what readers should know, a line each.
    """

    step: Floats
    followed: tuple[Followed, ...]
    posed: tuple[Posed, ...]
    straight: tuple[Held, ...]
    notes: tuple[str, ...]

    @property
    def held(self) -> tuple[Held, ...]:
        """What poses that are known without cameras told."""
        return (*(one.held for one in self.posed), *self.straight)

    @property
    def seen(self) -> tuple[Seen, ...]:
        """What sensors read beside what they should, wherever the shape is known."""
        followed = (
            Seen(
                source=one.recording.source,
                t=one.reference.t,
                timed=one.recording.timed,
                expected=one.expected,
                lengths=one.lengths,
                raw=one.raw,
                step=self.step,
                noise=float(np.nanmedian(one.noise)),
            )
            for one in self.followed
        )
        posed = (
            Seen(
                source=one.recording.source,
                t=one.recording.t,
                timed=False,
                expected=one.expected,
                lengths=one.lengths,
                raw=one.lengths,
                step=self.step,
            )
            for one in self.posed
        )
        return (*followed, *posed)


def counted(joint: Joint) -> tuple[Recording, ...]:
    """Read those recordings of a joint that are there to fit to and have counts.

    Raises:
        InputError: there are none, or one makes no sense.
    """
    files = tuple(file for file in joint.recordings if file.use == "fit")
    if not files:
        what = 'of use = "fit"' if joint.recordings else "stands there"
        raise InputError(
            f"{joint.source}: recordings: none {what}, and calibrate needs counts of the sensors; "
            'write [[recordings]] with file = "run1.csv"'
        )
    read = read_recordings(replace(joint, recordings=files), poses=True)
    recordings = tuple(one for one in read if one.counts is not None)
    if not recordings:
        raise InputError(
            f"{joint.source}: recordings: none has counts of the sensors; add columns such as "
            f"count_{joint.sensors[0].name}, or name a file that has them with counts"
        )
    return recordings


def without(recording: Recording, silent: Sequence[bool]) -> Recording:
    """A recording without the readings of some of the n sensors."""
    counts = recording.counts
    assert counts is not None
    values = np.where(np.asarray(silent), np.nan, counts.values)
    return replace(recording, counts=replace(counts, values=values))


def sources_of(joint: Joint, recordings: Sequence[Recording]) -> Sources:
    """What recordings with counts tell, by the nominal gains of a joint.

    Raises:
        InputError: a recording that makes no reference.
    """
    alone = [one for one in recordings if not one.dense and not one.bodies]
    posed = [one for one in recordings if one.dense and one.rows < FEWEST_ROWS]
    rest = [one for one in recordings if one not in alone and one not in posed]
    step = np.array([sensor.metres_per_count for sensor in joint.sensors])
    straight = tuple(straight_joint(joint, one) for one in alone)
    noise = _known_noise(joint, straight)
    followed = references(joint, rest) if rest else ()
    said = [*(one.notes for one in (*alone, *posed)), *(one.notes for one in followed)]
    return Sources(
        step=step,
        followed=tuple(_followed(joint, step, *one) for one in zip(rest, followed, strict=True)),
        posed=tuple(_posed(joint, step, one, noise) for one in posed),
        straight=straight,
        notes=tuple(dict.fromkeys(note for notes in said for note in notes)),
    )


def _followed(joint: Joint, step: Floats, recording: Recording, reference: Reference) -> Followed:
    counts, lengths = recording.counts, reference.lengths
    assert counts is not None
    assert lengths is not None
    read, expected = counts.values * step, expected_changes(reference.state, response(joint))
    return Followed(
        recording=recording,
        reference=reference,
        expected=expected,
        lengths=lengths,
        raw=sampled(counts.t, read, reference.t + reference.delay_s),
        read=read,
        beside=sampled(reference.t, expected, counts.t - reference.delay_s),
    )


def _known_noise(joint: Joint, straight: Sequence[Held]) -> Floats:
    """Noise as stated or as read at rest, whichever is more, with the step of the counts."""
    return np.asarray(
        np.fmax.reduce([np.sqrt(length_variance(joint)), *(one.noise for one in straight)])
    )


def _posed(joint: Joint, step: Floats, recording: Recording, noise: Floats) -> Posed:
    counts = recording.counts
    assert counts is not None
    lengths = sampled(counts.t, counts.values * step, recording.t)
    expected = expected_changes(dense_states(joint, recording), response(joint))
    return Posed(recording, expected, lengths, known_poses(expected, lengths, noise))
