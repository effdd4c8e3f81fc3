"""Errors of estimates at the stations of bodies: what a recording without dense angles can tell.

Positions are held against the bodies themselves, bends against orientations where those are known;
noise of the reference is taken off in quadrature. Where no orientation is known, bends and lengths
are held against the most probable shapes. What those leave open is independent of every estimate
from the same readings, so its variance is added.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.joint.specification import Geometry
from ccgen.kinematics.rotations import logarithm, without_twist
from ccgen.kinematics.stations import Places, places, seen_from_base
from ccgen.recordings.sights import Frame, Sights, tangents

Floats = NDArray[np.float64]

_OUTLIER = 10.0
"""Standard deviations: bodies farther from the most probable shape are errors of the reference."""


@dataclass(frozen=True)
class StationErrors:
    """Root mean squares over a recording's rows at one station; NaN where nothing is known.

    Attributes:
        position_rms_m: distance from where the body was seen.
        bend_rms_deg: by axis "u" and "v", bend from the station before, or from the base.
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
                self._bend(b, order[i - 1] if i else None, rows, told, best),
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
        told: "_Poses",
        best: "_Poses",
    ) -> dict[str, float]:
        own = _between(told.tangent, b, before)
        noise = self.sights.stated_noise[1]
        known = _between(tangents(self.sights.rows(rows), self.frame), b, before)
        if not np.isnan(known).all():
            extra = np.full(2, -(noise**2) * (1 if before is None else 2))
        else:
            known = _between(best.tangent, b, before)
            extra = self._open(b, before, rows)
        square = np.square(own - known)
        return {
            axis: float(np.degrees(_root(square[:, k], float(extra[k]))))
            for k, axis in enumerate("uv")
        }

    def _open(self, b: int, before: "int | None", rows: NDArray[np.intp]) -> Floats:
        """Mean variance of the bends u and v between stations in the most probable shapes."""
        where = self.sights.where
        m = sum(where.sections)
        along = np.zeros((2, self.state.shape[1]))
        first = 0 if before is None else where.end[before]
        pieces = slice(first, where.end[b])
        for axis in (0, 1):
            np.add.at(along[axis], axis * m + where.segment[pieces], where.share[pieces])
        left = np.einsum("ap,npq,aq->a", along, self.covariance[rows], along, optimize=True)
        return np.asarray(left / len(rows))

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


@dataclass(frozen=True, eq=False)
class _Poses:
    """Where bodies are and how stations lie for N states."""

    place: Floats  # (N, B, 3), near the base frame
    tangent: Floats  # (N, B, 3), in the joint's

    @classmethod
    def of(cls, states: Floats, where: Places, frame: Frame) -> "_Poses":
        seen = seen_from_base(states, where)
        offset = (seen.rotation @ frame.offset[..., None])[..., 0]
        place = (seen.position + offset) @ frame.rotation.T + frame.origin
        return cls(place, seen.rotation[..., 2])


def _between(tangent: Floats, b: int, before: "int | None") -> Floats:
    """Bends u and v from one station, or the base, to another, shape (N, 2); NaN where unknown.

    The shortest rotation from one direction of the joint to the other, in a frame without twist.
    """
    axis = np.array([0.0, 0.0, 1.0])
    start = axis if before is None else tangent[:, before]
    there = ~np.isnan(tangent[:, b] + start).any(axis=1)
    found = np.full((len(tangent), 2), np.nan)
    end = tangent[there, b]
    if before is not None:
        end = (np.swapaxes(without_twist(axis, start[there]), -1, -2) @ end[..., None])[..., 0]
    found[there] = logarithm(without_twist(axis, end))[:, :2]
    return found


def _root(squares: Floats, extra: float) -> float:
    """Root of the mean of squares and something more; NaN where there is none."""
    known = squares[~np.isnan(squares)]
    return float(np.sqrt(max(float(known.mean()) + extra, 0.0))) if len(known) else float("nan")
