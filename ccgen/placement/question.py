"""What all questions of a placement share: sensors to place, and what the builder allows."""

from abc import ABC, abstractmethod
from collections.abc import Hashable
from functools import cached_property
from typing import Protocol

import numpy as np

from ccgen.errors import InputError
from ccgen.joint.layouts import Spans
from ccgen.placement.constraints import Constraints
from ccgen.placement.objective import Floats, Indices


class Model(Protocol):
    """Evaluates an objective, or what stands for it, for many placements at once."""

    def values(self, spans: Indices) -> Floats:
        """Value of each placement in %, shape (P,), for spans of shape (P, n, 2)."""

    def moved_values(self, others: Indices, catalogue: Indices, slot: int) -> Floats:
        """Value for each span of a catalogue beside the other sensors, shape (S,), in %.

        Args:
            others: shape (n - 1, 2).
            catalogue: shape (S, 2).
            slot: place of the moving sensor among the n.
        """


class Question(ABC):
    """Where to put the sensors of one or two bending axes, whose spans are the same.

    Attributes:
        sensors: number n of sensors of an axis, fixed ones included.
        constraints: what the builder allows.
    """

    sensors: int
    constraints: Constraints

    @property
    @abstractmethod
    def segments(self) -> int:
        """Number m of segments."""

    @property
    @abstractmethod
    def key(self) -> Hashable:
        """Alike for questions about a joint that have the same answer."""

    @property
    @abstractmethod
    def model(self) -> Model:
        """Evaluates whole populations."""

    @property
    @abstractmethod
    def estimator(self) -> str:
        """The estimation method whose errors placements are judged by."""

    @property
    @abstractmethod
    def objective(self) -> str:
        """One of `ccgen.placement.OBJECTIVES`."""

    @abstractmethod
    def percent(self, spans: Spans) -> float:
        """Objective of one placement in %, by `ccgen.estimation` itself."""

    @abstractmethod
    def percents(self, spans: Indices) -> Floats:
        """Objective of each placement in %, shape (P,)."""

    @cached_property
    def catalogue(self) -> Indices:
        """Spans that a free sensor may have, shape (S, 2).

        Raises:
            InputError: there is none, and a sensor is free.
        """
        spans = self.constraints.catalogue(self.segments)
        if not len(spans) and len(self.constraints.fixed) < self.sensors:
            raise InputError("no span keeps to the constraints; loosen them")
        return spans

    def allows(self, spans: Spans) -> bool:
        """Whether a placement has the right number of sensors and keeps to every constraint."""
        rest = list(spans)
        for span in self.constraints.fixed:
            if span not in rest:
                return False
            rest.remove(span)
        ordered = np.array([*self.constraints.fixed, *rest], dtype=np.intp)
        return len(ordered) == self.sensors and not self.violations(ordered[None])[0]

    def violations(self, spans: Indices) -> Indices:
        """Number of broken constraints of placements with the fixed sensors first, shape (P,)."""
        return self.constraints.violations(spans, self.segments)


def as_spans(placement: Indices) -> Spans:
    """A placement, shape (n, 2), as spans in order."""
    return tuple(sorted((int(a), int(b)) for a, b in placement))
