"""One element of constant curvature with its first and second derivatives.

An element bends by u about the local x axis and by v about the local y axis without twisting. With
q = u^2 + v^2 and g_n(q) = sum over k of (-q)^k / (2 k + n)!, its rotation R and its tip t (for unit
length) are, with a = g_1 and b = g_2,

    R = exp([u, v, 0]^),    t = [b v, -b u, a]

Every g_n is entire; g_n = 1/n! - q g_(n+2) leads from the two last ones down to a and b, and
dg_n/dq = (n g_(n+2) - g_(n+1)) / 2 gives the derivatives: no square root, no trigonometry, no
singularity at the straight element.

Arrays have elements first and samples last: a loop over elements then works on whole rows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ccgen.shapes.loads.equilibrium import Array

_TERMS = 11
"""Of the two series: for q up to 10, half a turn an element, what is left out is below 1e-15."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Geometry of E elements of unit length in N samples, each in its own proximal frame.

    Attributes:
        rotation: R, shape (E, 3, 3, N).
        tip: t, shape (E, 3, N).
        spin: angular velocity of the distal end at unit rate of u and of v, shape (E, 2, 3, N).
        slide: velocity of the tip at unit rate of u and of v, shape (E, 2, 3, N).
        spin_rates: derivatives of the spin of u by u, of u by v and of v by v, (E, 3, 3, N).
        slide_rates: derivatives of the slide, in the same order, shape (E, 3, 3, N).
    """

    rotation: Array
    tip: Array
    spin: Array
    slide: Array
    spin_rates: Array
    slide_rates: Array


def bent_elements(angles: Array) -> Elements:
    """Geometry of elements that bend by `angles`, shape (E, 2, N), u before v, radians."""
    u, v = angles[:, 0], angles[:, 1]
    uu, uv, vv = u * u, u * v, v * v
    a, b, c, d, e, f = functions(uu + vv)
    # Derivatives by q, then by u and v.
    a1, b1, c1, d1 = (c - b) / 2, d - c / 2, (3 * e - d) / 2, 2 * f - e / 2
    a2, b2 = (c1 - b1) / 2, d1 - c1 / 2
    bu, bv, cu, cv = 2 * u * b1, 2 * v * b1, 2 * u * c1, 2 * v * c1
    buu, buv, bvv = 2 * b1 + 4 * uu * b2, 4 * uv * b2, 2 * b1 + 4 * vv * b2
    auu, auv, avv = 2 * a1 + 4 * uu * a2, 4 * uv * a2, 2 * a1 + 4 * vv * a2
    return Elements(
        rotation=_stack(
            _stack(1 - b * vv, b * uv, a * v),
            _stack(b * uv, 1 - b * uu, -a * u),
            _stack(-a * v, a * u, 1 - b * (uu + vv)),
        ),
        tip=_stack(b * v, -b * u, a),
        spin=_stack(
            _stack(1 - c * vv, c * uv, -b * v),
            _stack(c * uv, 1 - c * uu, b * u),
        ),
        slide=_stack(
            _stack(bu * v, -b - u * bu, 2 * u * a1),
            _stack(b + v * bv, -u * bv, 2 * v * a1),
        ),
        spin_rates=_stack(
            _stack(-cu * vv, (cu * u + c) * v, -bu * v),
            _stack(-(cv * v + 2 * c) * v, (cv * v + c) * u, -bv * v - b),
            _stack((cv * v + c) * u, -cv * uu, bv * u),
        ),
        slide_rates=_stack(
            _stack(v * buu, -2 * bu - u * buu, auu),
            _stack(bu + v * buv, -bv - u * buv, auv),
            _stack(2 * bv + v * bvv, -u * bvv, avv),
        ),
    )


def functions(q: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
    """The functions g_1 to g_6 of q, from 0 to 10."""
    e, f = _series(5, q), _series(6, q)
    d = 1 / 24 - q * f
    c = 1 / 6 - q * e
    return 1 - q * c, 1 / 2 - q * d, c, d, e, f


def _series(n: int, q: Array) -> Array:
    total = np.zeros_like(q)
    for k in reversed(range(_TERMS)):
        total = 1 / math.factorial(2 * k + n) - q * total
    return total


def _stack(*rows: Array) -> Array:
    """Stack along a new second axis, behind the elements."""
    return np.stack(rows, axis=1)
