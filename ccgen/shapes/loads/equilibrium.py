"""Clamped joints, dead loads on them, and what a Newton step towards equilibrium is.

The energy of one joint, whose elements bend by x_e = (u_e, v_e) and have compliances C_e, is

    sum_e |x_e|^2 / (2 C_e) - sum_e m x_e - sum_e (F_e p_e + G_e d_e)

p_e and d_e are place and tangent of the distal end of element e in the base frame. The moment m,
the same in every element's own frame, stands for actuation and for a tip moment alike; F_e and G_e
are dead loads, which work on the ends' places and tangents.

Arrays have elements first and samples last.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Rods:
    """N clamped joints of E elements each.

    Attributes:
        lengths: of the elements, stretched, shape (E, N), metres.
        compliances: bend per moment, shape (E, N), radians per newton metre.
    """

    lengths: Array
    compliances: Array

    def of(self, samples: Index) -> Rods:
        """Some of the joints."""
        return Rods(self.lengths[:, samples], self.compliances[:, samples])


@dataclass(frozen=True, eq=False)
class DeadLoads:
    """Loads on N joints that keep their direction in the base frame as the joint bends.

    Attributes:
        moment: m, about every element's own x and y axes, shape (2, N), newton metres.
        force: F, on the places of the elements' distal ends, shape (E, 3, N), newtons.
        tangent: G, on the tangents of the elements' distal ends, shape (E, 3, N), newton metres.
    """

    moment: Array
    force: Array
    tangent: Array

    def of(self, samples: Index) -> DeadLoads:
        """Those on some of the joints."""
        return DeadLoads(
            self.moment[:, samples], self.force[..., samples], self.tangent[..., samples]
        )

    def scaled(self, factor: float | Array) -> DeadLoads:
        """All of them times a factor, a number or one a joint, shape (N,)."""
        return DeadLoads(factor * self.moment, factor * self.force, factor * self.tangent)

    def __add__(self, other: DeadLoads) -> DeadLoads:
        return DeadLoads(
            self.moment + other.moment, self.force + other.force, self.tangent + other.tangent
        )


@dataclass(frozen=True, eq=False)
class Step:
    """Solution of Newton's system of N joints; without meaning where it is not stable.

    Attributes:
        correction: Newton's step, shape (E, axes, N), radians.
        tangent: rate of the angles where the raised loads grow, shape (E, axes, N), radians.
        stable: whether the energy's Hessian is positive definite, shape (N,).
    """

    correction: Array
    tangent: Array
    stable: Flags


Newton = Callable[[Array, Rods, DeadLoads, DeadLoads, Array], Step]
"""Newton's step from angles of shape (E, axes, N), radians, of joints under held loads and raised
loads times a factor of shape (N,)."""


def from_tip(values: Array) -> Array:
    """Sums over an element and all beyond it."""
    return np.cumsum(values[::-1], axis=0)[::-1]


def pivot_root(square: Array, stable: Flags) -> Array:
    """Root of a pivot; one that is not positive ends its joint's stability.

    Infinite then: what is divided by it vanishes, and what comes after does not overflow.
    """
    positive = square > 0
    stable &= positive
    return np.sqrt(np.where(positive, square, np.inf))
