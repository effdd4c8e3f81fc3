"""What all rows of a joint's recordings share: compliance, sizes, gains, zeros, second moment.

Rows of several recordings are learned from together (`ccgen.recordings.learning`); each has its own
frame and zeros. Where no straight stretch fixes a frame, or nobody stated the noise of bodies, that
and what is shared are found in turn.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.frames import Spread
from ccgen.recordings.gains import ZERO_STD, Calibration, stretch_zero
from ccgen.recordings.learning import Learned, learn, most_probable
from ccgen.recordings.lengths import Read
from ccgen.recordings.likelihood import Evidence, Lengths, Parameters
from ccgen.recordings.modes import Model, fixed_model
from ccgen.recordings.recording import Recording
from ccgen.recordings.refined import refined, unstated
from ccgen.recordings.sensors import RecordedSensors
from ccgen.recordings.sights import Frame, Sights, evidence

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_ROWS = 400
"""Of all recordings together from which is learned what they share."""
_SEEN = 2400
"""Bodies in all of those rows together that are enough: many in a row tell more of it."""
_GAIN_STD = 0.02
"""Of a gain about 1 where the joint file states no tolerance."""
_NOISE = 1e-3
"""Of lengths to begin with, share of the joint's."""


@dataclass(frozen=True, eq=False)
class Part:
    """A recording with bodies on its way to a reference.

    Attributes:
        recording: what was read.
        sights: its bodies near the base frame.
        frame: from there to the joint.
        spread: how far the frame might have been off before it was sought.
        rows: with bodies in sight, from which may be learned.
        independent: number of rows as which those count.
        state: by bodies alone, twist included, shape (N, p).
        read: what sensors read; None without counts.
    """

    recording: Recording
    sights: Sights
    frame: Frame
    spread: Spread
    rows: Indices
    independent: float
    state: Floats
    read: Read | None

    def lengths(self, sensors: int) -> Floats:
        """Readings, all missing where there are none, shape (N, n), metres."""
        if self.read is None:
            return np.full((len(self.sights), sensors), np.nan)
        return self.read.lengths


@dataclass(frozen=True, eq=False)
class Shared:
    """What the rows of all recordings have in common.

    Attributes:
        model: how shapes come about.
        found: compliances and sizes, gains and zeros.
        calibration: of the sensors; None where none of the recordings has counts.
        second_moment: of states with their twist, shape (p, p).
        compliance: of equal parts of the joint from its base, natural logarithms, and their
            standard deviations, shape (2, parts); None where it was not learned.
        learned: where all this comes from; None where there was nothing to learn from.
        doubt: covariance of what was found, in its order; None where it is not known.
    """

    model: Model
    found: Parameters
    calibration: Calibration | None
    second_moment: Floats
    compliance: Floats | None = None
    learned: Learned | None = None
    doubt: Floats | None = None

    def doubt_of(self, group: int | None, zero_std: Floats) -> Floats | None:
        """Covariance of compliances, sizes, gains, and zeros of one recording.

        Args:
            group: number of the recording; None for one that was not learned from.
            zero_std: of its zeros then, shape (n,), metres.
        """
        if self.doubt is None:
            return None
        n = self.found.zero.shape[1]
        common = len(self.doubt) - self.found.zero.size
        whole = np.zeros((common + n, common + n))
        if group is None:
            whole[:common, :common] = self.doubt[:common, :common]
            whole[common:, common:] = np.diag(np.square(zero_std))
            return whole
        own = np.r_[0:common, common + group * n : common + (group + 1) * n]
        return np.asarray(self.doubt[np.ix_(own, own)])

    @property
    def transform(self) -> Floats:
        """The map of coordinates to states, shape (p, k)."""
        return self.model.transform(self.found.log_compliance, self.found.log_size)


def nothing_learned(model: Model) -> Parameters:
    """What rows have in common before anything is learned, without sensors."""
    compliances, sizes = np.zeros(model.compliances), np.zeros(model.sizes)
    return Parameters(compliances, sizes, np.zeros(0), np.zeros((1, 0)))


def usual(model: Model) -> Floats:
    """The map of coordinates to states before anything is learned, shape (p, k)."""
    nothing = nothing_learned(model)
    return model.transform(nothing.log_compliance, nothing.log_size)


def with_twist(matrix: Floats) -> Floats:
    """Changes of length by a state that ends with the twist, which no sensor reads."""
    return np.concatenate([matrix, np.zeros((len(matrix), 1))], axis=1)


def pooled(
    joint: "Joint",
    parts: Sequence[Part],
    models: Sequence[Model],
    sensors: RecordedSensors,
    common: Calibration | None,
    before: Learned | None = None,
) -> tuple[Shared, list[Part]]:
    """Learn what recordings share, and their frames where those were not certain.

    Args:
        joint: whose recordings they are.
        parts: those to fit to.
        models: how shapes may come about; the last one where nothing is recorded.
        sensors: those of the joint.
        common: what other recordings told of them.
        before: what nearly the same rows told, to begin with.
    """
    if not parts:
        T = usual(models[-1])
        return Shared(models[-1], nothing_learned(models[-1]), None, T @ T.T), []
    own = list(parts)
    shared = _shared(joint, own, models, sensors, common, before)
    settled = all(part.spread.certain for part in own)
    if not settled or (before is None and any(any(unstated(part.recording)) for part in own)):
        own = [_resettled(part, i, shared, sensors) for i, part in enumerate(own)]
        start = shared.learned if settled else before
        shared = _shared(joint, own, models, sensors, common, start)
    return shared, own


def _shared(
    joint: "Joint",
    parts: Sequence[Part],
    models: Sequence[Model],
    sensors: RecordedSensors,
    common: Calibration | None,
    before: Learned | None,
) -> Shared:
    learned = _learned(joint, parts, models, sensors, common, before)
    model = learned.model
    sections = joint.geometry.sections
    calibration = None
    if any(part.read is not None for part in parts):
        found, spread = learned.found, learned.spread
        calibration = Calibration(
            found.gain, spread.gain, found.zero, spread.zero, learned.noise, learned.trust
        )
    moment = sections_apart(learned.second_moment, sections)
    if len(sections) == 1:
        compliance = _compliance(learned)
        known = compliance if compliance.size else None
        told = learned.covariance
        return Shared(model, learned.found, calibration, moment, known, learned, told)
    # Sections that happened to bend alike may bend otherwise in other rows.
    T = model.transform(learned.found.log_compliance, learned.found.log_size)
    free = fixed_model(sections_apart(T @ T.T, sections))
    found = replace(learned.found, log_compliance=np.zeros(0), log_size=np.zeros(0))
    return Shared(free, found, calibration, moment, learned=learned)


def _compliance(learned: Learned) -> Floats:
    """Logarithms of compliance, and standard deviations of their differences from the mean one.

    How soft the whole joint is, no shapes tell; it does not count. Shape (2, c).
    """
    soft = learned.model.expected + learned.found.log_compliance
    c = len(soft)
    stiff = np.exp(-soft)
    apart = np.eye(c) - stiff / max(stiff.sum(), np.finfo(float).tiny)
    own = learned.covariance[:c, :c]
    return np.stack([soft, np.sqrt(np.einsum("ij,jk,ik->i", apart, own, apart))])


def sections_apart(moment: Floats, sections: Sequence[int]) -> Floats:
    """A second moment as if every section had also gone its own way, whatever others did.

    Args:
        moment: of u, v, elongation and twist, shape (p, p).
        sections: segments of each, or what those are a multiple of.
    """
    S = len(sections)
    m = (len(moment) - S - 1) // 2
    own = np.repeat(np.arange(S), [m * section // sum(sections) for section in sections])
    number = np.concatenate([own, own, np.arange(S), [S]])
    alike = number[:, None] == number
    return np.asarray((moment + np.where(alike, moment, 0.0)) / 2)


def _learned(
    joint: "Joint",
    parts: Sequence[Part],
    models: Sequence[Model],
    sensors: RecordedSensors,
    common: Calibration | None,
    before: Learned | None,
) -> Learned:
    bodies = max(len(part.sights.names) for part in parts)
    most = min(_ROWS, _SEEN // bodies) // len(parts)
    chosen = [_some(part, most) for part in parts]
    sights = [part.sights.rows(rows) for part, rows in zip(parts, chosen, strict=True)]
    ends = np.cumsum([len(rows) for rows in chosen])[:-1]

    def sight(states: Floats) -> Evidence:
        split = np.split(states, ends)
        said = [
            evidence(one, part.frame, x) for one, part, x in zip(sights, parts, split, strict=True)
        ]
        return Evidence(
            np.concatenate([one.information for one in said]),
            np.concatenate([one.potential for one in said]),
        )

    seen = _seen(joint, parts, chosen, sensors, common)
    start = np.concatenate([part.state[rows] for part, rows in zip(parts, chosen, strict=True)])
    independent = sum(part.independent for part in parts)
    if before is None:
        return most_probable(sight, models, seen, independent, start)
    return learn(sight, before.model, seen, independent, start, before)


def _some(part: Part, most: int) -> Indices:
    """Rows spread over a recording, about `most` of them."""
    return part.rows[:: max(1, len(part.rows) // most)]


def _seen(
    joint: "Joint",
    parts: Sequence[Part],
    chosen: Sequence[Indices],
    sensors: RecordedSensors,
    common: Calibration | None,
) -> Lengths:
    """Readings of recordings, and what is known of their sensors beforehand."""
    n = len(sensors.names)
    tolerance = np.array([sensor.gain_tolerance for sensor in joint.sensors])
    gain, gain_std = np.ones(n), np.where(tolerance > 0, tolerance, _GAIN_STD)
    noise = np.where(np.isnan(sensors.noise), _NOISE * joint.geometry.length, sensors.noise)
    if common is not None:
        gain, gain_std = common.gain, common.gain_std
        noise = np.where(np.isnan(common.noise), noise, common.noise)
    zeros = [_zero(part, rows, gain) for part, rows in zip(parts, chosen, strict=True)]
    return Lengths(
        length=np.concatenate(
            [part.lengths(n)[rows] for part, rows in zip(parts, chosen, strict=True)]
        ),
        matrix=with_twist(sensors.matrix),
        group=np.repeat(np.arange(len(parts)), [len(rows) for rows in chosen]).astype(np.intp),
        gain=gain,
        gain_std=gain_std,
        zero=np.stack([zero for zero, _ in zeros]),
        zero_std=np.stack([std for _, std in zeros]),
        noise=np.maximum(noise, np.abs(sensors.metres_per_count) / np.sqrt(12.0)),
    )


def _zero(part: Part, rows: Indices, gain: Floats) -> tuple[Floats, Floats]:
    """Zeros of a recording about which they are sought, and how far they may be off; (n,) each."""
    lengths = part.lengths(len(gain))
    none = np.isnan(lengths[rows]).all(axis=0)
    middle = np.nanmedian(np.where(none, 0.0, lengths[rows]), axis=0)
    spread = np.full(len(gain), ZERO_STD)
    if part.recording.file.straight is None:
        return middle, spread
    own = stretch_zero(
        replace(part.recording, file=replace(part.recording.file, zero_from=None)),
        np.zeros_like(lengths),
        lengths,
        gain,
    )
    assert own is not None
    return np.where(np.isnan(own[0]), middle, own[0]), np.where(np.isnan(own[1]), spread, own[1])


def _resettled(part: Part, group: int, shared: Shared, sensors: RecordedSensors) -> Part:
    """A recording with its frame and noise found anew, by what was learned and by its readings."""
    rows = _some(part, _ROWS)
    known = None
    spread = part.spread
    if part.read is not None and shared.calibration is not None:
        sensed = shared.calibration.of(group)
        known = _told(part.read.lengths[rows], sensed.gain, sensed.zero, sensed.noise, sensors)
        spread = replace(spread, rotation=spread.about_axis)
    share = min(1.0, part.independent / max(len(part.rows), 1))
    some = part.sights.rows(rows)
    T, noisy = shared.transform, unstated(part.recording)
    some, frame = refined(some, part.frame, spread, T, share, known, noisy)
    return replace(part, frame=frame, sights=some.noise_of(part.sights))


def _told(
    lengths: Floats, gain: Floats, zero: Floats, noise: Floats, sensors: RecordedSensors
) -> Evidence:
    """What readings say of states with twist."""
    there = ~np.isnan(lengths)
    sensed = gain[:, None] * with_twist(sensors.matrix) / noise[:, None]
    off = np.where(there, (lengths - zero) / noise, 0.0)
    information = (sensed.T * there[:, None, :]) @ sensed
    return Evidence(information, off @ sensed)
