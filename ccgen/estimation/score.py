"""How well weights do: the paper's score, the same under sensor noise, and the noise gain.

The figures are the same bits on every machine: errors are rounded once, and sums are exact.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ccgen.double_double import matmul
from ccgen.estimation.folded import folded_mean
from ccgen.estimation.weights import Floats, Weights
from ccgen.sensing.noise import checked_noise, reading_noise
from ccgen.sensing.readings import exact_readings

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import ShapeLibrary


@dataclass(frozen=True)
class ErrorRow:
    """Error of the estimate over the shapes of one source.

    Attributes:
        source: where the shapes came from, such as "cases".
        held_out: whether the weights were fitted to other shapes.
        noise: whether readings carry the transducers' noise.
        mean_percent_rom: mean absolute error of a segment's angle by axis, % of the range of
            motion (equation 12).
    """

    source: str
    held_out: bool
    noise: bool
    mean_percent_rom: dict[str, float]


def error_rows(
    joint: "Joint",
    weights: Mapping[str, Weights],
    libraries: "Mapping[str, ShapeLibrary]",
    source: str,
    held_out: bool,
) -> list[ErrorRow]:
    """Errors over the shapes of one source: without noise, and with it where it is stated.

    Args:
        joint: its sensors and their noise.
        weights, libraries: by axis.
        source, held_out: as in `ErrorRow`.
    """
    plain = {axis: score_percent_rom(one, libraries[axis]) for axis, one in weights.items()}
    rows = [ErrorRow(source, held_out, False, plain)]
    noise = {axis: reading_noise(joint, axis) for axis in weights}
    noisy = {
        axis: score_with_noise_percent_rom(weights[axis], libraries[axis], sigma)
        for axis, sigma in noise.items()
        if sigma is not None
    }
    if len(noisy) == len(weights):
        rows.append(ErrorRow(source, held_out, True, noisy))
    return rows


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
    deviations = np.array([_norm(row) for row in weights.matrix * noise])
    return _percent_rom(folded_mean(_errors(weights, library), deviations), library)


def noise_gain(weights: Weights) -> float:
    """Noise of an estimated angle per unit of reading noise: RMS over segments of |row|."""
    return _norm(weights.matrix) / math.sqrt(weights.segments)


def _errors(weights: Weights, library: "ShapeLibrary") -> Floats:
    """Estimated minus actual angles, shape (N, m), radians."""
    read = exact_readings(library.angles, weights.spans)
    return (matmul(read, weights.matrix.T) + (weights.intercept - library.angles)).hi


def _percent_rom(errors: Floats, library: "ShapeLibrary") -> float:
    return 100.0 * math.fsum(errors.flat) / (errors.size * library.range_of_motion)


def _norm(values: Floats) -> float:
    return math.sqrt(math.fsum(np.square(values).flat))
