"""The statistic by which sensors are held against each other.

Sound readings y (length changes) have the second moment S = E[y y^T], of the shapes and of the
noise. Of one faulty sensor j, whose reading is off by an unknown constant, the most powerful
linear test is

    z_j = (S^-1 y)_j / sqrt((S^-1)_jj):

up to a factor what y_j differs by from its best prediction by the other sensors (Gauss-Markov; by
the block inverse, (S^-1 y)_j = (y_j - prediction) / its variance). Scaled to unit variance, the
largest |z_j| tells which sensor is off: without noise a fault in j gives z_k = rho_kj z_j with the
correlations rho of z, and |rho| <= 1.

In coordinates in which S is the unit matrix, p = W y, residuals are z = B p. Along few of the
coordinates shapes move less than noise, or little more (parity space; redundancy need not be
exact), and these make up nearly all of z: an alarm is decided by them alone, as few as leave each
z_j at least `KEPT` of its power. The others join them where an alarm asks for a name, for they tell
apart what large faults look like.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ccgen.estimation.consistency.sound import Floats, SoundReadings

KEPT = 0.95
"""Share of the power of a fault of each sensor that decides on alarms."""

_ALIKE = 1e-6
"""Coordinates whose variances differ by less are kept or left together."""
_TIED = 1e-9
"""Pivots that differ by less are equal, and the first is taken."""


@dataclass(frozen=True, eq=False)
class Parity:
    """Residuals of n sensors by coordinates of unit mean square.

    Attributes:
        basis: W, shape (n, n), 1/metres: p = W y.
        directions: B, shape (n, n): z = B p, rows of unit length.
        kept: how many of the first coordinates decide on alarms.
    """

    basis: Floats
    directions: Floats
    kept: int

    @property
    def alarming(self) -> Floats:
        """Matrix of the residuals that alarm, shape (n, n), 1/metres."""
        return np.asarray(self.directions[:, : self.kept] @ self.basis[: self.kept])

    @property
    def naming(self) -> Floats:
        """Matrix of the residuals that name a sensor, shape (n, n), 1/metres."""
        return np.asarray(self.directions @ self.basis)

    def rotated(self, turn: Floats) -> "Parity":
        """The same residuals in other coordinates p' = turn^T p, turn orthogonal."""
        return Parity(turn.T @ self.basis, self.directions @ turn, self.kept)


def parity(sound: SoundReadings) -> Parity:
    """Coordinates and residuals of one group of sensors.

    Shapes are decomposed in units of the sensors' noise, without squaring them, so that nearly
    dependent readings keep their digits.

    Args:
        sound: readings whose noise is nowhere zero.
    """
    noise = np.sqrt(sound.weight @ sound.variance)
    rows = np.sqrt(sound.weight)[:, None] * sound.lengths / noise
    triangle = np.linalg.qr(np.vstack([rows, np.zeros((sound.sensors, sound.sensors))]), mode="r")
    _, deviation, vectors = np.linalg.svd(triangle)
    spread = np.sqrt(1.0 + np.square(deviation[::-1]))
    whitened = vectors[::-1] / spread[:, None]
    power = np.cumsum(np.square(whitened), axis=0)
    kept = int(np.argmax((power >= KEPT * power[-1]).all(axis=1))) + 1
    while kept < sound.sensors and spread[kept] < (1.0 + _ALIKE) * spread[kept - 1]:
        kept += 1
    found = Parity(whitened / noise, whitened.T / np.sqrt(power[-1])[:, None], kept)
    turn = np.zeros((sound.sensors, sound.sensors))
    for part in (slice(0, kept), slice(kept, sound.sensors)):
        turn[part, part] = _pivoted(found.directions[:, part])
    return found.rotated(turn)


def _pivoted(directions: Floats) -> Floats:
    """Orthogonal axes along the longest rows, one after the other: alike wherever computed."""
    left, axes = directions, []
    for _ in range(directions.shape[1]):
        length = np.linalg.norm(left, axis=1)
        first = int(np.flatnonzero(length >= (1.0 - _TIED) * length.max())[0])
        axes.append(left[first] / length[first])
        left = left - np.outer(left @ axes[-1], axes[-1])
    if not axes:
        return np.zeros((0, 0))
    # What rounding left of one axis in another is taken off, and no sign changed.
    exact, triangle = np.linalg.qr(np.array(axes).T)
    return np.asarray(exact * np.sign(np.diag(triangle)))


def alarm_matrix(sound: SoundReadings, groups: Sequence[slice]) -> Floats:
    """Matrix of the residuals that alarm, shape (n, n), 1/metres, of groups of sensors.

    Args:
        sound: readings whose noise is nowhere zero.
        groups: sensors that are held against each other; the matrix is zero between groups.
    """
    matrix = np.zeros((sound.sensors, sound.sensors))
    for group in groups:
        matrix[group, group] = parity(sound.of(group)).alarming
    return matrix
