"""The statistic by which sensors are held against each other.

Sound readings y (length changes) have the second moment S = E[y y^T], of the shapes and of the
noise. Of one faulty sensor j, whose reading is off by an unknown constant, the most powerful
linear test is

    z_j = (S^-1 y)_j / sqrt((S^-1)_jj):

up to a factor what y_j differs by from its best prediction by the other sensors (Gauss-Markov; by
the block inverse, (S^-1 y)_j = (y_j - prediction) / its variance). Scaled to unit variance, the
largest |z_j| tells which sensor is off: without noise a fault in j gives z_k = rho_kj z_j with the
correlations rho of z, and |rho| <= 1. Redundancy need not be exact (parity space): what shapes
outside the dominant ones add to a prediction's error is part of S, as is noise.
"""

from collections.abc import Sequence

import numpy as np

from ccgen.estimation.consistency.sound import Floats, SoundReadings


def residual_matrix(sound: SoundReadings, groups: Sequence[slice]) -> Floats:
    """Matrix T, shape (n, n), 1/metres, with residuals z = T y of unit mean square.

    Evaluated in square-root form: S = A^T A for the weighted shapes above the noise's deviations,
    so that nearly dependent readings are not squared.

    Args:
        sound: readings whose noise is nowhere zero.
        groups: sensors that are held against each other; T is zero between groups.
    """
    matrix = np.zeros((sound.sensors, sound.sensors))
    for group in groups:
        matrix[group, group] = _residuals(sound.of(group))
    return matrix


def _residuals(sound: SoundReadings) -> Floats:
    rows = np.sqrt(sound.weight)[:, None] * sound.lengths
    noise = np.sqrt(sound.weight @ sound.variance)
    triangle = np.linalg.qr(np.vstack([rows, np.diag(noise)]), mode="r")
    inverse = np.linalg.inv(triangle)
    precision: Floats = inverse @ inverse.T
    return precision / np.sqrt(np.diag(precision))[:, None]
