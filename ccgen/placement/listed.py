"""Sensors that a joint file lists one by one: each keeps its angle, radius and transducer."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ccgen.errors import ArgumentError, InputError
from ccgen.estimation.coupled import spans_of
from ccgen.joint import AXES
from ccgen.joint.layouts import AnySpans, Span, spans_for
from ccgen.joint.places import own_place
from ccgen.placement.constraints import Constraints
from ccgen.placement.groups import Group
from ccgen.placement.methods import STATED
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.slots import UNSEEN, Slots
from ccgen.placement.stated import StatedProblem
from ccgen.sensing.arrangement import angle_degrees
from ccgen.sensing.noise import length_variance, stated_noise
from ccgen.sensing.readings import direction, normaliser

if TYPE_CHECKING:
    from ccgen.joint import Joint, Sensor


@dataclass(frozen=True, eq=False, kw_only=True)
class ListedProblem(StatedProblem):
    """Where to put each of a joint's sensors, by all that the joint states.

    The span of sensor j stands at place j of a placement.

    Attributes:
        sensors: number n of the joint's sensors.
        held: spans of those that stay, by their numbers.

    Raises:
        InputError: as of `StatedProblem`, noise that is stated of some sensors only, or no sensor
            of a name that is to stay.
    """

    sensors: int = field(init=False)
    held: dict[int, Span] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sensors", len(self.joint.sensors))
        super().__post_init__()
        _check_noise(self.joint)
        object.__setattr__(self, "held", _staying(self.joint, self.constraints))

    @property
    def key(self) -> Hashable:
        """Alike for questions about a joint that have the same answer."""
        return "listed"

    @property
    def bending(self) -> tuple[str, ...]:
        """The joint's bending axes."""
        return tuple(axis for axis in AXES if axis in self.joint.axes)

    @cached_property
    def noisy(self) -> bool:
        """Whether noise is stated, and is above zero somewhere."""
        noise = stated_noise(self.joint)
        return noise is not None and bool(noise.any())

    @cached_property
    def slots(self) -> Slots:
        """Sensors of one angle, radius and transducer may swap spans, unless one of them stays."""
        sensors = self.joint.sensors
        directions = [self._direction(sensor) for sensor in sensors]
        seen = _numbered([one for one in directions if one is not None])
        return Slots(
            kinds=_numbers(
                [(self._kind(s), j if j in self.held else None) for j, s in enumerate(sensors)]
            ),
            sides=_numbers([angle_degrees(sensor) for sensor in sensors]),
            directions=np.array(
                [UNSEEN if one is None else seen[one] for one in directions], dtype=np.intp
            ),
            needed=len(self.bending),
            held=self.held,
        )

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The sensors by what is read together: all of them where any tells of two axes."""
        axes: dict[tuple[int, int], list[str]] = {}
        for axis, part in zip(self.joint.axes, self.joint.parts, strict=True):
            axes.setdefault(part, []).append(axis)
        return tuple(self._group(slice(*part), own, len(axes) == 1) for part, own in axes.items())

    @property
    def layouts(self) -> tuple[str, ...]:
        """Names of placements that need no search."""
        return (STATED, "end-to-end", "heuristic")

    def laid_out(self, layout: str) -> AnySpans:
        """Spans as the joint file has them, or a layout of the sensors at each angle.

        Raises:
            InputError: it does not fit the sensors.
        """
        if layout == STATED:
            return spans_of(self.joint.sensors)
        spans: dict[int, Span] = {}
        for side in np.unique(self.slots.sides):
            own = np.flatnonzero(self.slots.sides == side)
            if layout == "single" and len(own) > 1:
                raise InputError(f"the layout single has 1 sensor at an angle, not {len(own)}")
            try:
                laid = spans_for(layout, self.segments, len(own))
            except ValueError as error:
                raise InputError(str(error)) from error
            spans.update(zip(own.tolist(), laid, strict=True))
        return tuple(self.held.get(j, spans[j]) for j in range(self.sensors))

    def allows(self, spans: AnySpans) -> bool:
        """Whether a placement keeps to every constraint.

        Spans with parts of segments, which only the file can have, keep to no limit.
        """
        if not _whole(spans):
            return self.constraints == Constraints(staying=self.constraints.staying)
        return not self.violations(np.array(spans, dtype=np.intp)[None])[0]

    def at(self, spans: AnySpans) -> "Joint":
        """The joint with its sensors there."""
        sensors = tuple(
            replace(sensor, start=float(first), end=last + 1.0)
            for sensor, (first, last) in zip(self.joint.sensors, spans, strict=True)
        )
        return replace(self.joint, sensors=sensors)

    def reading_noise(self, spans: AnySpans) -> Floats | None:
        """Noise of normalised readings, tolerances included, (n,), radians; None if not stated."""
        if not self.noisy:
            return None
        there = self.at(spans)
        return np.sqrt(length_variance(there, self.rows.second_moment)) / normaliser(there)

    def _group(self, slots: slice, axes: Sequence[str], everything: bool) -> Group:
        """The sensors of these slots, which estimate these axes."""
        joint, m = self.joint, self.segments
        sections = joint.geometry.sections
        whole = 2 * m + len(sections)
        rows = slice(0, whole) if everything else joint.rows(axes[0])
        own = joint.sensors[slots]
        kinds = _numbers([self._kind(sensor) for sensor in own])
        likes = [own[int(np.flatnonzero(kinds == kind)[0])] for kind in range(kinds.max() + 1)]
        estimated = np.zeros(whole, dtype=bool)
        for axis in axes:
            estimated[joint.rows(axis)] = True
        stretched = joint.geometry.segment_length * np.repeat(
            np.eye(len(sections)), sections, axis=0
        )
        patterns = [
            np.hstack([sine * np.eye(m), -cosine * np.eye(m), stretched / like.radius])
            for like in likes
            for sine, cosine in [direction(like)]
        ]
        return Group(
            axes={
                axis: slice(joint.rows(axis).start - rows.start, joint.rows(axis).stop - rows.start)
                for axis in axes
            },
            slots=slots,
            rows=rows,
            estimated=estimated[rows],
            kinds=kinds,
            patterns=np.array(patterns)[..., rows],
            deviation=np.array([self._deviation(like) for like in likes]),
            tolerance=np.array([like.gain_tolerance for like in likes]),
        )

    def _kind(self, sensor: "Sensor") -> Hashable:
        return (
            angle_degrees(sensor),
            sensor.radius,
            self._deviation(sensor),
            sensor.gain_tolerance,
        )

    def _deviation(self, sensor: "Sensor") -> float:
        """Standard deviation of a length over its radius, the step of counts included, radians."""
        step = sensor.metres_per_count if self.noisy else 0.0
        return float(np.sqrt((sensor.noise or 0.0) ** 2 + step**2 / 12.0) / sensor.radius)

    def _direction(self, sensor: "Sensor") -> Hashable | None:
        """What tells directions of bending apart that sensors read; None where it reads none."""
        if len(self.bending) == len(AXES):
            return round(angle_degrees(sensor) % 180.0, 6)
        sine, cosine = direction(sensor)
        return "read" if (sine if "u" in self.bending else cosine) else None


def _check_noise(joint: "Joint") -> None:
    """Check that noise is stated of all sensors or of none.

    Raises:
        InputError: it is not.
    """
    silent = [j for j, sensor in enumerate(joint.sensors) if sensor.noise is None]
    if silent and len(silent) < len(joint.sensors):
        raise InputError(
            f"{joint.source}: {own_place(joint, silent[0], 'noise')}: not stated, but other "
            "sensors state theirs; give one standard deviation in metres for each"
        )


def _staying(joint: "Joint", constraints: Constraints) -> dict[int, Span]:
    """Spans of sensors that stay, by their numbers.

    Raises:
        ArgumentError: a name that no sensor has, or a span with parts of segments.
    """
    names = [sensor.name for sensor in joint.sensors]
    held = {}
    for name in constraints.staying:
        if name not in names:
            raise ArgumentError(
                f"no sensor is called {name!r}; give {' or '.join(names)}", "staying"
            )
        j = names.index(name)
        (span,) = spans_of([joint.sensors[j]])
        if not _whole([span]):
            raise ArgumentError(
                f"the span of {name} ends within a segment, while spans are chosen by whole ones; "
                "give it whole segments in the joint file",
                "staying",
            )
        held[j] = int(span[0]), int(span[1])
    return held


def _whole(spans: Sequence[tuple[float, float]]) -> bool:
    return all(float(end).is_integer() for span in spans for end in span)


def _numbered(values: Sequence[Hashable]) -> dict[Hashable, int]:
    """Numbers from 0 for different values, in the order in which they come."""
    return {value: number for number, value in enumerate(dict.fromkeys(values))}


def _numbers(values: Sequence[Hashable]) -> Indices:
    numbered = _numbered(values)
    return np.array([numbered[value] for value in values], dtype=np.intp)
