"""Shapes that no load case and no stated load foresees: six kinds in equal parts, in a plane.

They show what weights do to shapes that they were not fitted to. The kinds are free of any joint's
own loads, dimensionless (length 1, bending stiffness about 1), and depend on segments and range of
motion alone; the largest segment angle is spread evenly over the range, and the loads are scaled
to reach it. Draws are the same at every run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ccgen.shapes.loads import mesh as meshes
from ccgen.shapes.loads import planar
from ccgen.shapes.loads.continuation import LIMITED, Limit, raise_loads
from ccgen.shapes.loads.equilibrium import Array, DeadLoads, Flags, Rods
from ccgen.shapes.loads.mesh import Mesh

KINDS = (
    "tip force with moment",
    "actuation, weight, payload",
    "contact",
    "two contacts",
    "tapered stiffness",
    "two chambers",
)
"""What bends the joint: a force at the tip and a moment that opposes it; actuation against weight
and payload; a force at any place; two forces that oppose each other; a tip force and actuation
where stiffness grows or falls along the joint; actuation that differs between the halves."""

PER_KIND = 40

_SEED = 2020
_COORDINATES = 6
_ELEMENTS = 12
_ROUNDS = 3
_NEAREST_CONTACT = 0.05
_LARGEST_TAPER = 6.0
_SIZE = 30.0
"""Loads are raised to at most so many times what would reach the angle if the joint were linear."""


@dataclass(frozen=True, eq=False)
class OtherShapes:
    """Shapes of a bending axis.

    Attributes:
        angles: shape (N, m), radians.
        kinds: of each shape, a name of `KINDS`.
    """

    angles: Array
    kinds: tuple[str, ...]


def other_shapes(segments: int, range_of_motion: float, per_kind: int = PER_KIND) -> OtherShapes:
    """Draw shapes of every kind; fewer of a kind whose loads cannot bend the joint so far.

    Args:
        segments: number m of segments.
        range_of_motion: largest angle of a segment, radians.
        per_kind: how many shapes of each kind.
    """
    random = np.random.default_rng(_SEED)
    found = {kind: np.empty((0, segments)) for kind in KINDS}
    for _ in range(_ROUNDS):
        missing = [kind for kind, angles in found.items() if len(angles) < per_kind]
        # Some more than are needed, for another round takes as long as the first.
        draws = per_kind + per_kind // 5 + 1
        points = {kind: random.random((_COORDINATES, draws)) for kind in missing}
        for kind, angles in _bent(points, segments, range_of_motion).items():
            found[kind] = np.concatenate([found[kind], angles])[:per_kind]
    kinds = tuple(kind for kind, angles in found.items() for _ in angles)
    return OtherShapes(np.concatenate(list(found.values())), kinds)


def _bent(points: dict[str, Array], segments: int, range_of_motion: float) -> dict[str, Array]:
    """Shapes of kinds by the points that they are drawn with; all rods are bent at once."""
    chambers = points.pop("two chambers", None)
    bent = {}
    if points:
        drawn = [_LOADS[kind](p[1:], segments) for kind, p in points.items()]
        largest = range_of_motion * np.concatenate([p[0] for p in points.values()])
        angles, valid = _raised(drawn, largest)
        ends = np.cumsum([p.shape[1] for p in points.values()])[:-1]
        parts = zip(np.split(angles, ends), np.split(valid, ends), strict=True)
        bent = {kind: a[v] for kind, (a, v) in zip(points, parts, strict=True)}
    if chambers is not None:
        bent["two chambers"] = _two_chambers(chambers, segments, range_of_motion)
    return bent


def _raised(drawn: list[tuple[Mesh, DeadLoads]], largest: Array) -> tuple[Array, Flags]:
    """Raise loads until the largest segment angle is met, shape (N, m), and where that succeeds."""
    rods = Rods(
        np.concatenate([mesh.rods.lengths for mesh, _ in drawn], axis=-1),
        np.concatenate([mesh.rods.compliances for mesh, _ in drawn], axis=-1),
    )
    loads = DeadLoads(
        np.concatenate([loads.moment for _, loads in drawn], axis=-1),
        np.concatenate([loads.force for _, loads in drawn], axis=-1),
        np.concatenate([loads.tangent for _, loads in drawn], axis=-1),
    )
    starts = drawn[0][0].starts
    none, straight = loads.scaled(0.0), np.zeros((len(rods.lengths), 1, largest.size))
    linear = planar.newton(straight, rods, none, loads, np.zeros_like(largest)).tangent
    bend = np.abs(np.add.reduceat(linear[:, 0], starts, axis=0)).max(axis=0)
    loads = loads.scaled(_SIZE * largest / bend)
    raised = raise_loads(rods, none, loads, Limit(starts, largest), straight, planar.newton)
    angles = np.add.reduceat(raised.angles[:, 0], starts, axis=0).T
    return np.ascontiguousarray(angles), raised.outcome == LIMITED


def _tip_force_with_moment(points: Array, segments: int) -> tuple[Mesh, DeadLoads]:
    direction, share = points[:2]
    mesh = _mesh(segments, np.ones_like(points[:1]))
    force = _in_plane(direction)
    return mesh, meshes.at_tip(mesh, force) + _moment(mesh, -share * force[0])


def _actuation_and_weight(points: Array, segments: int) -> tuple[Mesh, DeadLoads]:
    direction, weight, payload, share = points[:4]
    mesh = _mesh(segments, np.ones_like(points[:1]))
    down = _in_plane(direction)
    at_base = (weight + payload) / 2 * down[0]
    loads = meshes.spread(mesh, weight * down) + meshes.at_tip(mesh, payload / 2 * down)
    return mesh, loads + _moment(mesh, -share * at_base)


def _contact(points: Array, segments: int) -> tuple[Mesh, DeadLoads]:
    direction, place = points[:2]
    mesh = _mesh(segments, np.ones_like(points[:1]))
    return mesh, meshes.contact(mesh, _place(place), _in_plane(direction))


def _two_contacts(points: Array, segments: int) -> tuple[Mesh, DeadLoads]:
    """The second contact takes up to twice the moment off the base that the first puts there."""
    direction, first, second, share = points[:4]
    first, second = _place(first), _place(second)
    mesh = _mesh(segments, np.ones_like(points[:1]))
    force = _in_plane(direction)
    against = -2 * share * first / second * force
    return mesh, meshes.contact(mesh, first, force) + meshes.contact(mesh, second, against)


def _tapered(points: Array, segments: int) -> tuple[Mesh, DeadLoads]:
    direction, force, actuation, taper = points[:4]
    parts = segments * _per_segment(segments)
    along = (np.arange(parts)[:, None] + 0.5) / parts
    mesh = _mesh(segments, _LARGEST_TAPER ** ((2 * taper - 1) * along))
    loads = meshes.at_tip(mesh, force * _in_plane(direction))
    return mesh, loads + _moment(mesh, 0.3 * (2 * actuation - 1))


_LOADS: dict[str, Callable[[Array, int], tuple[Mesh, DeadLoads]]] = dict(
    zip(
        KINDS,
        (_tip_force_with_moment, _actuation_and_weight, _contact, _two_contacts, _tapered),
        strict=False,
    )
)


def _two_chambers(points: Array, segments: int, range_of_motion: float) -> Array:
    """Two halves of constant curvature; where segments are odd, the middle one has both."""
    first = np.clip(segments / 2 - np.arange(segments), 0.0, 1.0)
    bend = 2 * points[1:3] - 1
    angles = np.outer(bend[0], first) + np.outer(bend[1], 1 - first)
    scale = range_of_motion * points[0] / np.abs(angles).max(axis=1)
    return np.asarray(scale[:, None] * angles)


def _mesh(segments: int, stiffness: Array) -> Mesh:
    return meshes.cut(segments, segments * _per_segment(segments), 1.0, stiffness)


def _per_segment(segments: int) -> int:
    return max(1, -(-_ELEMENTS // segments))


def _moment(mesh: Mesh, moment: Array) -> DeadLoads:
    return meshes.moment(mesh, np.stack([np.zeros_like(moment), moment]))


def _place(point: Array) -> Array:
    return _NEAREST_CONTACT + (1 - _NEAREST_CONTACT) * point


def _in_plane(turns: Array) -> Array:
    """Unit vectors in the plane of x and z by their direction in turns, shape (3, N)."""
    angle = 2 * np.pi * turns
    return np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)])
