"""Joints cut into elements, and loads brought to the elements' ends.

Segments are cut into equal elements; where the bending stiffness steps from part to part, an
element ends too, so that each has one stiffness. Loads between the ends, spread or at a point, work
on places p and tangents d of the ends by the cubic through them: spread over an element of length
h (Euler-Maclaurin) the integral of p is h (p_0 + p_1) / 2 - h^2 (d_1 - d_0) / 12.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ccgen.shapes.loads.equilibrium import Array, DeadLoads, Index, Rods

_SAME = 1e-9
"""Share of the joint within which two ends of elements are one."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """N joints of m segments in E elements.

    Attributes:
        ends: of the elements, from 0 at the base to 1 at the tip, shape (E + 1,).
        starts: first element of each segment, shape (m,).
        unstretched: lengths of the elements without elongation, shape (E, 1), metres.
        rods: the elements' lengths and compliances.
    """

    ends: Array
    starts: Index
    unstretched: Array
    rods: Rods

    @property
    def straight(self) -> Array:
        """Angles u and v of the elements of straight joints, shape (E, 2, N)."""
        elements, n = self.rods.lengths.shape
        return np.zeros((elements, 2, n))


def cut(
    segments: int,
    least_elements: int,
    length: float,
    stiffness: Array,
    elongation: ArrayLike = 0.0,
) -> Mesh:
    """Cut joints into elements.

    Args:
        segments: number m of segments.
        least_elements: at least so many elements, and at least one a segment.
        length: of the joint without elongation, metres.
        stiffness: bending stiffness of P equal parts from the base, shape (P, N), N m^2.
        elongation: of each segment, share of its length, shape (m, N) or what broadcasts to it.
    """
    per_segment = max(1, -(-least_elements // segments))
    ends, starts = _ends(segments, per_segment, len(stiffness))
    shape = (segments, stiffness.shape[1])
    stretch = 1.0 + np.broadcast_to(np.asarray(elongation, dtype=np.float64), shape)
    stretch = np.repeat(stretch, np.diff(np.append(starts, len(ends) - 1)), axis=0)
    unstretched = length * np.diff(ends)[:, None]
    compliances = length * np.diff(_bend_per_moment(ends, stiffness), axis=0) * stretch
    return Mesh(ends, starts, unstretched, Rods(unstretched * stretch, compliances))


def no_loads(mesh: Mesh) -> DeadLoads:
    """Loads that are all zero."""
    elements, n = mesh.rods.lengths.shape
    return DeadLoads(np.zeros((2, n)), np.zeros((elements, 3, n)), np.zeros((elements, 3, n)))


def actuated(mesh: Mesh, angles: ArrayLike) -> DeadLoads:
    """The moment that alone bends each joint by `angles`, u and v, shape (2, N), radians."""
    return moment(mesh, np.asarray(angles) / mesh.rods.compliances.sum(axis=0))


def moment(mesh: Mesh, moments: ArrayLike) -> DeadLoads:
    """Moments on every element, so also tip moments, about x and y, shape (2, N), N m."""
    loads = no_loads(mesh)
    loads.moment[:] = moments
    return loads


def at_tip(mesh: Mesh, forces: ArrayLike) -> DeadLoads:
    """Forces at the tip, shape (3, N), newtons."""
    loads = no_loads(mesh)
    loads.force[-1] = forces
    return loads


def spread(mesh: Mesh, forces: ArrayLike) -> DeadLoads:
    """Forces along the joint, shape (3, N), newtons per metre without elongation."""
    loads = no_loads(mesh)
    each = mesh.unstretched[:, None] * np.asarray(forces)
    bent = each * mesh.rods.lengths[:, None] / 12
    loads.force[:] = each / 2
    loads.force[:-1] += each[1:] / 2
    loads.tangent[:] = -bent
    loads.tangent[:-1] += bent[1:]
    return loads


def contact(mesh: Mesh, places: Array, forces: Array) -> DeadLoads:
    """Forces at points of the joint.

    Args:
        mesh: the joints.
        places: shares of the length, from 0 to 1, shape (N,).
        forces: shape (3, N), newtons.
    """
    loads = no_loads(mesh)
    element = np.searchsorted(mesh.ends, places, side="right") - 1
    element = np.clip(element, 0, len(mesh.unstretched) - 1)
    samples = np.arange(len(places))
    t = (places - mesh.ends[element]) / (mesh.ends[element + 1] - mesh.ends[element])
    length = mesh.rods.lengths[element, samples]
    loads.force[element, :, samples] = (t * t * (3 - 2 * t) * forces).T
    loads.tangent[element, :, samples] = (length * t * t * (t - 1) * forces).T
    # The base neither moves nor turns: of a first element only the distal end counts.
    inner = element > 0
    before, samples = element[inner] - 1, samples[inner]
    t, length, forces = t[inner], length[inner], forces[:, inner]
    loads.force[before, :, samples] = ((1 + 2 * t) * (1 - t) ** 2 * forces).T
    loads.tangent[before, :, samples] = (length * t * (1 - t) ** 2 * forces).T
    return loads


def segment_angles(mesh: Mesh, angles: Array) -> tuple[Array, Array]:
    """Bends u and v of the segments, shape (N, m) each, radians: what strings measure."""
    sums = np.add.reduceat(angles, mesh.starts, axis=0)
    return np.ascontiguousarray(sums[:, 0].T), np.ascontiguousarray(sums[:, 1].T)


def _ends(segments: int, per_segment: int, parts: int) -> tuple[Array, Index]:
    """Ends of the elements and first element of each segment.

    More parts than elements count with their mean compliance: cutting by them would only make
    the elements many.
    """
    even = np.arange(segments * per_segment + 1) / (segments * per_segment)
    steps = np.arange(1, parts) / parts if parts < len(even) else np.empty(0)
    new = np.abs(steps[:, None] - even).min(axis=1) > _SAME
    ends = np.sort(np.concatenate([even, steps[new]]))
    starts = np.searchsorted(ends, even[:-1:per_segment])
    return ends, starts


def _bend_per_moment(ends: Array, stiffness: Array) -> Array:
    """The integral of 1 / EI from the base to each end, for length 1, shape (E + 1, N)."""
    parts = len(stiffness)
    sums = np.concatenate([np.zeros((1, stiffness.shape[1])), np.cumsum(1 / stiffness, axis=0)])
    part = np.minimum(np.floor(ends * parts + _SAME).astype(np.intp), parts - 1)
    return (sums[part] + (ends * parts - part)[:, None] / stiffness[part]) / parts
