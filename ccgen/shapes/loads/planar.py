"""Newton's step where joints bend about y alone: a fraction of the work of the spatial one.

The turn up to an element's end is a sum of angles, and all that lies beyond an element turns about
one axis: blocks of the Hessian between elements e < f do not depend on e. With g_n of
`ccgen.shapes.loads.elements`, an element's chord is s = g_1(x^2 / 4) times its length and points
half its angle ahead.
"""

from __future__ import annotations

import numpy as np

from ccgen.shapes.loads.elements import functions
from ccgen.shapes.loads.equilibrium import Array, DeadLoads, Flags, Rods, Step, from_tip, pivot_root

_PLANE = [0, 2]
"""x and z."""


def newton(angles: Array, rods: Rods, held: DeadLoads, raised: DeadLoads, factor: Array) -> Step:
    """Newton's step towards equilibrium under held + factor * raised, in the plane of x and z.

    Args:
        angles: v of the elements, shape (E, 1, N), radians.
        rods: the joints.
        held: loads that the factor leaves alone; what they do out of the plane is left out.
        raised: loads that it multiplies.
        factor: shape (N,).
    """
    x = angles[:, 0]
    turn = np.cumsum(x, axis=0)
    chord, slide, bend = _chords(x, turn, rods.lengths)
    places = np.cumsum(chord, axis=0)
    tangents = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    loads = held + raised.scaled(factor)
    force, moment, stretch = _beyond(places, tangents, loads)
    raised_force, raised_moment, _ = _beyond(places, tangents, raised)
    residual = _dot(slide, force) + moment + loads.moment[1] - x / rods.compliances
    rate = _dot(slide, raised_force) + raised_moment + raised.moment[1]
    columns = stretch - _dot(_turned(slide), force)
    diagonal = 1 / rods.compliances + stretch - _dot(bend, force)
    return _solve(columns, diagonal, np.stack([residual, rate], axis=1))


def _chords(x: Array, turn: Array, lengths: Array) -> tuple[Array, Array, Array]:
    """Chords of the elements and their first and second derivatives by x, shape (E, 2, N)."""
    a, b, c, d, e, _ = functions(x * x / 4)
    first, second = (c - b) / 2, ((3 * e - d) / 2 - d + c / 2) / 2
    s, s1, s2 = a, x / 2 * first, first / 2 + x * x / 4 * second
    middle = turn - x / 2
    ahead = lengths[:, None] * np.stack([np.sin(middle), np.cos(middle)], axis=1)
    across = _turned(ahead)
    return (
        s[:, None] * ahead,
        s1[:, None] * ahead + s[:, None] / 2 * across,
        (s2 - s / 4)[:, None] * ahead + s1[:, None] * across,
    )


def _beyond(places: Array, tangents: Array, loads: DeadLoads) -> tuple[Array, Array, Array]:
    """Force, moment and scalar product with the lever of the loads at each end and beyond."""
    load, tangent = loads.force[:, _PLANE], loads.tangent[:, _PLANE]
    force = from_tip(load)
    moment = from_tip(_dot(_turned(places), load) + _dot(_turned(tangents), tangent))
    stretch = from_tip(_dot(places, load) + _dot(tangents, tangent))
    return force, moment - _dot(_turned(places), force), stretch - _dot(places, force)


def _solve(columns: Array, diagonal: Array, right: Array) -> Step:
    """Cholesky's factorisation with columns_f below every diagonal element e < f; both solutions.

    As `ccgen.shapes.loads.cholesky`, with one column and one angle an element.
    """
    roots, scaled = np.empty_like(diagonal), np.empty_like(diagonal)
    stable: Flags = np.ones(diagonal.shape[1], dtype=bool)
    square, sums = np.zeros_like(diagonal[0]), np.zeros_like(right[0])
    solution = np.empty_like(right)
    for e, column in enumerate(columns):
        roots[e] = pivot_root(diagonal[e] - column * column * square, stable)
        scaled[e] = (1 - column * square) / roots[e]
        solution[e] = (right[e] - column * sums) / roots[e]
        square = square + scaled[e] * scaled[e]
        sums = sums + scaled[e] * solution[e]
    sums = np.zeros_like(right[0])
    for e in reversed(range(len(columns))):
        solution[e] = (solution[e] - scaled[e] * sums) / roots[e]
        sums = sums + columns[e] * solution[e]
    return Step(solution[:, :1], solution[:, 1:], stable)


def _turned(vectors: Array) -> Array:
    """Vectors after a quarter of a turn from z to x, as a rate about y moves them."""
    return np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)


def _dot(first: Array, second: Array) -> Array:
    return np.asarray(first[:, 0] * second[:, 0] + first[:, 1] * second[:, 1])
