"""Errors of estimates at the stations of bodies: what a recording without dense angles can tell.

Positions are held against the bodies themselves, bends against orientations where those are known;
noise of the reference is taken off in quadrature. Where no orientation is known, bends and lengths
are held against the most probable shapes. What those leave open is independent of every estimate
from the same readings, so its variance is added.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.joint.specification import Geometry
from ccgen.kinematics.rotations import logarithm, without_twist
from ccgen.kinematics.stations import Places, places, seen_from_base
from ccgen.recordings.sights import Frame, Sights, tangents

Floats = NDArray[np.float64]

_ROWS = 1000
"""Whose places are found at once."""
_OUTLIER = 10.0
"""Standard deviations: bodies farther from the most probable shape are errors of the reference."""


@dataclass(frozen=True)
class StationErrors:
    """Root mean squares over a recording's rows at one station; NaN where nothing is known.

    Attributes:
        position_rms_m: distance from where the body was seen.
        bend_rms_deg: by axis "u" and "v", bend from the station before, or from the base, about
            the axes of the joint as its sensors have them.
        arc_length_rms_m: length of the joint from its base to the station.
    """

    position_rms_m: float
    bend_rms_deg: Mapping[str, float]
    arc_length_rms_m: float


@dataclass(frozen=True, eq=False)
class Sighting:
    """Bodies in the joint's frame with the most probable shapes: all that errors at stations need.

    Attributes:
        sights: the bodies.
        frame: from where they were recorded to the joint.
        alone: most probable states by the bodies alone, twist included, shape (N, p).
        state: most probable with all that is known, shape (N, p).
        covariance: of that, as it counts for bends between stations, shape (N, p, p).
        geometry: of the joint as estimates know it; `state` may be of finer segments.
    """

    sights: Sights
    frame: Frame
    alone: Floats
    state: Floats
    covariance: Floats
    geometry: Geometry

    def positions(self, at: ArrayLike) -> Floats:
        """Where places along the joint most probably were, in the recording's frame.

        Args:
            at: shape (K,), metres from the base along the joint without elongation.

        Returns:
            Shape (N, K, 3), metres; NaN where the base is unknown.
        """
        where, own = self.sights.where, self.frame
        beyond = np.asarray(at, dtype=np.float64) - self.sights.start
        place = seen_from_base(self.state, places(beyond, where.sections, where.length)).position
        place[..., 2] += np.minimum(beyond, 0.0)
        near = place @ own.rotation.T + own.origin
        base = self.sights.origin[:, None]
        return np.asarray(near @ np.swapaxes(self.sights.axes, -1, -2) + base)

    @cached_property
    def tips(self) -> tuple[Floats, Floats]:
        """Where the tip was in the joint's frame, twist included, and how surely.

        Returns:
            Places, shape (N, 3), and standard deviations of the distance from them, shape (N,),
            metres.
        """
        start, where = self.sights.start, self.sights.where
        end = places([where.length * sum(where.sections)], where.sections, where.length)
        place, variance = [], []
        for i in range(0, len(self.state), _ROWS):
            seen = seen_from_base(self.state[i : i + _ROWS], end)
            J, P = seen.linear[:, 0], self.covariance[i : i + _ROWS]
            place.append(seen.position[:, 0] + [0.0, 0.0, start])
            variance.append(np.einsum("nca,nab,ncb->n", J, P, J, optimize=True))
        return np.concatenate(place), np.sqrt(np.concatenate(variance))

    def errors(self, estimate: Floats) -> dict[str, StationErrors]:
        """Errors of an estimate at each station, by the body's name.

        Args:
            estimate: shape (N, 2m + S), radians and shares; rows with a NaN are left out.
        """
        rows = np.flatnonzero(~np.isnan(estimate).any(axis=1))
        order = np.argsort(self.sights.at, kind="stable")
        if not len(rows):
            nothing = StationErrors(np.nan, {"u": np.nan, "v": np.nan}, np.nan)
            return {self.sights.names[b]: nothing for b in order}
        states = np.concatenate([estimate[rows], np.zeros((len(rows), 1))], axis=1)
        geometry = self.geometry
        where = places(self.sights.at, geometry.sections, geometry.segment_length)
        # Estimates bend from the joint's base on, wherever a chord tells the base's direction.
        whole = replace(
            self.frame, origin=self.frame.origin - self.sights.start * self.frame.rotation[:, 2]
        )
        told = _Poses.of(states, where, whole)
        best = _Poses.of(self.state[rows], self.sights.where, self.frame)
        return {
            self.sights.names[b]: StationErrors(
                self._position(b, rows, told.place[:, b], best.place[:, b]),
                self._bend(b, order[i - 1] if i else None, rows, states, where, told, best),
                self._length(b, rows, states, where),
            )
            for i, b in enumerate(order)
        }

    def _position(self, b: int, rows: NDArray[np.intp], told: Floats, best: Floats) -> float:
        noise, own = self.sights.position_noise, self.sights.stated_noise[0]
        seen = self.sights.position[rows, b]
        sound = np.linalg.norm(seen - best, axis=1) < _OUTLIER * noise
        off = np.square(seen - told).sum(axis=1)[sound]
        return _root(off, -3 * own**2)

    def _bend(
        self,
        b: int,
        before: "int | None",
        rows: NDArray[np.intp],
        states: Floats,
        where: Places,
        told: "_Poses",
        best: "_Poses",
    ) -> dict[str, float]:
        noise = self.sights.stated_noise[1]
        seen = tangents(self.sights.rows(rows), self.frame)
        known = _between(best.rotation, seen, b, before)
        if not np.isnan(known).all():
            own = _between(told.rotation, told.rotation[..., 2], b, before)
            extra = np.full(2, -(noise**2) * (1 if before is None else 2))
        else:
            along = _bends(self.sights.where, b, before, self.state.shape[1])
            own = states @ _bends(where, b, before, states.shape[1])
            known = self.state[rows] @ along
            left = np.einsum("pa,npq,qa->a", along, self.covariance[rows], along, optimize=True)
            extra = left / len(rows)
        square = np.square(own - known)
        return {
            axis: float(np.degrees(_root(square[:, k], float(extra[k]))))
            for k, axis in enumerate("uv")
        }

    def _length(self, b: int, rows: NDArray[np.intp], states: Floats, where: Places) -> float:
        own = _along(self.sights.where, b, self.state.shape[1])
        off = np.square(states @ _along(where, b, states.shape[1]) - self.state[rows] @ own)
        left = np.einsum("p,npq,q->", own, self.covariance[rows], own, optimize=True)
        return _root(off, float(left) / len(rows))


def _along(where: Places, b: int, states: int) -> Floats:
    """Change of the length from the base to a station by elongation, shape (p,), metres."""
    m, sections = sum(where.sections), len(where.sections)
    section = np.repeat(np.arange(sections), where.sections)[where.segment[: where.end[b]]]
    along = np.zeros(states)
    np.add.at(along, 2 * m + section, where.length * where.share[: where.end[b]])
    return along


def _bends(where: Places, b: int, before: "int | None", states: int) -> Floats:
    """What sums a state's u and v from one station, or the base, to another, shape (p, 2)."""
    m = sum(where.sections)
    pieces = slice(0 if before is None else where.end[before], where.end[b])
    along = np.zeros((states, 2))
    for axis in (0, 1):
        np.add.at(along[:, axis], axis * m + where.segment[pieces], where.share[pieces])
    return along


@dataclass(frozen=True, eq=False)
class _Poses:
    """Where bodies are and how stations lie for N states."""

    place: Floats  # (N, B, 3), near the base frame
    rotation: Floats  # (N, B, 3, 3), in the joint's

    @classmethod
    def of(cls, states: Floats, where: Places, frame: Frame) -> "_Poses":
        seen = seen_from_base(states, where)
        offset = (seen.rotation @ frame.offset[..., None])[..., 0]
        place = (seen.position + offset) @ frame.rotation.T + frame.origin
        return cls(place, seen.rotation)


def _between(rotation: Floats, tangent: Floats, b: int, before: "int | None") -> Floats:
    """Bends u and v from one station, or the base, to another, shape (N, 2); NaN where unknown.

    About the axes of the joint where it begins, which its twist turns as it turns its sensors.

    Args:
        rotation: of the joint at its stations, shape (N, B, 3, 3).
        tangent: its directions there, as seen, shape (N, B, 3).
        b: number of the station.
        before: that of the one before it.
    """
    axis = np.array([0.0, 0.0, 1.0])
    found = np.full((len(tangent), 2), np.nan)
    there = ~np.isnan(tangent[:, b] + (0.0 if before is None else tangent[:, before])).any(axis=1)
    end = tangent[there, b]
    if before is not None:
        own = rotation[there, before]
        turned = without_twist(own[..., 2], tangent[there, before]) @ own
        end = (np.swapaxes(turned, -1, -2) @ end[..., None])[..., 0]
    found[there] = logarithm(without_twist(axis, end))[:, :2]
    return found


def _root(squares: Floats, extra: float) -> float:
    """Root of the mean of squares and something more; NaN where there is none."""
    known = squares[~np.isnan(squares)]
    return float(np.sqrt(max(float(known.mean()) + extra, 0.0))) if len(known) else float("nan")
