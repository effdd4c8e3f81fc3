"""How well weights do: the paper's score, the same under sensor noise, and the noise gain."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ccgen.estimation.weights import Floats, Weights
from ccgen.sensing.noise import checked_noise
from ccgen.sensing.readings import readings

if TYPE_CHECKING:
    from ccgen.shapes import ShapeLibrary


def score_percent_rom(weights: Weights, library: "ShapeLibrary") -> float:
    """Mean absolute error of a segment's angle, % of the range of motion (equation 12)."""
    return _percent_rom(np.abs(_errors(weights, library)), library)


def score_with_noise_percent_rom(
    weights: Weights, library: "ShapeLibrary", noise_rad: ArrayLike
) -> float:
    """Expectation of equation (12) when the readings carry independent Gaussian noise.

    A segment's error is then normal with mean mu (the error without noise) and standard
    deviation s = sqrt(sum_j (w_ij sigma_j)^2); the mean of its absolute value, of a folded normal
    variable, is s sqrt(2/pi) exp(-mu^2 / 2 s^2) + mu erf(mu / (s sqrt 2)). No sampling.

    Args:
        weights: the estimator.
        library: shapes to score on.
        noise_rad: one standard deviation of each normalised reading, shape (n,), radians.

    Raises:
        InputError: noise that is not n finite numbers of at least zero.
    """
    from scipy.special import erf

    noise = checked_noise(noise_rad, weights.spans)
    mu = _errors(weights, library)
    s = np.linalg.norm(weights.matrix * noise, axis=1)
    # Without noise the ratio is infinite or, for no error at all, arbitrary: both terms hold.
    ratio = np.divide(np.abs(mu), s * np.sqrt(2.0), out=np.full_like(mu, np.inf), where=s > 0)
    folded = s * np.sqrt(2.0 / np.pi) * np.exp(-np.square(ratio)) + np.abs(mu) * erf(ratio)
    return _percent_rom(folded, library)


def noise_gain(weights: Weights) -> float:
    """Noise of an estimated angle per unit of reading noise: RMS over segments of |row|."""
    return float(np.sqrt(np.square(weights.matrix).sum(axis=1).mean()))


def _errors(weights: Weights, library: "ShapeLibrary") -> Floats:
    """Estimated minus actual angles, shape (N, m), radians."""
    errors: Floats = weights.estimate(readings(library.angles, weights.spans)) - library.angles
    return errors


def _percent_rom(errors: Floats, library: "ShapeLibrary") -> float:
    return float(100.0 * errors.mean() / library.range_of_motion)
