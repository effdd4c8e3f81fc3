"""Poses at places along a joint, with their derivatives by the joint's state: what cameras follow.

A state holds u and v of all m segments, the elongation of S sections and the twist of the whole
joint about its axis, spread evenly, which no sensor reads but which tilts what lies beyond. A place
within a segment cuts it in two pieces of the same curvature.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.kinematics.rotations import skew
from ccgen.kinematics.uvh import _segment_velocities, segment_transform

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_SAME = 1e-9
"""Segments: places closer to each other are one."""


@dataclass(frozen=True, eq=False)
class Places:
    """Places along a joint, and the pieces of segments that they cut it into.

    Attributes:
        segment: of each piece, shape (K,).
        share: of its segment that a piece takes, shape (K,).
        end: number of pieces up to each of B places, shape (B,).
        sections: segments of each section.
        length: of a segment without elongation, metres.
    """

    segment: Indices
    share: Floats
    end: Indices
    sections: tuple[int, ...]
    length: float


@dataclass(frozen=True, eq=False)
class Seen:
    """Poses at B places of N states, in the base frame, and how they change with the state.

    Attributes:
        position: shape (N, B, 3), metres.
        rotation: shape (N, B, 3, 3).
        linear: derivative of the position by a state of p numbers, shape (N, B, 3, p).
        angular: rotation vector in the base frame for a unit of state, shape (N, B, 3, p).
    """

    position: Floats
    rotation: Floats
    linear: Floats
    angular: Floats


def places(at: ArrayLike, sections: Sequence[int], length: float) -> Places:
    """Cut a joint at places along its axis.

    Args:
        at: places, metres from the base along the joint without elongation.
        sections: segments of each section.
        length: of a segment without elongation, metres.
    """
    m = sum(sections)
    wanted = np.clip(np.asarray(at, dtype=np.float64) / length, 0.0, m)
    cuts = np.concatenate([np.arange(m + 1.0), wanted])
    cuts = np.unique(np.round(cuts / _SAME)) * _SAME
    middle = (cuts[1:] + cuts[:-1]) / 2
    return Places(
        segment=np.floor(middle).astype(np.intp),
        share=np.diff(cuts),
        end=np.searchsorted(cuts, wanted - 0.5 * _SAME).astype(np.intp),
        sections=tuple(sections),
        length=length,
    )


def seen_from_base(states: Floats, where: Places) -> Seen:
    """Poses at places along the joint and their derivatives.

    Args:
        states: u, v, elongation, twist; shape (N, 2m + S + 1), radians and shares of the length.
        where: the places.
    """
    count = int(where.end.max(initial=0))
    segment, share = where.segment[:count], where.share[:count]
    pieces = _pieces(states, where, segment, share)
    N, B, p = len(states), len(where.end), states.shape[1]
    place = np.zeros((N, B, 3))
    rotation = np.broadcast_to(np.eye(3), (N, B, 3, 3)).copy()
    linear, angular = np.zeros((N, B, 3, p)), np.zeros((N, B, 3, p))
    # With d = linear + angular x (place - end) of each piece, what does not depend on the place
    # is summed once.
    fixed = _Sums.of(pieces.linear + skew(pieces.position) @ pieces.angular, where, segment)
    turned = _Sums.of(pieces.angular, where, segment)
    for b, end in enumerate(where.end):
        if end == 0:
            continue
        place[:, b] = pieces.position[:, end - 1]
        rotation[:, b] = pieces.rotation[:, end - 1]
        angular[:, b] = turned.until(end)
        linear[:, b] = fixed.until(end) - skew(place[:, b]) @ angular[:, b]
    return Seen(place, rotation, linear, angular)


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Ends of K pieces in the base frame, and their velocities for unit rates of u, v, e, twist."""

    position: Floats  # (N, K, 3)
    rotation: Floats  # (N, K, 3, 3)
    linear: Floats  # (N, K, 3, 4)
    angular: Floats  # (N, K, 3, 4)


def _pieces(states: Floats, where: Places, segment: Indices, share: Floats) -> _Pieces:
    m, S = sum(where.sections), len(where.sections)
    section = np.repeat(np.arange(S), where.sections)[segment]
    u, v = states[:, segment] * share, states[:, m + segment] * share
    h = where.length * share * (1 + states[:, 2 * m + section])
    own = segment_transform(u, v, h)
    moved, turned = _segment_velocities(u, v, 1.0)
    moved = moved * h[..., None, None]
    N, K = u.shape
    position, rotation = np.empty((N, K, 3)), np.empty((N, K, 3, 3))
    linear, angular = np.zeros((N, K, 3, 4)), np.zeros((N, K, 3, 4))
    at, frame = np.zeros((N, 3)), np.broadcast_to(np.eye(3), (N, 3, 3))
    for k in range(K):
        linear[:, k, :, :2] = frame @ moved[:, k] * share[k]
        angular[:, k, :, :2] = frame @ turned[:, k] * share[k]
        step = (frame @ own[:, k, :3, 3:])[..., 0]
        linear[:, k, :, 2] = step / (1 + states[:, 2 * m + section[k], None])
        at = at + step
        frame = frame @ own[:, k, :3, :3]
        angular[:, k, :, 3] = frame[..., 2] * share[k] / m
        frame = frame @ _about_z(states[:, -1] * share[k] / m)
        position[:, k], rotation[:, k] = at, frame
    return _Pieces(position, rotation, linear, angular)


def _about_z(angle: Floats) -> Floats:
    matrix = np.zeros((len(angle), 3, 3))
    matrix[:, 0, 0] = matrix[:, 1, 1] = np.cos(angle)
    matrix[:, 1, 0] = np.sin(angle)
    matrix[:, 0, 1] = -matrix[:, 1, 0]
    matrix[:, 2, 2] = 1.0
    return matrix


@dataclass(frozen=True, eq=False)
class _Sums:
    """Velocities of pieces summed by what each is part of, up to any piece."""

    by_piece: Floats  # (N, K, 3, 4): of u, v, elongation, twist
    by_segment: Floats  # (N, 3, 2, m)
    running: Floats  # (N, K, 3, 2), of elongation and twist from the base on
    where: Places
    segment: Indices

    @classmethod
    def of(cls, velocities: Floats, where: Places, segment: Indices) -> "_Sums":
        first = np.flatnonzero(np.diff(segment, prepend=-1))
        bends = np.add.reduceat(velocities[..., :2], first, axis=1)
        running = np.cumsum(velocities[..., 2:], axis=1)
        return cls(velocities, np.moveaxis(bends, 1, -1), running, where, segment)

    def until(self, end: int) -> Floats:
        """By state, from the base to the end of piece `end` - 1, shape (N, 3, p)."""
        sections = self.where.sections
        m, last = sum(sections), int(self.segment[end - 1])
        first = int(np.searchsorted(self.segment, last))
        whole = np.zeros((len(self.by_piece), 3, 2 * m + len(sections) + 1))
        part = self.by_piece[:, first:end, :, :2].sum(axis=1)
        for axis in (0, 1):
            whole[..., axis * m : axis * m + last] = self.by_segment[:, :, axis, :last]
            whole[..., axis * m + last] = part[..., axis]
        before = np.zeros_like(whole[..., 0])
        for s, border in enumerate(np.cumsum(sections)):
            stop = min(end, int(np.searchsorted(self.segment, border)))
            total = self.running[:, stop - 1, :, 0]
            whole[..., 2 * m + s] = total - before
            before = total
        whole[..., -1] = self.running[:, end - 1, :, 1]
        return whole
