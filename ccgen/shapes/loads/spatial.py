"""Newton's step in space: gradient and Hessian of the energy, exactly.

A rate of x_e moves all that lies beyond element e as one rigid body, with an angular velocity w.
With N, M and K the force, the moment and the second moment of the loads at an element's end and
beyond, about that end, the Hessian of the loads' work between elements e < f is
w_e (slide_f x N_f + K_f w_f): of rank three, which `ccgen.shapes.loads.cholesky` makes use of.
"""

from __future__ import annotations

import numpy as np

from ccgen.shapes.loads.cholesky import System, solve
from ccgen.shapes.loads.elements import Elements, bent_elements
from ccgen.shapes.loads.equilibrium import Array, DeadLoads, Rods, Step, from_tip


def newton(angles: Array, rods: Rods, held: DeadLoads, raised: DeadLoads, factor: Array) -> Step:
    """Newton's step towards equilibrium under held + factor * raised.

    Args:
        angles: u and v of the elements, shape (E, 2, N), radians.
        rods: the joints.
        held: loads that the factor leaves alone.
        raised: loads that it multiplies.
        factor: shape (N,).
    """
    return solve(linearise(angles, rods, held, raised, factor))


def linearise(
    angles: Array, rods: Rods, held: DeadLoads, raised: DeadLoads, factor: Array
) -> System:
    """Newton's system H dx = r; arguments as for `newton`."""
    elements = bent_elements(angles)
    frames, places, tangents = _chain(elements, rods.lengths)
    spin = _turned(frames, elements.spin)
    slide = rods.lengths[:, None, None] * _turned(frames, elements.slide)
    loads = held + raised.scaled(factor)
    force, second = _beyond(places, tangents, loads)
    raised_force, raised_second = _beyond(places, tangents, raised)
    moment, raised_moment = _axial(second), _axial(raised_second)
    trace = second[:, 0, 0] + second[:, 1, 1] + second[:, 2, 2]
    levered = np.einsum("eijn,eajn->eain", second, spin) - trace[:, None, None] * spin
    return System(
        rows=spin,
        columns=-(_cross(slide, force[:, None]) + levered),
        diagonal=_diagonal(elements, frames, rods, force, moment, spin, levered),
        residual=(
            _gradient(slide, spin, force, moment)
            + loads.moment
            - angles / rods.compliances[:, None]
        ),
        rate=_gradient(slide, spin, raised_force, raised_moment) + raised.moment,
    )


def _chain(elements: Elements, lengths: Array) -> tuple[Array, Array, Array]:
    """Proximal frames (E, 3, 3, N), places and tangents (E, 3, N) of the distal ends."""
    rotation = elements.rotation
    frames = np.empty((rotation.shape[0] + 1, *rotation.shape[1:]))
    frames[0] = np.eye(3)[:, :, None]
    for e, turn in enumerate(rotation):
        np.einsum("ijn,jkn->ikn", frames[e], turn, out=frames[e + 1])
    steps = np.einsum("eijn,ejn->ein", frames[:-1], elements.tip)
    places = np.cumsum(lengths[:, None] * steps, axis=0)
    return frames[:-1], places, frames[1:, :, 2]


def _beyond(places: Array, tangents: Array, loads: DeadLoads) -> tuple[Array, Array]:
    """Force and second moment about each distal end of the loads there and beyond.

    Returns:
        The force, shape (E, 3, N), and the sum of r F^T and d G^T, shape (E, 3, 3, N).
    """
    force = from_tip(loads.force)
    second = from_tip(_outer(places, loads.force) + _outer(tangents, loads.tangent))
    return force, second - _outer(places, force)


def _diagonal(
    elements: Elements,
    frames: Array,
    rods: Rods,
    force: Array,
    moment: Array,
    spin: Array,
    levered: Array,
) -> Array:
    local_force = rods.lengths[:, None] * np.einsum("eijn,ein->ejn", frames, force)
    local_moment = np.einsum("eijn,ein->ejn", frames, moment)
    blocks = -_dot(elements.slide_rates, local_force[:, None])
    blocks -= _dot(elements.spin_rates, local_moment[:, None])
    blocks -= _dot(spin[:, [0, 0, 1]], levered[:, [0, 1, 1]])
    blocks[:, [0, 2]] += 1 / rods.compliances[:, None]
    return blocks


def _gradient(slide: Array, spin: Array, force: Array, moment: Array) -> Array:
    """Gradient of the loads' work, shape (E, 2, N)."""
    return _dot(slide, force[:, None]) + _dot(spin, moment[:, None])


def _turned(frames: Array, vectors: Array) -> Array:
    return np.asarray(np.einsum("eijn,eajn->eain", frames, vectors))


def _outer(first: Array, second: Array) -> Array:
    return first[:, :, None] * second[:, None]


def _axial(second: Array) -> Array:
    """The cross product r x F from r F^T."""
    return np.stack(
        [
            second[:, 1, 2] - second[:, 2, 1],
            second[:, 2, 0] - second[:, 0, 2],
            second[:, 0, 1] - second[:, 1, 0],
        ],
        axis=1,
    )


def _dot(first: Array, second: Array) -> Array:
    """Scalar products over the last axis but one."""
    product: Array = first[..., 0, :] * second[..., 0, :]
    for i in (1, 2):
        product = product + first[..., i, :] * second[..., i, :]
    return product


def _cross(first: Array, second: Array) -> Array:
    return np.cross(first, second, axis=-2)
