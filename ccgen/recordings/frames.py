"""From where bodies were recorded to the joint's base: axes, origin, and what is fixed to a body.

The base is the first chord between two markers, or the body `base`, or the recording's own frame.
A chord has the joint's direction at its middle. Where that lies within the joint, the joint counts
as straight up to there, and its segments share what is left of its length.
Of the body's axes, of either sign, the joint's z is the one nearest to the mean direction to the
other stations; x is the body's x. While the joint is straight all stations lie on one line: that
fixes the axes, and every body's offset from its station. Without such a stretch all of this is near
where it should be, and the whole recording tells how near (`ccgen.recordings.refined`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.joint.specification import Geometry
from ccgen.kinematics.rotations import mean_rotation, without_twist
from ccgen.kinematics.stations import places, seen_from_base
from ccgen.recordings.movement import check_rest
from ccgen.recordings.recording import BASE, Body, Recording
from ccgen.recordings.sights import Frame, Sights

Floats = NDArray[np.float64]

_FREE = 1.0
"""Standard deviation, radians, of a rotation of which nothing is known."""
_MOUNTED = 0.02
"""Of the tilt of a body on its station, radians, unless a straight stretch tells it."""
_TURNED = 0.3
"""Of the base's rotation about its axis, radians, where sensors tell which way they lie."""
_ORIGIN = 0.1
"""Of the base's origin, share of the length, where no body shows it."""
_CENTRE = 0.01
"""Of a body's centre from its station, share of the length, where orientations tell of it."""
_WITHIN = 0.05
"""Of the range of motion: curvature that is not constant within a segment."""
_UNSETTLED = 2e-3
"""Share of the length by which bodies are off, at least, where their noise is not stated and no
straight stretch shows how they are mounted."""
_JITTER = 1e-3
"""Share of the length: bodies that jump about by more move, or show it by what a chain misses."""
_RESTING = np.radians(0.5)
"""Orientations of the base that differ by less are one."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Standard deviations of a frame's parts about where they were found, 0 for what is certain.

    Attributes:
        rotation: about x, y, z of the base, shape (3,), radians.
        origin: shape (3,), metres.
        offset: shape (B, 3), metres.
        tangent: about the axes of each body, shape (B, 3), radians.
    """

    rotation: Floats
    origin: Floats
    offset: Floats
    tangent: Floats
    about_axis: Floats
    """Like `rotation`, where readings tell which way the sensors lie."""

    @property
    def certain(self) -> bool:
        """Whether nothing of the frame is left to be found."""
        parts = (self.rotation, self.origin, self.offset, self.tangent)
        return not any(part.any() for part in parts)


def no_spread(bodies: int) -> Spread:
    """The spread of a frame that was found before."""
    none, each = np.zeros(3), np.zeros((bodies, 3))
    return Spread(none, none, each, each, none)


@dataclass(frozen=True, eq=False)
class _Base:
    """Axes (1 or N, 3, 3) and origin (1 or N, 3) of the joint's base as first seen."""

    axes: Floats
    origin: Floats
    kind: str  # "chord", "body" or "recording"
    start: float = 0.0
    """Of what bends, metres along the joint."""


def sighted(recording: Recording, geometry: Geometry) -> tuple[Sights, Frame, Spread]:
    """Bodies of a recording near the joint's base frame, and what is left to be found of it.

    Args:
        recording: with bodies at stations.
        geometry: of the joint.

    Raises:
        InputError: no body beyond the base; a straight stretch in which bodies move.
    """
    base = _base(recording, geometry)
    bending = replace(geometry, length=geometry.length - base.start)
    bodies = [
        b
        for b in recording.bodies
        if b.station is not None and b.station >= base.start and not _is_base(b, base)
    ]
    if not bodies:
        raise InputError(
            f"{recording.source}: [[recordings]] names no station beyond the base; write those of "
            "other bodies, such as stations = { tip = ... }"
        )
    at = np.array([b.station for b in bodies], dtype=np.float64)
    position = np.stack([b.position for b in bodies], axis=1)
    rotation = np.stack([_orientation(b) for b in bodies], axis=1)
    position = np.einsum(
        "nbi,nij->nbj", position - base.origin[:, None], _rows(base.axes, position)
    )
    rotation = np.swapaxes(base.axes, -1, -2)[:, None] @ rotation
    file = recording.file
    own = file.position_noise or min(jitter(position), _JITTER * geometry.length)
    missed = _model_error(geometry)
    least = (
        float(np.hypot(own, missed * geometry.segment_length)),
        float(np.hypot(file.orientation_noise or 0.0, missed)),
    )
    sights = Sights(
        names=tuple(b.name for b in bodies),
        at=at,
        start=base.start,
        where=places(at - base.start, bending.sections, bending.segment_length),
        position=position,
        rotation=rotation,
        position_noise=least[0],
        orientation_noise=least[1],
        stated_noise=(own, file.orientation_noise or 0.0),
        least_noise=least,
        axes=np.array(_rows(base.axes, position)),
        origin=np.broadcast_to(base.origin, (len(position), 3)).copy(),
    )
    if file.straight is None:
        spread = _unsettled(sights, base.kind, geometry.length)
        if not spread.certain and file.position_noise is None:
            rough = max(least[0], _UNSETTLED * geometry.length)
            sights = replace(sights, position_noise=rough, least_noise=(rough, least[1]))
        return sights, _guessed(sights, base.start), spread
    rows = recording.within(file.straight)
    check_rest(
        recording.source, file.straight, np.zeros((2, 1)), list(_moved(sights, rows)), geometry
    )
    frame = _straightened(sights, rows, base.kind)
    none = np.zeros((len(at), 3))
    return sights, frame, Spread(np.zeros(3), np.zeros(3), none, none, np.zeros(3))


def jitter(position: Floats) -> float:
    """Noise of positions by how they jump from row to row, metres; shape (N, B, 3)."""
    jumps = np.diff(position, n=2, axis=0)
    jumps = jumps[~np.isnan(jumps)]
    return 1.4826 * float(np.median(np.abs(jumps))) / np.sqrt(6.0) if len(jumps) else 0.0


def _model_error(geometry: Geometry) -> float:
    """By what angle a segment may miss what bends within it, radians."""
    return _WITHIN * geometry.range_of_motion


def _rows(axes: Floats, position: Floats) -> Floats:
    return np.broadcast_to(axes, (len(position), 3, 3))


def _moved(sights: Sights, rows: NDArray[np.bool_]) -> list[Floats]:
    return [sights.position[rows, b] for b in range(len(sights.at))]


def _orientation(body: Body) -> Floats:
    if body.orientation is None:
        return np.full((len(body.position), 3, 3), np.nan)
    return body.orientation


def _is_base(body: Body, base: _Base) -> bool:
    return base.kind == "body" and body.name == BASE


def _base(recording: Recording, geometry: Geometry) -> _Base:
    """The base as first seen."""
    placed = [b for b in recording.bodies if b.station is not None]
    if recording.file.base is not None:
        return _chord(recording)
    body = next((b for b in placed if b.name == BASE and b.orientation is not None), None)
    if body is not None:
        return _body(body, [b for b in placed if b is not body])
    first, last = placed[0].position, placed[-1].position
    way = _mean(last - first) if len(placed) > 1 else _mean(first)
    axes = _nearest_axes(way)
    along = np.stack([_mean(b.position) @ axes - [0.0, 0.0, b.station or 0.0] for b in placed])
    start = along[0] if placed[0].station == 0 else along.mean(axis=0)
    return _Base(axes[None], (axes @ start)[None], "recording")


def _chord(recording: Recording) -> _Base:
    """The chord between two markers is z in every row; x is the recording's, not twisted."""
    assert recording.file.base is not None
    ends = [next(b for b in recording.bodies if b.name == name) for name in recording.file.base]
    chord = ends[1].position - ends[0].position
    with np.errstate(invalid="ignore", divide="ignore"):
        way = chord / np.linalg.norm(chord, axis=1, keepdims=True)
    axes = _nearest_axes(_mean(way))
    turned = np.full((len(way), 3, 3), np.nan)
    there = np.isfinite(way).all(axis=1)
    turned[there] = without_twist(axes[:, 2], way[there]) @ axes
    end = next((b for b in ends if b.station is not None), ends[1])
    at = end.station or 0.0
    length = float(np.nanmedian(np.linalg.norm(chord, axis=1)))
    middle = at + length / 2 if end is ends[0] else at - length / 2
    return _Base(turned, end.position - at * turned[:, :, 2], "chord", max(middle, 0.0))


def _body(body: Body, others: list[Body]) -> _Base:
    """The axes of a body are those of the base; one orientation for all rows if it rests."""
    assert body.orientation is not None
    axes, origin = body.orientation, body.position
    mean = mean_rotation(axes)
    away = np.arccos(np.clip((np.einsum("nij,ij->n", axes, mean) - 1) / 2, -1.0, 1.0))
    if np.nanpercentile(away, 95) < _RESTING:
        axes, origin = mean[None], np.nanmedian(origin, axis=0)[None]
    local = [np.einsum("nij,ni->nj", _rows(axes, b.position), b.position - origin) for b in others]
    way = sum((_mean(place) for place in local), np.zeros(3))
    own = _nearest_axes(way)
    axes = axes @ own
    return _Base(axes, origin - (body.station or 0.0) * axes[:, :, 2], "body")


def _mean(positions: Floats) -> Floats:
    return np.asarray(np.nanmean(positions, axis=0))


def mean_frame(frames: Sequence[Frame]) -> Frame:
    """What several recordings of the same bodies found, each as good as the other."""
    tangent = np.mean([frame.tangent for frame in frames], axis=0)
    return Frame(
        mean_rotation(np.stack([frame.rotation for frame in frames])),
        np.mean([frame.origin for frame in frames], axis=0),
        np.mean([frame.offset for frame in frames], axis=0),
        tangent / np.linalg.norm(tangent, axis=1, keepdims=True),
    )


def _nearest_axes(way: Floats) -> Floats:
    """Axes (3, 3) whose z is the axis nearest to a direction, of either sign, and x stays x."""
    i = int(np.argmax(np.abs(way)))
    z = np.zeros(3)
    z[i] = 1.0 if way[i] >= 0 else -1.0
    x = np.eye(3)[0 if i != 0 else 1]
    return np.stack([x, np.cross(z, x), z], axis=1)


def _straightened(sights: Sights, rows: NDArray[np.bool_], kind: str) -> Frame:
    """The frame in which a joint lies on its z axis while it is straight."""
    place = np.nanmedian(sights.position[rows], axis=0)
    there = ~np.isnan(place).any(axis=1)
    at, seen = sights.at[there], place[there]
    rotation, origin = np.eye(3), np.zeros(3)
    if kind == "body" and len(at):
        rotation = _along(at @ seen)
    elif kind == "recording":
        far = at - at.mean() if len(at) > 1 else at
        if len(at) > 1 and np.ptp(at) > 0:
            rotation = _along(far @ (seen - seen.mean(axis=0)))
        origin = seen.mean(axis=0) - at.mean() * rotation[:, 2]
    origin = origin + sights.start * rotation[:, 2]
    offset = np.zeros((len(sights.at), 3))
    offset[there] = (seen - origin) @ rotation
    offset[there, 2] -= at - sights.start
    tangent = np.tile([0.0, 0.0, 1.0], (len(sights.at), 1))
    for b in range(len(tangent)):
        known = sights.rotation[rows, b]
        if not np.isnan(known).any(axis=(-2, -1)).all():
            tangent[b] = mean_rotation(known).T @ rotation[:, 2]
    return Frame(rotation, origin, offset, tangent)


def _along(way: Floats) -> Floats:
    """The rotation without twist that takes z to a direction."""
    length = float(np.linalg.norm(way))
    return without_twist(np.array([0.0, 0.0, 1.0]), way / length) if length > 0 else np.eye(3)


def _guessed(sights: Sights, start: float) -> Frame:
    """The frame as first seen, bodies on their stations and along the base's axes."""
    B, along = len(sights.at), np.array([0.0, 0.0, 1.0])
    return Frame(np.eye(3), start * along, np.zeros((B, 3)), np.tile(along, (B, 1)))


def mounted(sights: Sights, frame: Frame, states: Floats) -> Frame:
    """A frame with one axis of each body along the joint, of either sign.

    Args:
        sights: with orientations.
        frame: whose tangents are to be found.
        states: by positions alone, shape (N, p).
    """
    along = seen_from_base(states, sights.where).rotation[..., 2] @ frame.rotation.T
    own = (np.swapaxes(sights.rotation, -1, -2) @ along[..., None])[..., 0]
    tangent = np.array(frame.tangent)
    for b in range(len(tangent)):
        if not np.isnan(own[:, b]).any(axis=1).all():
            tangent[b] = _nearest_axes(_mean(own[:, b]))[:, 2]
    return replace(frame, tangent=tangent)


def _unsettled(sights: Sights, kind: str, length: float) -> Spread:
    """How far a guessed frame may be off."""
    B = len(sights.at)
    oriented = ~np.isnan(sights.rotation).any(axis=(-2, -1)).all(axis=0)
    tangent = np.outer(oriented, np.full(3, _MOUNTED))
    offset = np.outer(oriented, np.full(3, _CENTRE * length))
    rotation, origin = np.zeros(3), np.zeros(3)
    if kind == "recording":
        rotation, origin = np.array([_FREE, _FREE, 0.0]), np.full(3, _ORIGIN * length)
    elif kind == "body":
        rotation, origin = np.array([_MOUNTED, _MOUNTED, 0.0]), np.full(3, _CENTRE * length)
    assert tangent.shape == offset.shape == (B, 3)
    about = np.array([0.0, 0.0, _TURNED]) if rotation.any() else np.zeros(3)
    return Spread(rotation, origin, offset, tangent, rotation + about)
