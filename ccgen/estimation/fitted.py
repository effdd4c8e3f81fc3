"""Weights as fitted: what they were fitted to, what they get wrong, what serves in their place."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from ccgen.errors import ReachError
from ccgen.estimation.errors import ErrorRow, Missed, errors_of, missed
from ccgen.estimation.fallback import fallback
from ccgen.estimation.fit import Task
from ccgen.estimation.sources import CASES, OTHER, Source, within_axes
from ccgen.estimation.weights import Weights
from ccgen.joint import METHODS

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import Shapes


@dataclass(frozen=True)
class Without:
    """Errors that remain when one sensor is lost and the fallback's weights serve.

    Told with noise on the shapes that the joint states first: recordings, loads, or the cases.
    """

    sensor: str
    rms_deg: Mapping[str, float | None]
    """By bending axis; None where no sensor of the axis is left."""
    tip_rms_m: float | None


@dataclass(frozen=True, eq=False)
class FittedWeights:
    """Weights of a joint and everything that is told of them.

    Attributes:
        joint: the joint.
        method: by which the weights were fitted.
        weights: of each output axis; they apply to normalised readings.
        task: what they were fitted to.
    """

    joint: "Joint"
    method: str
    weights: Mapping[str, Weights]
    task: Task

    @property
    def rounding(self) -> Mapping[str, float]:
        """Root mean square of what fixed point adds to a value of an axis, where it is known."""
        return {}

    @cached_property
    def told(self) -> tuple[Source, ...]:
        """Sources that errors are told on: cases, loads or shapes given, shapes of other loads."""
        return tuple(self._cases[0] + self._others)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What is to be said of the sources, a sentence each."""
        return (*self._cases[1], *(note for source in self.task.sources for note in source.notes))

    @cached_property
    def errors(self) -> tuple[ErrorRow, ...]:
        """Errors on each source, without noise and with everything that is stated."""
        return tuple(
            errors_of(source.name, self.missed(source.shapes, noise), noise, self.held_out(source))
            for source in self.told
            for noise in (False, True)
        )

    @cached_property
    def quick(self) -> Task:
        """The same task for weights that are compared only, not exported: right to rounding."""
        return replace(self.task, exact=False)

    @property
    def _serving(self) -> str:
        """Method of the weights that serve without a sensor."""
        return self.method if self.method in METHODS else "wam"

    @cached_property
    def without(self) -> tuple[Without, ...]:
        """What each single sensor lost leaves."""
        return tuple(self._without(j) for j in range(len(self.joint.sensors)))

    @property
    def stated(self) -> Source:
        """The shapes that say most of the joint: recordings, else its loads, else the cases."""
        order = {OTHER: 2, CASES: 1}
        return min(self.told, key=lambda source: order.get(source.name, 0))

    def held_out(self, source: Source) -> bool:
        """Whether the weights were fitted without that source."""
        return not any(own.name == source.name and own.weight > 0 for own in self.task.sources)

    def missed(
        self, shapes: "Shapes", noise: bool, weights: Mapping[str, Weights] | None = None
    ) -> Missed:
        """Errors of the weights, or of others in their place, on simulated shapes."""
        own = self.weights if weights is None else weights
        return missed(self.joint, own, shapes, noise, self.task.noise, self.rounding)

    def _readers(self, sensor: int) -> list[str]:
        """Axes that read a sensor."""
        every = range(len(self.joint.sensors))
        return [axis for axis in self.joint.axes if sensor in every[self.joint.own(axis)]]

    @cached_property
    def _cases(self) -> tuple[list[Source], list[str]]:
        """The load cases between fitted amplitudes, or why they are left out."""
        from ccgen.shapes import score_shapes

        if not self.joint.shapes.cases:
            return [], []
        try:
            return [Source(CASES, score_shapes(self.joint), 0.0)], []
        except ReachError as error:
            return [], [f"the load cases are left out of the errors: {error}"]

    @cached_property
    def _others(self) -> list[Source]:
        from ccgen.shapes.loads.library import other_library

        own = [source for source in self.task.sources if source.name != CASES]
        return [*own, Source(OTHER, within_axes(self.joint, other_library(self.joint)), 0.0)]

    def fallback(self, axis: str, sensor: int, task: Task | None = None) -> Weights | None:
        """Weights of an axis without a sensor of the joint; None where it is lost without it."""
        first = self.joint.own(axis).start
        return fallback(task or self.task, axis, self._serving, sensor - first)

    def _without(self, sensor: int) -> Without:
        name = self.joint.sensors[sensor].name
        served = {a: self.fallback(a, sensor, self.quick) for a in self._readers(sensor)}
        lost = [axis for axis, own in served.items() if own is None]
        known = {axis: own for axis, own in served.items() if own is not None}
        weights = {**self.weights, **known}
        found = errors_of(name, self.missed(self.stated.shapes, True, weights), True, False)
        return Without(
            sensor=name,
            rms_deg={a: None if a in lost else rms for a, rms in found.rms_deg.items()},
            tip_rms_m=None if lost else found.tip_rms_m,
        )
