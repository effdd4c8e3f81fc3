"""The elastica: a joint that bends like a beam of any deflection, as algebraic equations.

The neutral axis is inextensible, bends in one plane and carries dead loads across its unbent
direction. With s in [0, 1] along the joint and everything made dimensionless by its length L and
bending stiffness EI (force F L^2/EI, distributed load q L^3/EI, moment M L/EI), the angle theta
between the axis and its unbent direction obeys

    theta'' = -(F + q (1 - s)) cos theta,    theta(0) = 0,    theta'(1) = M.

Integrated twice,

    theta(s) = M s + int_0^s int_t^1 (F + q (1 - r)) cos theta(r) dr dt,

it is collocated at Gauss-Legendre nodes. Integration is bounded, so the equations stay well
conditioned however many nodes there are, and the error falls exponentially with their number.

A state is the vector [theta at the nodes, load, moment]. One linear equation row . state = target
closes the system: an angle or a load that is asked for, or a step along a branch of solutions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from ccgen.shapes.collocation import collocation

FloatArray = NDArray[np.float64]

NODES = 64
"""Resolves angles to about 1e-12 up to loads of 50 and 1e-9 at `shapes.beam`'s limits."""

SIZE = NODES + 2
"""Length of a state."""

_MAX_ITERATIONS = 60
"""Newton's iteration takes 3 to 5; at an angle just below a local maximum, some 20."""


@dataclass(frozen=True)
class LoadCase:
    """Loads that grow together with one factor, the load.

    Attributes:
        name: what messages call it.
        force: force across the unbent axis at the tip, per unit of load.
        uniform: force per length along the whole joint, per unit of load.
        moment: moment at the tip, per unit of load; None: the moment that keeps the tip on the
            unbent axis, y(1) = int sin theta ds = 0.
        limit: load up to which the branch is followed.
    """

    name: str
    force: float = 0.0
    uniform: float = 0.0
    moment: float | None = 0.0
    limit: float = 1000.0

    def density(self) -> FloatArray:
        """Force that acts beyond each node, per unit of load, shape (NODES,)."""
        return self.force + self.uniform * (1 - POSITIONS)


@dataclass(frozen=True, eq=False)
class Equilibria:
    """Equilibrium states of one load case, shape (..., SIZE), read-only."""

    case: LoadCase
    states: FloatArray

    def __post_init__(self) -> None:
        self.states.setflags(write=False)

    @property
    def load(self) -> FloatArray:
        """Load, shape (...)."""
        return self.states[..., NODES]

    @property
    def moment(self) -> FloatArray:
        """Moment at the tip, shape (...)."""
        return self.states[..., NODES + 1]

    def angles(self, positions: ArrayLike) -> FloatArray:
        """Angle theta at positions s in [0, 1], shape (..., n_positions), radians."""
        return self.states @ angle_rows(np.asarray(positions, dtype=np.float64)).T


_MATRICES = collocation(NODES)
POSITIONS, QUADRATURE = _MATRICES.positions.hi, _MATRICES.quadrature.hi
_ANALYSIS, _TWICE_INTEGRATED = _MATRICES.analysis.hi, _MATRICES.twice_integrated.hi


def angle_rows(positions: FloatArray) -> FloatArray:
    """Rows that pick theta at positions s out of a state, shape (n_positions, SIZE)."""
    rows = np.zeros((positions.size, SIZE))
    rows[:, :NODES] = legendre.legvander(2 * positions - 1, NODES - 1) @ _ANALYSIS
    rows[positions == 0] = 0
    return rows


def load_row() -> FloatArray:
    """Row that picks the load out of a state, shape (SIZE,)."""
    row = np.zeros(SIZE)
    row[NODES] = 1
    return row


def base_curvature_row() -> FloatArray:
    """Row that picks theta'(0) out of a state, shape (SIZE,)."""
    row = np.zeros(SIZE)
    at_base = legendre.legvander(np.array([-1.0]), NODES - 2)[0]
    row[:NODES] = at_base @ (2 * legendre.legder(_ANALYSIS))
    return row


def solve(
    case: LoadCase, guesses: FloatArray, row: FloatArray, targets: float | FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Equilibria with row . state = target, by Newton's iteration on all of them at once.

    Args:
        case: load case.
        guesses: states nearby, shape (..., SIZE).
        row: shape (SIZE,).
        targets: shape (...).

    Returns:
        The states, and the tangents of the branch there, scaled so that row . tangent = 1; both of
        shape (..., SIZE).

    Raises:
        ArithmeticError: no convergence.
    """
    states = guesses
    ahead = np.zeros(states.shape)
    ahead[..., -1] = 1
    for _ in range(_MAX_ITERATIONS):
        residual, jacobian = linearise(case, states)
        residual[..., -1] = states @ row - targets
        jacobian[..., -1, :] = row
        solved = np.linalg.solve(jacobian, np.stack([residual, ahead], axis=-1))
        step, tangents = solved[..., 0], solved[..., 1]
        states = states - step
        # The error that is left is of the order of the square of this step.
        if np.all(np.abs(step) < 1e-9 * (1 + np.abs(states))):
            return states, np.asarray(tangents, dtype=np.float64)
    raise ArithmeticError(f"load case {case.name}: Newton's iteration does not converge")


def linearise(case: LoadCase, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals (..., SIZE) of the equilibrium and their Jacobians; the last row is left open."""
    angles = states[..., :NODES]
    load, moment = states[..., NODES, None], states[..., NODES + 1, None]
    density = case.density()
    per_load = (density * np.cos(angles)) @ _TWICE_INTEGRATED.T
    residual = np.zeros(states.shape)
    residual[..., :NODES] = angles - moment * POSITIONS - load * per_load
    jacobian = np.zeros((*states.shape, SIZE))
    slope = load * density * np.sin(angles)
    jacobian[..., :NODES, :NODES] = np.eye(NODES) + _TWICE_INTEGRATED * slope[..., None, :]
    jacobian[..., :NODES, NODES] = -per_load
    jacobian[..., :NODES, NODES + 1] = -POSITIONS
    if case.moment is None:
        residual[..., NODES] = np.sin(angles) @ QUADRATURE
        jacobian[..., NODES, :NODES] = QUADRATURE * np.cos(angles)
    else:
        residual[..., NODES] = moment[..., 0] - case.moment * load[..., 0]
        jacobian[..., NODES, NODES] = -case.moment
        jacobian[..., NODES, NODES + 1] = 1
    return residual, jacobian
