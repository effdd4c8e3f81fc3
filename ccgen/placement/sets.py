"""The paper's sets of sensors: any number of them, alike within an axis but for their spans."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ccgen.joint.layouts import AnySpans
from ccgen.placement.groups import Group, of_one_kind
from ccgen.placement.moved import alike, with_spans
from ccgen.placement.objective import Floats
from ccgen.placement.stated import StatedProblem
from ccgen.sensing.noise import told_noise

if TYPE_CHECKING:
    from ccgen.joint import Joint


@dataclass(frozen=True, eq=False, kw_only=True)
class SetsProblem(StatedProblem):
    """Where to put the sensors of some bending axes, whose spans are the same.

    Attributes:
        axes: those axes.
        sensors: number n of sensors of an axis, fixed ones included.

    Raises:
        InputError: as of `StatedProblem`, or sensors that differ.
    """

    axes: tuple[str, ...]
    sensors: int

    @property
    def key(self) -> Hashable:
        """Alike for questions about a joint that have the same answer."""
        return self.sensors, self.axes

    @property
    def bending(self) -> tuple[str, ...]:
        """The axes."""
        return self.axes

    @cached_property
    def noise(self) -> float:
        """Largest stated noise of a length over its radius, radians; 0 where none is stated."""
        return max(self._stated(axis, "noise") / self._stated(axis, "radius") for axis in self.axes)

    @property
    def noisy(self) -> bool:
        """Whether noise is stated for some axis."""
        return bool(self.noise)

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The set of each axis."""
        return tuple(
            of_one_kind(
                axis,
                self.joint.rows(axis),
                self.sensors,
                self._deviation(axis),
                self._stated(axis, "gain_tolerance"),
            )
            for axis in self.axes
        )

    def at(self, spans: AnySpans) -> "Joint":
        """The joint with its sensors there, and no axes but these."""
        return with_spans(self.joint, dict.fromkeys(self.axes, spans))

    def reading_noise(self, axis: str, spans: AnySpans) -> Floats | None:
        """Noise of normalised readings, tolerances included, (n,), radians; None if not stated."""
        return told_noise(self.at(spans), axis, self.rows.second_moment)

    def _deviation(self, axis: str) -> float:
        """Standard deviation of a length over its radius, the step of counts included, radians."""
        step = self._stated(axis, "metres_per_count") if self.noise else 0.0
        squares = self._stated(axis, "noise") ** 2 + step**2 / 12.0
        return float(np.sqrt(squares) / self._stated(axis, "radius"))

    def _stated(self, axis: str, key: str) -> float:
        return alike(self.joint, axis, key)
