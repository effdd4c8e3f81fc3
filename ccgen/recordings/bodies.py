"""References of recordings that follow bodies or markers: the most probable shape of each row.

Few bodies do not determine many segments: bodies and readings together, with what all rows share,
say most of it (`ccgen.recordings.pooled`); what is left open stays with the prior and shows in the
covariance. What is shared is learned from some of the rows; shapes come of all of them.

How a body sits on the joint is constant over its recording and says nothing of the sensors: with a
block of rows held out, frames stay those of the whole recording, which the block is judged in too.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.joint.specification import Geometry
from ccgen.recordings.fine import Fine, fine
from ccgen.recordings.frames import mean_frame, mounted, no_spread, sighted
from ccgen.recordings.gains import Calibration, Sensed, borrowed, stretch_zero
from ccgen.recordings.learning import independent_rows, shapes, states
from ccgen.recordings.lengths import Read, expected_changes, read_lengths
from ccgen.recordings.likelihood import Evidence, Lengths, Parameters, Posterior
from ccgen.recordings.modes import Model, joint_models
from ccgen.recordings.pooled import Part, Shared, nothing_learned, pooled, usual, with_twist
from ccgen.recordings.progress import Report, in_silence
from ccgen.recordings.recording import Recording
from ccgen.recordings.reference import Reference, learned_rows
from ccgen.recordings.refined import refined, unstated
from ccgen.recordings.sensors import RecordedSensors, recorded_sensors
from ccgen.recordings.sights import CLOSER, FAR, NEAR, Frame, Sights, evidence, outliers
from ccgen.recordings.stations import Sighting

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]

_APPROACH = ((FAR, 4), (CLOSER, 1), (NEAR, 2))
"""How often shapes are sought anew from the straight joint on, by how well they are known."""
_TURNS, _TURNS_ANEW = 3, 1
"""How often shapes by bodies and readings are sought anew."""
_MANY = 8
"""Bodies that tell how smooth a shape is."""
_ROWS = 250
"""Whose shapes are sought at once."""
_WITHIN, _BETWEEN = 0.5, 0.3
"""Shares of the doubt about what was learned that count for segments, and for bends and places
between bodies. To first order the doubt lets go what bodies and readings hold, most of all between
them: whole, it made simulated joints seem one and a half times to twice as uncertain as they were.
"""
_FRAME_ROWS = 400
"""From which a frame is found."""


def body_references(
    joint: "Joint",
    recordings: Sequence[Recording],
    without_block: int | None,
    common: Calibration | None = None,
    whole: Sequence[Reference] = (),
    report: Report = in_silence,
) -> tuple[Reference, ...]:
    """References of recordings with bodies; arguments as of `references`.

    Args:
        common: what other recordings of the joint told of its sensors.
        whole: the references without anything left out, in the order of the recordings. With them,
            states of the rows that are left out, and what nobody asks of the others, stay unknown;
            recordings to score with are theirs.
        report: told of the progress.
    """
    rough = _rough(recordings)
    cut = fine(joint.geometry, rough or _directed(recordings))
    sensors = recorded_sensors(joint)
    sensors = replace(sensors, matrix=sensors.matrix @ cut.gather)
    models = joint_models(cut.geometry, joint.loads, rough)
    telling: dict[int, Part] = {}
    steps = 2 * len(recordings) + 1
    for i, recording in enumerate(recordings):
        report("shapes of bodies", i, steps)
        if recording.file.use == "fit":
            telling[i] = (
                _part_anew(whole[i], recording, sensors, without_block)
                if whole
                else _part(cut.geometry, recording, models[-1], sensors)
            )
    report("shapes of bodies", len(recordings), steps)
    before = next((one.learned for one in whole if one.learned is not None), None)
    shared, settled = pooled(joint, list(telling.values()), models, sensors, common, before)
    telling = dict(zip(telling, settled, strict=True))
    made = []
    for i, recording in enumerate(recordings):
        report("shapes of bodies", len(recordings) + 1 + i, steps)
        if i in telling:
            group = list(telling).index(i)
            sensed = None if shared.calibration is None else shared.calibration.of(group)
            if whole:
                allowed = learned_rows(recording, without_block)
                made.append(_anew(whole[i], telling[i], shared, sensed, sensors, cut, allowed))
            else:
                made.append(_reference(telling[i], shared, sensed, sensors, cut, group))
        elif whole:
            made.append(whole[i])
        else:
            part = _part(cut.geometry, recording, models[-1], sensors, settled)
            sensed = _borrowed(part, shared, common, sensors)
            made.append(_reference(part, shared, sensed, sensors, cut))
    report("shapes of bodies", steps, steps)
    return tuple(made)


def _rough(recordings: Sequence[Recording]) -> bool:
    """Whether shapes may be rough: with many bodies, or with no readings that show it otherwise."""
    bodies = [sum(body.station is not None for body in r.bodies) for r in recordings]
    return max(bodies, default=0) >= _MANY or all(r.counts is None for r in recordings)


def _directed(recordings: Sequence[Recording]) -> bool:
    """Whether bodies beyond the base show which way the joint points."""
    return any(
        body.orientation is not None and body.station for r in recordings for body in r.bodies
    )


def _part(
    geometry: Geometry,
    recording: Recording,
    model: Model,
    sensors: RecordedSensors,
    others: Sequence[Part] = (),
) -> Part:
    """Lay a recording's bodies and readings beside each other, with shapes by the bodies alone.

    Args:
        others: recordings to fit to, from which one to score with takes what is fixed to bodies.
    """
    sights, frame, spread = sighted(recording, geometry)
    allowed = learned_rows(recording, None)
    seen, independent = _telling(sights, allowed)
    share = independent / max(len(seen), 1)
    alike = [o for o in others if o.sights.names == sights.names and not o.spread.certain]
    if alike and not spread.certain:
        frame = mean_frame([other.frame for other in alike])
        sights = alike[0].sights.noise_of(sights)
    else:
        some = sights.rows(seen[:: max(1, len(seen) // _FRAME_ROWS)])
        if sights.oriented and not spread.certain:
            blind = replace(some, rotation=np.full_like(some.rotation, np.nan))
            states = _by_bodies(blind, frame, model, nothing_learned(model))
            frame = mounted(some, frame, states)
        some, frame = refined(some, frame, spread, usual(model), share, noisy=unstated(recording))
        sights = some.noise_of(sights)
    state = _by_bodies(sights, frame, model, nothing_learned(model))
    read = _read(recording, sights, state, sensors, allowed)
    return Part(recording, sights, frame, spread, seen, independent, state, read)


def _part_anew(
    whole: Reference, recording: Recording, sensors: RecordedSensors, without_block: int | None
) -> Part:
    """The same of a reference that was found, to learn of its sensors and shapes from fewer rows.

    Frame, noise of bodies and shapes by bodies alone stay those of the whole recording.
    """
    known = whole.sighting
    assert known is not None
    allowed = learned_rows(recording, without_block)
    seen, independent = _telling(known.sights, allowed)
    read = _read(recording, known.sights, known.alone, sensors, allowed, whole.delay_s)
    spread = no_spread(len(known.sights.names))
    return Part(recording, known.sights, known.frame, spread, seen, independent, known.alone, read)


def _telling(sights: Sights, allowed: NDArray[np.bool_]) -> tuple[NDArray[np.intp], float]:
    """Rows with bodies in sight, from which may be learned, and as how many those count."""
    seen = np.flatnonzero(allowed & sights.seen)
    signals = sights.position[seen].reshape(len(seen), -1)
    known = signals[:, ~np.isnan(signals).all(axis=0)]
    return seen, independent_rows(known) if known.size else 1.0


def _read(
    recording: Recording,
    sights: Sights,
    state: Floats,
    sensors: RecordedSensors,
    allowed: NDArray[np.bool_],
    near: float | None = None,
) -> Read | None:
    """What sensors read beside shapes by the bodies alone; None without counts."""
    if recording.counts is None:
        return None
    expected = expected_changes(state[:, :-1], sensors.matrix)
    expected[~sights.seen] = np.nan
    return read_lengths(recording, sensors, expected, allowed, near)


def _by_bodies(sights: Sights, frame: Frame, model: Model, at: Parameters) -> Floats:
    """Most probable states by the bodies alone, twist included, shape (N, p)."""
    moved = sights.moved
    sights = sights.rows(np.flatnonzero(moved))
    none = np.zeros(0)
    at = replace(at, gain=none, zero=np.zeros((1, 0)))
    N, p = len(sights), len(model.basis)
    state = np.zeros((N, p))
    for rows in _pieces(N):
        some, own = sights.rows(rows), state[rows]
        nothing = Lengths(
            np.zeros((len(some), 0)), np.zeros((0, p)), np.zeros(len(some), dtype=np.intp),
            none, none, np.zeros((1, 0)), np.zeros((1, 0)), none,
        )  # fmt: skip
        for nearness, turns in _APPROACH:
            sight = partial(evidence, replace(some, nearness=nearness), frame)
            own = states(sight, model, nothing, at, own, turns)
        state[rows] = own
    return np.asarray(state[np.cumsum(moved) - 1])


def _pieces(rows: int) -> list[slice]:
    """Some rows at a time: their matrices take much room."""
    return [slice(i, i + _ROWS) for i in range(0, rows, _ROWS)]


def _borrowed(
    part: Part, shared: Shared, common: Calibration | None, sensors: RecordedSensors
) -> Sensed | None:
    """What is known of the sensors in a recording to score with."""
    if part.read is None:
        return None
    told = shared.calibration or common
    gain = np.ones(len(sensors.names)) if told is None else told.gain
    state = _by_bodies(part.sights, part.frame, shared.model, shared.found)
    change = expected_changes(state[:, :-1], sensors.matrix)
    own = stretch_zero(part.recording, change, part.read.lengths, gain)
    return borrowed(told, own, sensors)


def _reference(
    part: Part,
    shared: Shared,
    sensed: Sensed | None,
    sensors: RecordedSensors,
    cut: Fine,
    group: int | None = None,
) -> Reference:
    """A part's reference; `group` is its number among those that were learned from."""
    recording, read = part.recording, part.read
    known = None if read is None else sensed
    posterior = _posterior(part, shared, known, sensors, group)
    return Reference(
        name=f"recording:{recording.file.file}",
        use=recording.file.use,
        t=recording.t,
        dense=False,
        state=posterior.state[:, :-1] @ cut.gather.T,
        covariance=cut.gather @ posterior.with_doubt(_WITHIN)[:, :-1, :-1] @ cut.gather.T,
        second_moment=cut.gather @ shared.second_moment[:-1, :-1] @ cut.gather.T,
        notes=recording.notes + _said(part, posterior),
        compliance=shared.compliance if recording.file.use == "fit" else None,
        sighting=Sighting(
            part.sights,
            part.frame,
            part.state,
            posterior.state,
            posterior.with_doubt(_BETWEEN),
            cut.coarse,
        ),
        learned=shared.learned,
    ).with_readings(read, known)


def _anew(
    whole: Reference,
    part: Part,
    shared: Shared,
    sensed: Sensed | None,
    sensors: RecordedSensors,
    cut: Fine,
    allowed: NDArray[np.bool_],
) -> Reference:
    """A reference found again without some rows: what weights are fitted to, and no more."""
    read = part.read
    known = None if read is None else sensed
    assert whole.sighting is not None
    begin = whole.sighting.state
    state = np.full(whole.state.shape, np.nan)
    chosen = np.flatnonzero(allowed)
    for some in _pieces(len(chosen)):
        rows = chosen[some]
        sight, seen, at = _seen(part, shared, known, sensors, rows)
        found = states(sight, shared.model, seen, at, begin[rows], _TURNS_ANEW)
        state[rows] = found[:, :-1] @ cut.gather.T
    return replace(
        whole,
        state=state,
        covariance=None,
        second_moment=cut.gather @ shared.second_moment[:-1, :-1] @ cut.gather.T,
        notes=(),
        compliance=shared.compliance,
        sighting=None,
        learned=shared.learned,
    ).with_readings(read, known)


def _posterior(
    part: Part,
    shared: Shared,
    sensed: Sensed | None,
    sensors: RecordedSensors,
    group: int | None,
) -> Posterior:
    """Shapes of all rows, by bodies and readings."""
    zero_std = np.zeros(len(sensors.names)) if sensed is None else sensed.zero_std
    doubt = shared.doubt_of(group, zero_std)
    found = []
    for rows in _pieces(len(part.sights)):
        sight, seen, at = _seen(part, shared, sensed, sensors, rows)
        found.append(shapes(sight, shared.model, seen, at, part.state[rows], _TURNS, doubt))
    doubts = [some.doubt for some in found if some.doubt is not None]
    return Posterior(
        np.concatenate([some.state for some in found]),
        np.concatenate([some.covariance for some in found]),
        np.concatenate(doubts) if doubts else None,
    )


def _seen(
    part: Part,
    shared: Shared,
    sensed: Sensed | None,
    sensors: RecordedSensors,
    rows: "slice | NDArray[np.intp]",
) -> tuple[Callable[[Floats], Evidence], Lengths, Parameters]:
    """What bodies and readings say of some rows, and what was learned of all of them."""
    n = len(sensors.names)
    if sensed is None:
        none = np.zeros(n)
        sensed = Sensed(none, none, none, none, np.ones(n))
    usable = np.isfinite(sensed.noise)
    lengths = np.where(usable, part.lengths(n)[rows], np.nan)
    seen = Lengths(
        length=lengths,
        matrix=with_twist(sensors.matrix),
        group=np.zeros(len(lengths), dtype=np.intp),
        gain=sensed.gain,
        gain_std=sensed.gain_std,
        zero=sensed.zero[None],
        zero_std=sensed.zero_std[None],
        noise=np.where(usable, sensed.noise, 1.0),
    )
    at = replace(shared.found, gain=sensed.gain, zero=sensed.zero[None])
    return partial(evidence, part.sights.rows(rows), part.frame), seen, at


def _said(part: Part, posterior: Posterior) -> tuple[str, ...]:
    """What a reader of results should know of the rows, a line each."""
    source = part.recording.source
    notes = list(outliers(part.sights, part.frame, posterior.state, source))
    return (*notes, *(part.read.notes(source) if part.read is not None else ()))
