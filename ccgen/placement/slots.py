"""Which sensors of a placement may swap their spans, and what each of them tells of a segment.

A placement is an array of spans, shape (n, 2); the place of a span in it, its slot, says whose span
it is. The sensors of one of the paper's sets are all alike. Sensors that a joint file lists one by
one differ in angle, radius and transducer, and keep them.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ccgen.joint.layouts import Span

Indices = NDArray[np.intp]

UNSEEN = -1
"""Direction of a sensor that reads no bending which is estimated."""


@dataclass(frozen=True, eq=False)
class Slots:
    """The n sensors of a placement.

    Attributes:
        kinds: numbers, shape (n,); sensors of one kind may swap their spans.
        sides: numbers, shape (n,); sensors of one side run on top of each other.
        directions: numbers, shape (n,), of directions of bending that sensors read, or `UNSEEN`.
        needed: directions that must be read over every segment: one a bending axis.
        held: spans of sensors that stay, by slot.
    """

    kinds: Indices
    sides: Indices
    directions: Indices
    needed: int = 1
    held: Mapping[int, Span] = field(default_factory=dict)

    @classmethod
    def alike(cls, sensors: int, held: Mapping[int, Span]) -> "Slots":
        """Sensors that differ in nothing but their spans, all reading one bending axis."""
        same = np.zeros(sensors, dtype=np.intp)
        return cls(same, same, same, held=held)

    @cached_property
    def free(self) -> Indices:
        """Slots of the sensors that are placed."""
        return np.array([j for j in range(len(self.kinds)) if j not in self.held], dtype=np.intp)

    @property
    def are_alike(self) -> bool:
        """Whether all sensors are of one kind."""
        return bool(np.all(self.kinds == self.kinds[0]))

    def without(self, slot: int) -> "Slots":
        """The other sensors; which of them stay is of no account."""
        kinds, sides, directions = (
            np.delete(part, slot) for part in (self.kinds, self.sides, self.directions)
        )
        return Slots(kinds, sides, directions, self.needed)

    def of_each_side(self, spans: Indices) -> Iterator[Indices]:
        """Spans of the sensors of each side, shapes (..., k, 2), of placements (..., n, 2)."""
        return (spans[..., self.sides == side, :] for side in np.unique(self.sides))

    def lacking(self, spans: Indices, segments: int) -> Indices:
        """Number of directions that no sensor reads, by segment, shape (..., m).

        Args:
            spans: placements, shape (..., n, 2).
            segments: number m of segments.
        """
        read = np.zeros((*spans.shape[:-2], segments), dtype=np.intp)
        for direction in np.unique(self.directions[self.directions != UNSEEN]):
            read += coverage(spans[..., self.directions == direction, :], segments) > 0
        return np.asarray(np.maximum(self.needed - read, 0))

    def swapped(self, spans: Indices) -> Indices:
        """The placements in which two free sensors that differ have each other's spans, (P, n, 2).

        Args:
            spans: a placement, shape (n, 2).
        """
        pairs = [
            (j, k)
            for j, k in combinations(self.free.tolist(), 2)
            if self.kinds[j] != self.kinds[k] and (spans[j] != spans[k]).any()
        ]
        found = np.repeat(spans[None], len(pairs), axis=0)
        for one, (j, k) in zip(found, pairs, strict=True):
            one[[j, k]] = spans[[k, j]]
        return found

    def ordered(self, spans: Indices) -> Indices:
        """A placement, shape (n, 2), with the spans of each kind in order."""
        arranged = spans.copy()
        for kind in np.unique(self.kinds):
            own = np.flatnonzero(self.kinds == kind)
            first, last = spans[own].T
            arranged[own] = spans[own[np.lexsort((last, first))]]
        return arranged


def coverage(spans: Indices, segments: int) -> Indices:
    """Number of sensors over each segment, shape (..., m), of placements of shape (..., n, 2)."""
    numbers = np.arange(segments)
    over = (numbers >= spans[..., :1]) & (numbers <= spans[..., 1:])
    return np.asarray(over.sum(axis=-2), dtype=np.intp)
