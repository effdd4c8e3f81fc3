"""The largest box of coordinates in which no residual reaches its threshold.

With |p_i| <= t for all coordinates that decide on alarms, |z_j| <= t sum_i |B_ji|: nothing alarms
while t is at most the least threshold_j / sum_i |B_ji|. A node needs no more than that to know of
nearly every snapshot of sound sensors. How large the box is depends on how its edges lie, and they
may be turned freely.
"""

import numpy as np

from ccgen.estimation.consistency.residuals import Parity
from ccgen.estimation.consistency.sound import Floats

_ANGLES = np.linspace(-np.pi / 4.0, np.pi / 4.0, 65)
_SWEEPS = 20
_BETTER = 1e-6
"""Gains below are rounding, and not taken."""


def half_edge(parity: Parity, limits: Floats) -> float:
    """The largest t at which no residual of the box exceeds its threshold, shape (n,)."""
    return float(np.min(limits / np.abs(parity.directions[:, : parity.kept]).sum(axis=1)))


def boxed(parity: Parity, limits: Floats) -> Parity:
    """Residuals in coordinates, turned in one plane after the other, whose box is large.

    Args:
        parity: of a group.
        limits: thresholds of its residuals, shape (n,).
    """
    found, edge = parity, half_edge(parity, limits)
    for _ in range(_SWEEPS):
        before = edge
        for a in range(parity.kept):
            for b in range(a + 1, parity.kept):
                found, edge = _turned(found, limits, edge, a, b)
        if edge <= before:
            break
    return found


def _turned(parity: Parity, limits: Floats, edge: float, a: int, b: int) -> tuple[Parity, float]:
    """Turned in the plane of two coordinates to the largest box, where one is larger."""
    best = parity
    for angle in _ANGLES:
        turn = np.eye(len(parity.basis))
        turn[[a, b], [a, b]] = np.cos(angle)
        turn[a, b], turn[b, a] = np.sin(angle), -np.sin(angle)
        one = parity.rotated(turn)
        reached = half_edge(one, limits)
        if reached > edge * (1.0 + _BETTER):
            best, edge = one, reached
    return best, edge
