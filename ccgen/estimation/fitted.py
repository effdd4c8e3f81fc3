"""Weights as fitted: what they were fitted to, what they get wrong, what serves in their place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from ccgen.errors import ReachError
from ccgen.estimation.errors import (
    ErrorRow,
    Missed,
    Pooled,
    StandardDeviations,
    errors_of,
    missed,
    standard_deviations,
)
from ccgen.estimation.fallback import fallback
from ccgen.estimation.fit import Task
from ccgen.estimation.held_out import Block, Choice, RecordedFit
from ccgen.estimation.recorded import Recorded
from ccgen.estimation.sources import CASES, LOADS, OTHER, RECORDING, Source
from ccgen.estimation.weights import Weights
from ccgen.joint import METHODS
from ccgen.recordings.progress import Report, in_silence

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.recordings.recording import Recording


@dataclass(frozen=True)
class Without:
    """Errors that remain when one sensor is lost and the fallback's weights serve.

    Told with noise on the shapes that say most of the joint: a recording, its loads, or the cases.
    """

    sensor: str
    rms_deg: Mapping[str, float | None]
    """Of a segment, by bending axis; None where no sensor of the axis is left."""
    elongation_rms_percent: float | None
    """Of a section, % of its length; None likewise, and where elongation is not estimated."""
    tip_rms_m: float | None
    deviations: Mapping[str, tuple[float, ...] | None]
    """Standard deviations of every value by output axis, as those of `StandardDeviations`."""


@dataclass(frozen=True, eq=False)
class FittedWeights:
    """Weights of a joint and everything that is told of them.

    Attributes:
        joint: the joint, as its file has it.
        method: by which the weights were fitted.
        weights: of each output axis; they apply to normalised readings.
        task: what they were fitted to, and the joint with its sensors as they were found.
        recordings: of the joint, read, where they were fitted to or are to be judged on.
        found: their references.
        report: told of progress where something takes long.
    """

    joint: "Joint"
    method: str
    weights: Mapping[str, Weights]
    task: Task
    recordings: Sequence["Recording"] = ()
    found: Recorded | None = None
    report: Report = in_silence

    @property
    def sensed(self) -> "Joint":
        """The joint with its sensors as they were found."""
        return self.task.joint

    @property
    def rounding(self) -> Mapping[str, float]:
        """Root mean square of what fixed point adds to a value of an axis, where it is known."""
        return {}

    def rounding_without(self, sensor: int) -> Mapping[str, float]:
        """The same while a sensor is lost and what serves in its place is rounded."""
        return self.rounding

    @cached_property
    def told(self) -> tuple[Source, ...]:
        """Sources that errors are told on, but recordings: cases, loads or shapes given, others."""
        return tuple(self._cases[0] + self._others)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What is to be said of the sources, a sentence each."""
        return (*self._cases[1], *(note for source in self.task.sources for note in source.notes))

    @cached_property
    def errors(self) -> tuple[ErrorRow, ...]:
        """Errors on each source, without noise and with everything that is stated.

        Of recordings with real counts those with noise alone.
        """
        simulated = [
            errors_of(source.name, self.missed(source, noise), noise, self.held_out(source))
            for source in self.told
            for noise in (False, True)
        ]
        return (*simulated, *(self.recorded.errors() if self.recorded is not None else ()))

    @cached_property
    def recorded(self) -> RecordedFit | None:
        """What judges the weights on the joint's recordings; None without any."""
        if self.found is None:
            return None
        simulated = [one for one in self.task.sources if not one.name.startswith(RECORDING)]
        return RecordedFit(
            self.recordings, self.whole, simulated, self.method, self.rounding, self.report
        )

    @cached_property
    def whole(self) -> Block:
        """What the weights were fitted to, with nothing held out."""
        return Block(self.found or Recorded(self.joint, ()), self.task, self.weights)

    @property
    def _serving(self) -> str:
        """Method of the weights that serve without a sensor."""
        return self.method if self.method in METHODS else "wam"

    @cached_property
    def without(self) -> tuple[Without, ...]:
        """What each single sensor lost leaves."""
        return tuple(self._without(j) for j in range(len(self.sensed.sensors)))

    @property
    def left(self) -> tuple[tuple[str, ErrorRow | Without], ...]:
        """Errors by the sensor that is lost, on the same shapes; first with none lost."""
        stated = self.stated.name
        intact = next(row for row in self.errors if row.noise and row.source == stated)
        return (("none", intact), *((row.sensor, row) for row in self.without))

    @property
    def stated(self) -> Source:
        """The shapes that say most of the joint: a recording, else its loads, else the cases."""
        order = {OTHER: 3, CASES: 2, LOADS: 1}
        fitted = [one for one in self.task.sources if one.name.startswith(RECORDING)]
        return min([*fitted, *self.told], key=lambda source: order.get(source.name, 0))

    def judged(
        self, choice: Choice | None = None, rounding: Mapping[str, float] | None = None
    ) -> Missed | Pooled:
        """Errors with noise on the shapes that say most of the joint, a recording's held out.

        Args:
            choice: of other weights than those that were fitted.
            rounding: of those on simulated shapes, as `rounding` tells it of the fitted ones.
        """
        if self.recorded is not None:
            names = [one.name for one in self.whole.found.references]
            if self.stated.name in names:
                return self.recorded.judged(names.index(self.stated.name), True, choice)
        weights = self.weights if choice is None else choice(self.whole)
        return self.missed(self.stated, True, weights, rounding)

    @cached_property
    def standard_deviations(self) -> StandardDeviations:
        """Of every estimated value and of the tip, on the shapes that say most of the joint."""
        return standard_deviations(self.judged())

    def held_out(self, source: Source) -> bool:
        """Whether the weights were fitted without that source."""
        return not any(own.name == source.name and own.weight > 0 for own in self.task.sources)

    def missed(
        self,
        source: Source,
        noise: bool,
        weights: Mapping[str, Weights] | None = None,
        rounding: Mapping[str, float] | None = None,
    ) -> Missed:
        """Errors of the weights, or of others in their place, on the shapes of a source."""
        own = self.weights if weights is None else weights
        rounded = self.rounding if rounding is None else rounding
        readings = source.readings
        shapes, known = source.shapes, self.task.noise
        return missed(self.sensed, own, shapes, noise, known, rounded, readings)

    def _readers(self, sensor: int) -> list[str]:
        """Axes that read a sensor."""
        every = range(len(self.sensed.sensors))
        return [axis for axis in self.sensed.axes if sensor in every[self.sensed.own(axis)]]

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
        from ccgen.shapes import within_axes
        from ccgen.shapes.loads.library import other_library

        own = [
            source
            for source in self.task.sources
            if source.name != CASES and not source.name.startswith(RECORDING)
        ]
        return [*own, Source(OTHER, within_axes(self.joint, other_library(self.joint)), 0.0)]

    def fallback(self, axis: str, sensor: int, task: Task | None = None) -> Weights | None:
        """Weights of an axis without a sensor of the joint; None where it is lost without it."""
        task = task or self.task
        key = (axis, sensor, id(task))
        if key not in self._fallbacks:
            first = self.sensed.own(axis).start
            found = fallback(task, axis, self._serving, sensor - first)
            self._fallbacks[key] = task, found
        return self._fallbacks[key][1]

    @cached_property
    def _fallbacks(self) -> dict[tuple[str, int, int], tuple[Task, Weights | None]]:
        """What was found before, with its task, so that no other takes its identity."""
        return {}

    def _without(self, sensor: int) -> Without:
        name, readers = self.sensed.sensors[sensor].name, self._readers(sensor)
        lost = [axis for axis in readers if self.fallback(axis, sensor, self.whole.quick) is None]

        def serving(block: Block) -> Mapping[str, Weights]:
            served = {a: self.fallback(a, sensor, block.quick) for a in readers if a not in lost}
            known = {axis: own for axis, own in served.items() if own is not None}
            return {**block.weights, **known}

        judged = self.judged(serving, self.rounding_without(sensor))
        found = errors_of(name, judged, True, False)
        spread = standard_deviations(judged).axes
        return Without(
            sensor=name,
            rms_deg={a: None if a in lost else rms for a, rms in found.rms_deg.items()},
            elongation_rms_percent=None if "h" in lost else found.elongation_rms_percent,
            tip_rms_m=None if lost else found.tip_rms_m,
            deviations={a: None if a in lost else own for a, own in spread.items()},
        )
