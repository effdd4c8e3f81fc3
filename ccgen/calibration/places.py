"""Where a sensor runs, by what it reads: its distance from the neutral axis, its angle around it.

A sensor reads gain times r (U sin a - V cos a) + E, with U and V the bends and E the elongation of
its span. Bending tells the angle and the product of gain and radius; elongation tells the gain, and
so the radius.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.learning import independent_rows

Floats = NDArray[np.float64]

LARGEST_RADIUS_STD = 0.1
"""Share of the radius."""
LARGEST_ANGLE_STD = np.radians(10.0)

_FREEDOM = 4.0
_TURNS = 20
_FEWEST = 30
_DEPENDENT = 1e-6
"""Smallest singular value of columns of length 1 up to which they depend on each other."""


@dataclass(frozen=True)
class Place:
    """Where a sensor was found to run; None where recordings do not determine it."""

    radius: float | None = None
    """Metres."""
    radius_std: float | None = None
    angle: float | None = None
    """Around the neutral axis from +x, 0 to 2 pi, radians."""
    angle_std: float | None = None


@dataclass(frozen=True, eq=False)
class Bent:
    """Bends and elongation of the spans of n sensors in N rows, and what they read.

    Attributes:
        u: bend about x of each span, shape (N, n), radians; NaN: unknown.
        v: bend about y, likewise.
        stretch: elongation of each span, shape (N, n), metres.
        lengths: readings at nominal gain, shape (N, n), metres; NaN: none.
    """

    u: Floats
    v: Floats
    stretch: Floats
    lengths: Floats


def places(recordings: Sequence[Bent], vague: Floats) -> tuple[Place, ...]:
    """Find where the n sensors of a joint run.

    Args:
        recordings: with signs of gains as they are, so that a wrong sign is no wrong side.
        vague: by which shapes that rest on sensors may be off, share of them, shape (n,).
    """
    return tuple(_wider(_place(recordings, j), float(share)) for j, share in enumerate(vague))


def _wider(place: Place, share: float) -> Place:
    """A place with deviations that know by how much shapes may be off."""
    angle, radius = place.angle_std, place.radius_std
    return replace(
        place,
        angle_std=None if angle is None else float(np.hypot(angle, share)),
        radius_std=None
        if radius is None or place.radius is None
        else float(np.hypot(radius, share * place.radius)),
    )


def _place(recordings: Sequence[Bent], j: int) -> Place:
    rows = _rows(recordings, j)
    moves = np.ptp(rows[:, :3], axis=0) > 0 if len(rows) >= _FEWEST else np.zeros(3, dtype=bool)
    if not moves[:2].all() or not _independent(rows[:, :2]):
        return Place()
    moves[2] &= _independent(rows[:, :3])
    fitted, covariance = _regressed(rows[:, :3][:, moves], rows[:, 3])
    a, b = fitted[:2]
    reach = float(np.hypot(a, b))
    along = np.array([b, -a]) / max(reach, 1e-12) ** 2  # the angle's derivative by a and b
    angle_std = float(np.sqrt(along @ covariance[:2, :2] @ along))
    if angle_std > LARGEST_ANGLE_STD:
        return Place()
    angle = float(np.arctan2(a, -b)) % (2 * np.pi)
    k = fitted[2] if moves[2] else 0.0
    if not k > 0:
        return Place(angle=angle, angle_std=angle_std)
    radius = reach / k
    by = np.array([a / reach, b / reach, -radius]) / k
    radius_std = float(np.sqrt(by @ covariance @ by))
    if radius_std > LARGEST_RADIUS_STD * radius:
        return Place(angle=angle, angle_std=angle_std)
    return Place(float(radius), radius_std, angle, angle_std)


def _independent(columns: Floats) -> bool:
    """Whether no column follows from the others, as in a joint that bends in one slanted plane."""
    size = np.linalg.norm(columns, axis=0)
    if not size.all():
        return False
    return float(np.linalg.svd(columns / size, compute_uv=False)[-1]) > _DEPENDENT


def _rows(recordings: Sequence[Bent], j: int) -> Floats:
    """Bends, elongation and reading of one sensor, about their means in each recording."""
    parts = [
        np.stack([one.u[:, j], one.v[:, j], one.stretch[:, j], one.lengths[:, j]], axis=1)
        for one in recordings
    ]
    kept = [part[~np.isnan(part).any(axis=1)] for part in parts]
    return np.concatenate(
        [part - part.mean(axis=0) for part in kept if len(part)] or [np.zeros((0, 4))]
    )


def _regressed(design: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Coefficients by robust regression, and their covariance.

    Scores follow each other in time, so that their sum varies more than that of as many
    independent ones (Newey and West, Econometrica 55, 1987).
    """
    trust, fitted, residual = np.ones(len(y)), np.zeros(design.shape[1]), y
    for _ in range(_TURNS):
        weighed = trust[:, None] * design
        fitted = np.asarray(np.linalg.solve(weighed.T @ design, weighed.T @ y), dtype=np.float64)
        residual = y - design @ fitted
        scale = max(float(np.sqrt(np.mean(trust * np.square(residual)))), 1e-9)
        trust = (_FREEDOM + 1) / (_FREEDOM + np.square(residual / scale))
    scores = (trust * residual)[:, None] * design
    alike = [len(y) / independent_rows(one[:, None]) for one in scores.T]
    spread = np.sqrt(np.maximum(alike, 1.0))
    inverse = np.linalg.inv((trust[:, None] * design).T @ design)
    return fitted, inverse @ ((scores.T @ scores) * np.outer(spread, spread)) @ inverse
