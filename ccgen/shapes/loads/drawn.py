"""Shapes under drawn loads, within the range of motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ccgen.joint.loads import LoadRanges
from ccgen.shapes.library import Shapes
from ccgen.shapes.loads import mesh as meshes
from ccgen.shapes.loads.continuation import (
    LIMITED,
    LOST,
    OUTSIDE,
    REACHED,
    STEEPEST,
    Limit,
    Raised,
    raise_loads,
)
from ccgen.shapes.loads.draws import Draws, draw_loads, loads_at
from ccgen.shapes.loads.equilibrium import Array, DeadLoads, Flags, Index

ELEMENTS = 24
"""At least so many: angles are right to 0.1 % of the largest, to 0.01 % where turns are small."""

_ATTEMPTS = 4
"""At most so many draws for each shape that is asked for."""

_BATCH = 256
"""Draws at once: what Newton's step works on stays near the processor."""

_FEWEST = 0.1
"""Share of the draws that is enough to give a shape, known after the first batch."""


@dataclass(frozen=True, eq=False)
class DrawnShapes:
    """Shapes of N drawn loads, and what became of the other draws.

    Attributes:
        shapes: of the source "loads".
        loads: of each shape, before they are scaled.
        factor: by which actuation, forces, moments, contact and payload are scaled, shape (N,).
        drawn: how many loads were drawn.
        buckled: how many of them buckle.
        out_of_range: how many are beyond the range of motion whatever the factor.
    """

    shapes: Shapes
    loads: Draws
    factor: Array
    drawn: int
    buckled: int
    out_of_range: int


def drawn_shapes(
    ranges: LoadRanges, sections: tuple[int, ...], length: float, range_of_motion: float
) -> DrawnShapes:
    """Draw loads until there are as many shapes as the ranges ask for, or draws run out.

    Where hardly any draw gives a shape there are no more than the first draws give.

    Args:
        ranges: what to draw from.
        sections: segments of each part that elongates by itself.
        length: of the joint without elongation, metres.
        range_of_motion: largest angle of a segment and axis, radians.
    """
    most = _ATTEMPTS * ranges.samples
    draws = draw_loads(ranges, length, len(sections), most)
    bent: list[_Bent] = []
    drawn = found = 0
    while found < ranges.samples and drawn < most and not _hopeless(found, drawn):
        ahead = min(ranges.samples - found, _BATCH)
        some = np.arange(drawn, min(drawn + ahead, most))
        bent.append(_bend(draws.of(some), sections, length, range_of_motion))
        drawn += some.size
        found += int(bent[-1].valid.sum())
    return _gathered(draws, bent)


def shapes_at(
    ranges: LoadRanges,
    sections: tuple[int, ...],
    length: float,
    range_of_motion: float,
    points: Array,
) -> tuple[Shapes, Flags]:
    """Shapes of the loads at points, as `drawn_shapes` has them, and which of them are shapes.

    Args:
        ranges, sections, length, range_of_motion: as of `drawn_shapes`.
        points: shape (D, N), as of `Draws`.

    Returns:
        N rows and flags, shape (N,); rows of loads that buckle the joint or bend it beyond its
        range are none.
    """
    draws = loads_at(ranges, length, len(sections), points)
    bent = _bend(draws, sections, length, range_of_motion)
    return Shapes(bent.u, bent.v, draws.elongation.T, ("loads",) * points.shape[1]), bent.valid


def _hopeless(found: int, drawn: int) -> bool:
    """Whether so few draws give a shape that more of them would take long and tell little."""
    return drawn >= _BATCH and found < _FEWEST * drawn


@dataclass(frozen=True, eq=False)
class _Bent:
    """What became of some draws."""

    u: Array
    v: Array
    factor: Array
    outcome: Index

    @property
    def valid(self) -> Flags:
        return np.isin(self.outcome, (REACHED, LIMITED))


def _gathered(draws: Draws, bent: list[_Bent]) -> DrawnShapes:
    u, v, factor, outcome, valid = (
        np.concatenate([getattr(some, name) for some in bent])
        for name in ("u", "v", "factor", "outcome", "valid")
    )
    kept = draws.of(np.flatnonzero(valid))
    return DrawnShapes(
        shapes=Shapes(u[valid], v[valid], kept.elongation.T, ("loads",) * int(valid.sum())),
        loads=kept,
        factor=factor[valid],
        drawn=outcome.size,
        buckled=int((outcome == LOST).sum()),
        out_of_range=int((outcome == OUTSIDE).sum()),
    )


def _bend(draws: Draws, sections: tuple[int, ...], length: float, range_of_motion: float) -> _Bent:
    """Let the weight act first: it is there whatever the factor of the other loads."""
    elongation = np.repeat(draws.elongation, sections, axis=0)
    mesh = meshes.cut(sum(sections), ELEMENTS, length, draws.stiffness, elongation)
    limits = np.full(draws.contact_place.shape, range_of_motion)
    weight = meshes.spread(mesh, draws.weight)
    hanging = _hanging(mesh, weight)
    bent = raise_loads(
        mesh.rods, weight, _scalable(mesh, draws), Limit(mesh.starts, limits), hanging.angles
    )
    alone = np.where(hanging.outcome == LIMITED, OUTSIDE, hanging.outcome)
    outcome = np.where(hanging.outcome == REACHED, bent.outcome, alone)
    return _Bent(*meshes.segment_angles(mesh, bent.angles), bent.factor, outcome)


def _hanging(mesh: meshes.Mesh, weight: DeadLoads) -> Raised:
    """The joints under their weight alone."""
    straight, n = mesh.straight, mesh.straight.shape[-1]
    if not weight.force.any():
        return Raised(straight, np.ones(n), np.full(n, REACHED, dtype=np.int8))
    steep = Limit(mesh.starts, np.full(n, STEEPEST))
    return raise_loads(mesh.rods, meshes.no_loads(mesh), weight, steep, straight)


def _scalable(mesh: meshes.Mesh, draws: Draws) -> DeadLoads:
    return (
        meshes.actuated(mesh, draws.actuation)
        + meshes.at_tip(mesh, draws.tip_force)
        + meshes.moment(mesh, draws.tip_moment)
        + meshes.contact(mesh, draws.contact_place, draws.contact_force)
    )
