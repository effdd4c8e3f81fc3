"""Weighted averaging method (WAM): every segment's angle from all sensors (section 2.5.2.3).

Residuals are angles in radians, which gives the paper's f_scale = 0.1 its unit. For simulated
shapes the loss is then quadratic to six digits; it bounds the pull of outliers in recordings.
"""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.minimum import minimum
from ccgen.estimation.soft_l1 import minimise, soft_l1
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.readings import SpansLike, exact_readings, readings

if TYPE_CHECKING:
    from ccgen.shapes import ShapeLibrary

F_SCALE = 0.1
"""Residual at which the soft-L1 loss turns linear, radians."""

PAPER_RADIUS = 0.004
"""Distance of the sensors from the neutral axis with which the paper's row is met, metres."""


def wam(library: "ShapeLibrary", spans: AnySpans) -> Weights:
    """Weights at the minimum of the soft-L1 objective of equation (7), for all segments at once.

    Where the shapes do not determine the weights (more sensors than independent readings), the
    minimum of smallest norm. The same bits on every machine.
    """
    read = exact_readings(library.angles, spans)
    return without_intercept("wam", spans, minimum(read, library.angles, F_SCALE))


def wam_matrix(angles: Floats, spans: SpansLike) -> Floats:
    """WAM weights of one placement or of a stack of them, fast and good to rounding.

    Args:
        angles: shapes to fit, shape (N, m), radians.
        spans: shape (n, 2) or (*stack, n, 2).

    Returns:
        Shape (m, n) or (*stack, m, n).
    """
    return minimise(np.moveaxis(readings(angles, spans), 0, -2), angles, F_SCALE)


def wam_objective(matrix: Floats, angles: Floats, spans: AnySpans) -> Floats:
    """Soft-L1 objective that `wam` minimises, per segment, shape (m,), radians squared.

    Args:
        matrix: weights, shape (m, n).
        angles: shapes, shape (N, m), radians.
        spans: the n sensors' spans.
    """
    return soft_l1((readings(angles, spans) @ matrix.T - angles).T, F_SCALE)


def wam_paper_call(
    library: "ShapeLibrary", spans: AnySpans, radius: float = PAPER_RADIUS
) -> Weights:
    """WAM by the paper's own optimiser call, for comparison; it stops short of the minimum.

    One `least_squares(loss="soft_l1", f_scale=0.1)` a segment from all-ones weights, with the
    default tolerances and residuals that are length changes in metres. Its gradient tolerance is
    absolute (1e-8), so the result depends on the unit and on `radius`; at 4 mm it reproduces the
    paper's WAM row.

    Args:
        library: shapes to fit.
        spans: the n sensors' spans.
        radius: distance of the sensors from the neutral axis, metres.
    """
    from scipy.optimize import least_squares

    lengths = radius * readings(library.angles, spans)

    def fit(target: Floats) -> Floats:
        def residual(weights: Floats) -> Floats:
            difference: Floats = lengths @ weights - target
            return difference

        start = np.ones(len(spans))
        solution: Floats = least_squares(residual, start, loss="soft_l1", f_scale=0.1).x
        return solution

    matrix = np.array([fit(target) for target in radius * library.angles.T])
    return without_intercept("wam-paper-call", spans, matrix)
