"""How well weights do: the paper's score, the same under sensor noise, and the noise gain.

The figures are the same bits on every machine: errors are rounded once, and sums are exact.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ccgen.double_double import matmul
from ccgen.estimation.folded import folded_mean
from ccgen.estimation.weights import Floats, Weights
from ccgen.sensing.noise import checked_noise
from ccgen.sensing.readings import exact_readings, normalised_response

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import ShapeLibrary, Shapes


_ROUNDING = 1e-9
"""% of ROM below which an error is none."""

_TELLING = 0.1
"""% of ROM for each 1 % of elongation from which on it is said."""


def axis_errors(joint: "Joint", axis: str, weights: Weights, shapes: "Shapes") -> Floats:
    """Estimated minus actual values of an output axis without noise, shape (N, rows)."""
    state = shapes.state
    sensed = matmul(state, normalised_response(joint)[joint.own(axis)].T)
    wanted = state[:, joint.rows(axis)]
    return (matmul(sensed, weights.matrix.T) + (weights.intercept - wanted)).hi


def elongation_bias(joint: "Joint", axis: str, weights: Weights) -> Floats:
    """What an output axis estimates for each unit of elongation alike in all sections, (rows,).

    Bending axes should not see it at all, in radians a share; "h" should see all of it.
    """
    stretched = normalised_response(joint)[joint.own(axis), joint.rows("h")].sum(axis=1)
    return matmul(weights.matrix, stretched[:, None]).hi[:, 0]


def elongation_adds(joint: "Joint", weights: Mapping[str, Weights]) -> dict[str, float]:
    """Mean error of each bending axis that 1 % of elongation adds, % of the range of motion."""
    adds = {}
    for axis, one in weights.items():
        if axis != "h":
            bias = np.abs(elongation_bias(joint, axis, one))
            percent = math.fsum(bias) / (bias.size * joint.geometry.range_of_motion)
            adds[axis] = percent if percent > _ROUNDING else 0.0
    return adds


def elongation_warning(joint: "Joint", weights: Mapping[str, Weights]) -> str | None:
    """Say by how much elongation bends an estimate whose sensors cannot tell it from bending.

    Returns:
        None where the sensors tell it.
    """
    adds = elongation_adds(joint, weights)
    if max(adds.values(), default=0.0) < _TELLING:
        return None
    errors = " and ".join(f"{value:.3g} % of ROM to {axis}" for axis, value in adds.items())
    what = "each 1 % of it" if joint.geometry.elongation else "each 1 % that the joint may elongate"
    return f"the sensors cannot tell elongation from bending: {what} adds {errors}"


def score_percent_rom(weights: Weights, library: "ShapeLibrary") -> float:
    """Mean absolute error of a segment's angle, % of the range of motion (equation 12)."""
    return _percent_rom(np.abs(_errors(weights, library)), library)


def score_with_noise_percent_rom(
    weights: Weights, library: "ShapeLibrary", noise_rad: ArrayLike
) -> float:
    """Expectation of equation (12) when the readings carry independent Gaussian noise.

    A segment's error is then normal with mean mu (the error without noise) and standard
    deviation s = sqrt(sum_j (w_ij sigma_j)^2); the mean of its absolute value, of a folded normal
    variable, has a closed form (`ccgen.estimation.folded`). No sampling.

    Args:
        weights: the estimator.
        library: shapes to score on.
        noise_rad: one standard deviation of each normalised reading, shape (n,), radians.

    Raises:
        InputError: noise that is not n finite numbers of at least zero.
    """
    noise = checked_noise(noise_rad, weights.spans)
    errors = folded_mean(_errors(weights, library), _deviations(weights, noise))
    return _percent_rom(errors, library)


def noise_gain(weights: Weights) -> float:
    """Noise of an estimated angle per unit of reading noise: RMS over segments of |row|."""
    return _norm(weights.matrix) / math.sqrt(weights.segments)


def _errors(weights: Weights, library: "ShapeLibrary") -> Floats:
    """Estimated minus actual angles, shape (N, m), radians."""
    read = exact_readings(library.angles, weights.spans)
    return (matmul(read, weights.matrix.T) + (weights.intercept - library.angles)).hi


def _percent_rom(errors: Floats, library: "ShapeLibrary") -> float:
    return 100.0 * math.fsum(errors.flat) / (errors.size * library.range_of_motion)


def _deviations(weights: Weights, noise: Floats) -> Floats:
    """Deviation of each estimated value under the noise of the readings, shape (rows,)."""
    return np.array([_norm(row) for row in weights.matrix * noise])


def _norm(values: Floats) -> float:
    return math.sqrt(math.fsum(np.square(values).flat))
