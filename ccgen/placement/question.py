"""What all questions of a placement share: sensors to place, and what the builder allows."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Hashable
from functools import cached_property
from typing import Protocol

import numpy as np

from ccgen.errors import InputError
from ccgen.joint.layouts import LAYOUTS, AnySpan, AnySpans, Spans, spans_for
from ccgen.placement.constraints import Constraints
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.slots import Slots


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
    """Where to put some sensors.

    Attributes:
        sensors: number n of spans to choose, those that stay included.
        constraints: what the builder allows.
    """

    sensors: int
    constraints: Constraints

    @cached_property
    def slots(self) -> Slots:
        """Whose spans those of a placement are; sensors that are all alike, fixed ones first."""
        return Slots.alike(self.sensors, dict(enumerate(self.constraints.fixed)))

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
    def percent(self, spans: AnySpans) -> float:
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
        if not len(spans) and len(self.slots.free):
            raise InputError("no span keeps to the constraints; loosen them")
        return spans

    @property
    def layouts(self) -> tuple[str, ...]:
        """Names of placements that need no search."""
        return tuple(name for name in LAYOUTS if name != "single" or self.sensors == 1)

    def laid_out(self, layout: str) -> AnySpans:
        """Spans of the layout with that name.

        Raises:
            InputError: it does not fit the sensors.
        """
        if layout == "single" and self.sensors != 1:
            raise InputError(f"the layout single has 1 sensor, not {self.sensors}")
        try:
            return spans_for(layout, self.segments, self.sensors)
        except ValueError as error:
            raise InputError(str(error)) from error

    def allows(self, spans: AnySpans) -> bool:
        """Whether a placement has the right number of sensors and keeps to every constraint."""
        given: Counter[AnySpan] = Counter(spans)
        fixed: Counter[AnySpan] = Counter(self.constraints.fixed)
        if not fixed <= given:
            return False
        rest = (given - fixed).elements()
        ordered = np.array([*self.constraints.fixed, *rest], dtype=np.intp)
        return len(ordered) == self.sensors and not self.violations(ordered[None])[0]

    def violations(self, spans: Indices) -> Indices:
        """Number of broken constraints of placements, shape (P,); sensors in their slots."""
        return self.constraints.violations(spans, self.segments, self.slots)

    def arranged(self, placement: Indices) -> Spans:
        """A placement, shape (n, 2), as spans, those of sensors that are alike in order."""
        return _tuples(self.slots.ordered(placement))


def as_spans(placement: Indices) -> Spans:
    """A placement of sensors that are all alike, shape (n, 2), as spans in order."""
    return tuple(sorted(_tuples(placement)))


def _tuples(placement: Indices) -> Spans:
    return tuple((int(a), int(b)) for a, b in placement)
