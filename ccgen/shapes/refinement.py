"""Equilibria in double-double precision, and the segment angles that they round to.

Shapes differ little from each other, and what differs decides the weights: the last digits of an
equilibrium in double precision, which vector units and the BLAS leave different, would be seen in
them. Newton's iteration with residuals in twice the precision (iterative refinement) goes on until
the solution of the collocated equations is known to about 1e-29. Its Jacobian need not be better
than double precision: it only decides how fast that is reached.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ccgen.double_double import DoubleDouble, concatenate, matmul, sine_and_versine
from ccgen.shapes.collocation import collocation
from ccgen.shapes.elastica import NODES, FloatArray, LoadCase, linearise

_MAX_STEPS = 12
"""Two suffice; more where the angle asked for is just below a local maximum."""

_SETTLED = 1e-27
"""Share of a state's angles and of its loads: a step after one so small is below rounding."""


def segment_angles(
    case: LoadCase, states: FloatArray, segments: int, first_segment: FloatArray
) -> FloatArray:
    """Segment angles of equilibria whose first segment bends by the angles asked for.

    Args:
        case: load case.
        states: these equilibria in double precision, shape (n, SIZE).
        segments: number of equal segments.
        first_segment: shape (n,), radians.

    Returns:
        Shape (n, segments), radians: the nearest doubles.

    Raises:
        ArithmeticError: no convergence.
    """
    rows = _rows_of_ends(segments)
    nodal = _refined(case, states, rows[1], first_segment)[:, :NODES]
    at_ends = matmul(nodal, rows[1:].T)
    base = DoubleDouble.of(np.zeros((len(states), 1)))
    return (at_ends - concatenate([base, at_ends[:, :-1]], axis=1)).hi


@lru_cache(maxsize=64)
def _rows_of_ends(segments: int) -> DoubleDouble:
    """Rows that interpolate nodal angles at the ends of the segments, shape (m + 1, NODES)."""
    ends = DoubleDouble.of(np.arange(segments + 1.0)) / float(segments)
    return collocation(NODES).at(ends)


def _refined(
    case: LoadCase, guesses: FloatArray, row: DoubleDouble, targets: FloatArray
) -> DoubleDouble:
    """Equilibria near the guesses with row . angles = target, shape (n, SIZE)."""
    states = DoubleDouble.of(guesses)
    for _ in range(_MAX_STEPS):
        residual = _residual(case, states)
        asked = matmul(states[:, :NODES], row[:, None]) - targets[:, None]
        jacobian = linearise(case, states.hi)[1]
        jacobian[:, -1, :NODES] = row.hi
        wanted = np.concatenate([residual.hi, asked.hi], axis=1)
        step = np.linalg.solve(jacobian, wanted[..., None])[..., 0]
        states = states - step
        if np.all(_sizes(step) <= _SETTLED * _sizes(states.hi)):
            return states
    raise ArithmeticError(f"load case {case.name}: the refinement does not converge")


def _sizes(states: FloatArray) -> FloatArray:
    """Largest angle, and largest of load and moment, of each state; shape (n, 2)."""
    parts = states[:, :NODES], states[:, NODES:]
    return np.stack([np.abs(part).max(axis=1) for part in parts], axis=1)


def _residual(case: LoadCase, states: DoubleDouble) -> DoubleDouble:
    """Residuals of the collocated equilibrium and of the moment, shape (n, NODES + 1)."""
    nodes = collocation(NODES)
    angles = states[:, :NODES]
    load, moment = states[:, NODES : NODES + 1], states[:, NODES + 1 :]
    density = case.force + case.uniform * (1 - nodes.positions)
    sine, versine = sine_and_versine(angles)
    per_load = matmul(density * (1 - versine), nodes.twice_integrated.T)
    bending = angles - moment * nodes.positions - load * per_load
    if case.moment is None:
        last = matmul(sine, nodes.quadrature[:, None])
    else:
        last = moment - case.moment * load
    return concatenate([bending, last], axis=1)
