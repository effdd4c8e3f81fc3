"""Loads drawn from the ranges of `[loads]`: low-discrepancy points, the same at every run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ccgen.joint.loads import PARTS, LoadRanges, Range
from ccgen.shapes.loads.equilibrium import Array, Index

GRAVITY = 9.80665
"""Metres per second squared."""

_SEED = 2020
_COORDINATES = 13
"""Of a point, without those of the sections and of the parts."""


@dataclass(frozen=True, eq=False)
class Draws:
    """N sets of loads on a joint.

    Attributes:
        stiffness: of P equal parts from the base, shape (P, N), N m^2.
        elongation: of the sections, shape (sections, N), share of the length.
        weight: along the joint, shape (3, N), newtons per metre without elongation.
        actuation: bends u and v by the actuators alone, shape (2, N), radians.
        tip_force: payload included, shape (3, N), newtons.
        tip_moment: about x and y, shape (2, N), newton metres.
        contact_place: share of the length, shape (N,).
        contact_force: shape (3, N), newtons.
        points: that they follow from, shape (D, N), inside (0, 1).
    """

    stiffness: Array
    elongation: Array
    weight: Array
    actuation: Array
    tip_force: Array
    tip_moment: Array
    contact_place: Array
    contact_force: Array
    points: Array

    def of(self, samples: Index) -> Draws:
        """Some of the sets."""
        return Draws(**{name: values[..., samples] for name, values in vars(self).items()})


def draw_loads(ranges: LoadRanges, length: float, sections: int, count: int) -> Draws:
    """Draw sets of loads; fewer of them are the first of more.

    Args:
        ranges: what to draw from.
        length: of the joint, metres.
        sections: parts of the joint that elongate by themselves.
        count: how many sets.
    """
    return loads_at(
        ranges, length, sections, _points(_COORDINATES + sections + _parts(ranges), count)
    )


def loads_at(ranges: LoadRanges, length: float, sections: int, points: Array) -> Draws:
    """Sets of loads at points of a unit cube; drawn evenly there, they are drawn from the ranges.

    Args:
        ranges, length, sections: as of `draw_loads`.
        points: shape (D, N), inside (0, 1), with the D of `Draws.points`.
    """
    gravity = _gravity(ranges.mounting, points[0], points[1])
    payload = _between(ranges.payload, points[2]) * GRAVITY * gravity
    force = _between(ranges.tip_force, points[3]) * _across(points[4])
    moment = _between(ranges.tip_moment, points[5]) * _across(points[6])
    place = (ranges.contact_from / length, 1.0)
    any_direction = _direction(2 * points[11] - 1, points[12])
    own = points[_COORDINATES:]
    return Draws(
        stiffness=_stiffness(ranges, own[sections:]),
        elongation=_between(ranges.elongation, own[:sections]),
        weight=ranges.mass * GRAVITY / length * gravity,
        actuation=_between(ranges.actuation, points[7:9]),
        tip_force=force + payload,
        tip_moment=moment[:2],
        contact_place=_between(place, points[10]),
        contact_force=_between(ranges.contact, points[9]) * any_direction,
        points=points,
    )


def _parts(ranges: LoadRanges) -> int:
    profile = len(ranges.stiffness_profile)
    return PARTS if ranges.stiffness_tolerance > 0 and profile == 1 else profile


def _points(dimensions: int, count: int) -> Array:
    """The first points of a scrambled Sobol sequence, shape (dimensions, count), in (0, 1)."""
    from scipy.stats import qmc

    sequence = qmc.Sobol(dimensions, scramble=True, seed=_SEED)
    points = sequence.random_base2(max(0, count - 1).bit_length())[:count].T
    # The normal distribution's quantile is infinite at 0.
    return np.asarray(np.maximum(points, 2.0**-40))


def _stiffness(ranges: LoadRanges, points: Array) -> Array:
    from scipy.special import ndtri

    profile = np.resize(ranges.stiffness_profile, len(points))
    nominal = ranges.stiffness * profile[:, None]
    return np.asarray(nominal * np.exp(ranges.stiffness_tolerance * ndtri(points)))


def _gravity(mounting: float | None, height: Array, azimuth: Array) -> Array:
    """Direction of gravity in the base frame, shape (3, N): z for a joint that hangs."""
    if mounting is None:
        return _direction(2 * height - 1, azimuth)
    return _direction(np.full_like(azimuth, np.cos(mounting)), azimuth)


def _direction(cosine: Array, azimuth: Array) -> Array:
    """Unit vectors by the cosine of their angle to z and their azimuth in turns, shape (3, N)."""
    sine = np.sqrt(np.maximum(0.0, 1 - cosine * cosine))
    x, y, _ = _across(azimuth)
    return np.stack([sine * x, sine * y, cosine])


def _across(azimuth: Array) -> Array:
    """Unit vectors across z by their azimuth in turns, shape (3, N)."""
    turn = 2 * np.pi * azimuth
    return np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])


def _between(range_: Range, points: ArrayLike) -> Array:
    low, high = range_
    return np.asarray(low + (high - low) * np.asarray(points))
