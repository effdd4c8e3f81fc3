"""Shapes far out: those few of a joint's loads whose sensors contradict each other most.

Thresholds at which one snapshot of a million alarms follow from shapes that as few draws show.
Subset simulation reaches them: of drawn shapes the eighth with the largest residuals are starts of
Markov chains that stay among such shapes; of what they visit again the eighth with the largest; and
so on, each turn eight times rarer, until many shapes share what exceeds the thresholds (Au and Beck
2001, "Estimation of small failure probabilities in high dimensions by subset simulation"). Chains
move as conditional sampling does, by a normal step to a correlated neighbour in the space where
loads are standard normal, taken where it stays beyond the level (Papaioannou et al. 2015, "MCMC
algorithms for subset simulation").
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation.consistency.sound import Floats

_SHARE = 8
"""One of so many shapes starts a chain of the next turn."""
_VISITED = 1024
"""Shapes of a turn, those among them that start it."""

_SEED = 2020
_STEP = 0.6
"""Of the first moves, of a standard deviation."""
_TAKEN = 0.44
"""Share of moves to be taken, by which steps grow or shrink."""
_EDGE = 2.0**-40
"""Of the unit cube, which a normal distribution has no place for."""


@dataclass(frozen=True, eq=False)
class Visited:
    """N draws of loads and what sensors read of their shapes.

    Attributes:
        points: that the loads follow from, shape (N, D), inside (0, 1).
        lengths: shape (N, n), metres.
    """

    points: Floats
    lengths: Floats

    def of(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> "Visited":
        """Some of them."""
        return Visited(self.points[rows], self.lengths[rows])


Read = Callable[[Floats], tuple[Floats, NDArray[np.bool_]]]
"""Lengths (K, n) at points (K, D), and which of them are shapes at all."""


def with_tails(
    drawn: Visited,
    read: Read,
    reach: Callable[[Floats], Floats],
    enough: Callable[[Floats, Floats], bool],
    rarest: float,
) -> tuple[Floats, Floats]:
    """Lengths of shapes far out beside those that were drawn, and how much each counts.

    Args:
        drawn: evenly.
        read: what sensors read at other points.
        reach: how far out lengths (K, n) are, shape (K,).
        enough: whether lengths and weights tell what they are needed for.
        rarest: share of all shapes below which it does not matter which they are.

    Returns:
        Shapes (K, n) and (K,); the weights' sum is 1.
    """
    chains = _Chains(read, reach)
    lengths, weights = drawn.lengths[:0], np.zeros(0)
    current, mass = drawn, 1.0
    while True:
        count = len(current.lengths)
        all_lengths = np.concatenate([lengths, current.lengths])
        all_weights = np.concatenate([weights, np.full(count, mass / count)])
        starts = count // _SHARE
        if starts < 2 or mass < rarest or enough(all_lengths, all_weights):
            return all_lengths, all_weights
        far = np.argsort(-reach(current.lengths), kind="stable")
        left, first = far[starts:], current.of(far[:starts])
        lengths = np.concatenate([lengths, current.lengths[left]])
        weights = np.concatenate([weights, np.full(left.size, mass / count)])
        current, mass = chains.from_starts(first), mass * starts / count


class _Chains:
    """Markov chains whose steps adapt to how often they are taken."""

    def __init__(self, read: Read, reach: Callable[[Floats], Floats]) -> None:
        self.read, self.reach = read, reach
        self.random = np.random.default_rng(_SEED)
        self.log_step, self.moves = float(np.log(_STEP)), 0

    def from_starts(self, starts: Visited) -> Visited:
        """The starts and what chains visit from them, all as far out as the nearest start."""
        level = float(self.reach(starts.lengths).min())
        visited = [starts]
        while sum(len(one.lengths) for one in visited) < _VISITED:
            visited.append(self._moved(visited[-1], level))
        return Visited(
            np.concatenate([one.points for one in visited]),
            np.concatenate([one.lengths for one in visited]),
        )

    def _moved(self, before: Visited, level: float) -> Visited:
        from scipy.special import ndtr, ndtri

        step = min(1.0, float(np.exp(self.log_step)))
        noise = self.random.normal(size=before.points.shape)
        normal = np.sqrt(1.0 - step * step) * ndtri(before.points) + step * noise
        points = np.clip(ndtr(normal), _EDGE, 1.0 - _EDGE)
        lengths, are_shapes = self.read(points)
        taken = are_shapes & (self.reach(lengths) >= level)
        self.moves += 1
        self.log_step += (float(taken.mean()) - _TAKEN) / np.sqrt(self.moves)
        kept = taken[:, None]
        return Visited(
            np.where(kept, points, before.points), np.where(kept, lengths, before.lengths)
        )
