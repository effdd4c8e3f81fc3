"""What bodies and markers say of a joint's state: residuals, derivatives, and evidence from them.

A body at a station lies where the chain of segments puts the station, moved by an offset; a frame
leads from where it was recorded to the joint's base. Of an orientation counts the direction of the
joint alone: about that axis trackers often take a body's markers for each other.
Positions and orientations far off count less, by the weights of Student's distribution.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.kinematics.rotations import skew
from ccgen.kinematics.stations import Places, Seen, seen_from_base
from ccgen.recordings.likelihood import Evidence

Floats = NDArray[np.float64]

_FREEDOM = 4.0
"""Degrees of freedom of Student's distribution: outliers of more than two deviations count less."""
_OUTLIER = 0.25
"""Weight below which a body counts as an outlier in a row."""
_MEDIAN = 2.366
"""Of the sum of three squared standard normal numbers."""
_STEP = 0.1
"""Of residuals of shapes that are hardly known: what a step is expected to leave of them."""
_SMALL = 1e-12
_ROWS = 1000
"""Rows that are linearised at a time."""


FAR, CLOSER, NEAR = range(3)


@dataclass(frozen=True, eq=False)
class Sights:
    """B bodies at their stations in N rows, near the base frame.

    Attributes:
        names: of the bodies.
        at: stations, shape (B,), metres along the joint without elongation.
        start: of what bends, metres along the joint.
        where: the stations as places on the chain, which begins there.
        position: shape (N, B, 3), metres; NaN where a body was not seen.
        rotation: shape (N, B, 3, 3); NaN where unknown.
        position_noise: one standard deviation of a coordinate from the chain, metres.
        orientation_noise: one standard deviation of a direction about an axis, radians.
        stated_noise: both as stated, or as rows jump about: without what a chain misses.
        least_noise: both, no less than which they are found to be: with what a chain misses.
        axes: of the base as first seen, in the recording's frame, shape (N, 3, 3).
        origin: of the base as first seen, in the recording's frame, shape (N, 3), metres.
        nearness: how well shapes are known: hardly (`FAR`), so that what most bodies of a row are
            off by is no outlier (`CLOSER`), or so that the noise says what is one (`NEAR`).
    """

    names: tuple[str, ...]
    at: Floats
    start: float
    where: Places
    position: Floats
    rotation: Floats
    position_noise: float
    orientation_noise: float
    stated_noise: tuple[float, float]
    least_noise: tuple[float, float]
    axes: Floats
    origin: Floats
    nearness: int = NEAR

    @property
    def oriented(self) -> bool:
        """Whether any orientation is known."""
        return not bool(np.isnan(self.rotation).all())

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which rows any body was seen in, shape (N,)."""
        return np.asarray(~np.isnan(self.position.sum(axis=2)).all(axis=1))

    @property
    def moved(self) -> NDArray[np.bool_]:
        """Which rows are not those before again, as of a camera slower than the log; (N,)."""
        rows = np.concatenate(
            [self.position, self.rotation.reshape(*self.position.shape[:2], 9)], 2
        )
        again = (rows[1:] == rows[:-1]) | (np.isnan(rows[1:]) & np.isnan(rows[:-1]))
        return np.concatenate([[True], ~again.all(axis=(1, 2))])

    def rows(self, chosen: "slice | NDArray[np.intp]") -> "Sights":
        """Some rows of it."""
        names = ("position", "rotation", "axes", "origin")
        return replace(self, **{name: getattr(self, name)[chosen] for name in names})

    def noise_of(self, others: "Sights") -> "Sights":
        """Other rows with the noise of these."""
        return replace(
            others,
            position_noise=self.position_noise,
            orientation_noise=self.orientation_noise,
        )

    def __len__(self) -> int:
        return len(self.position)


@dataclass(frozen=True, eq=False)
class Frame:
    """What is constant between bodies and a joint of B stations.

    Attributes:
        rotation: axes of the joint's base in the frame of `Sights`, shape (3, 3).
        origin: of the joint's base there, shape (3,), metres.
        offset: of each body from its station, in the station's frame, shape (B, 3), metres.
        tangent: the joint's direction at its station in each body's own frame, shape (B, 3).
    """

    rotation: Floats
    origin: Floats
    offset: Floats
    tangent: Floats


@dataclass(frozen=True, eq=False)
class Linear:
    """Residuals of N rows about some states: positions of B bodies, then directions where known.

    Attributes:
        residual: seen less expected, 0 where not seen, shape (N, Q, 3), metres and radians, for
            Q = B, or 2B where any direction is known.
        by_state: derivative of what is expected, shape (N, Q, 3, p).
        weight: by which squares count, shape (N, Q); 0 where not seen.
        trust: that weight over the one of a body that is no outlier, shape (N, Q).
        seen: the chain's poses.
        place: of the bodies in the base frame as seen, shape (N, B, 3).
    """

    residual: Floats
    by_state: Floats
    weight: Floats
    trust: Floats
    seen: Seen
    place: Floats


def linearised(sights: Sights, frame: Frame, states: Floats) -> Linear:
    """Residuals about states of shape (N, p), u, v, h and twist."""
    seen = seen_from_base(states, sights.where)
    place = (sights.position - frame.origin) @ frame.rotation
    offset = (seen.rotation @ frame.offset[..., None])[..., 0]
    residual = place - seen.position - offset
    by_state = seen.linear - skew(offset) @ seen.angular
    freedom = np.full(len(sights.at), 3.0)
    if sights.oriented:
        expected = seen.rotation[..., 2]
        turned = _shortest(expected, tangents(sights, frame))
        across = np.eye(3) - expected[..., :, None] * expected[..., None, :]
        residual = np.concatenate([residual, turned], axis=1)
        by_state = np.concatenate([by_state, across @ seen.angular], axis=1)
        freedom = np.concatenate([freedom, freedom - 1.0])
    missing = np.asarray(np.isnan(residual).any(axis=2))
    residual = np.where(missing[..., None], 0.0, residual)
    noise = np.repeat([sights.position_noise, sights.orientation_noise], len(sights.at))
    square = np.square(residual).sum(axis=2)
    least = np.broadcast_to(np.square(noise[: len(freedom)]), square.shape)
    scale = least
    if sights.nearness != NEAR:
        scale = _row_scale(square, missing, least, len(sights.at), sights.nearness)
    trust = ~missing * (_FREEDOM + freedom) / (_FREEDOM + square / scale)
    left = np.maximum(least, scale * _STEP**2)
    return Linear(residual, by_state, trust / left, trust, seen, place)


def tangents(sights: Sights, frame: Frame) -> Floats:
    """Directions of the joint at its stations as seen, in the base frame, shape (N, B, 3)."""
    own = (sights.rotation @ frame.tangent[..., None])[..., 0]
    return np.asarray(own @ frame.rotation)


def _shortest(start: Floats, end: Floats) -> Floats:
    """Rotation vectors (..., 3) that take unit vectors to others the shortest way."""
    axis = np.cross(start, end)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.arctan2(sine, (start * end).sum(axis=-1, keepdims=True))
    return np.asarray(np.where(sine > _SMALL, axis * angle / np.maximum(sine, _SMALL), axis))


def evidence(sights: Sights, frame: Frame, states: Floats) -> Evidence:
    """What bodies say of states, linearised about them; some rows at a time."""
    parts = [
        _evidence(sights.rows(slice(i, i + _ROWS)), frame, states[i : i + _ROWS])
        for i in range(0, len(states), _ROWS)
    ]
    return Evidence(
        np.concatenate([part.information for part in parts]),
        np.concatenate([part.potential for part in parts]),
    )


def _row_scale(
    square: Floats, missing: NDArray[np.bool_], least: Floats, B: int, nearness: int
) -> Floats:
    """Variance of a coordinate in each row by all of its bodies, no less than the noise's; (N, Q).

    By the mean of their squares, or by the median, which some that are far off do not move.
    """
    known = np.where(missing, np.nan, square)
    scale = np.empty_like(square)
    for kind in (slice(0, B), slice(B, None)):
        if scale[:, kind].size:
            blank = missing[:, kind].all(axis=1)
            known[blank, kind] = 0.0
            if nearness == FAR:
                usual = np.nanmean(known[:, kind], axis=1) / 3.0
            else:
                usual = np.nanmedian(known[:, kind], axis=1) / _MEDIAN
            scale[:, kind] = usual[:, None]
    return np.asarray(np.maximum(scale, least))


def outliers(sights: Sights, frame: Frame, states: Floats, source: str) -> tuple[str, ...]:
    """What is to be said of bodies that were out of sight or far off, a line a body."""
    B = len(sights.names)
    trust = np.concatenate(
        [
            linearised(sights.rows(slice(i, i + _ROWS)), frame, states[i : i + _ROWS]).trust[:, :B]
            for i in range(0, len(states), _ROWS)
        ]
    )
    said = []
    for name, own in zip(sights.names, trust.T, strict=True):
        hidden, far = int((own == 0).sum()), int(((own > 0) & (own < _OUTLIER)).sum())
        if hidden:
            said.append(f"{source}: {name} is out of sight in {hidden} of {len(own)} rows")
        if far:
            said.append(f"{source}: {name} is far off and counts little in {far} rows")
    return tuple(said)


def _evidence(sights: Sights, frame: Frame, states: Floats) -> Evidence:
    at = linearised(sights, frame, states)
    N, p = states.shape
    J = at.by_state.reshape(N, -1, p)
    weighed = J * np.repeat(at.weight, 3, axis=1)[..., None]
    target = at.residual.reshape(N, -1) + (J @ states[..., None])[..., 0]
    potential = (target[:, None, :] @ weighed)[:, 0]
    return Evidence(np.swapaxes(weighed, 1, 2) @ J, potential)
