"""The question of a placement where a joint states more than load cases, or the tip is what counts.

Placements are judged by the expected error on the shapes that weights are fitted to, each source
weighed as the joint weighs it, under noise and tolerances: the mean absolute error of a segment's
angle in % of the range of motion, or the root mean square error of the tip in % of the length.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.errors import ErrorRow, errors_of, missed
from ccgen.estimation.fit import Task, fit_task
from ccgen.estimation.folded import folded_mean
from ccgen.estimation.sources import Rows, Source, weighed_rows
from ccgen.joint.layouts import Spans
from ccgen.kinematics import tip_jacobian
from ccgen.placement.constraints import Constraints
from ccgen.placement.moments import AxisMoments, MomentModel
from ccgen.placement.moved import alike, with_spans
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.question import Question
from ccgen.sensing.noise import told_noise

if TYPE_CHECKING:
    from ccgen.joint import Joint

_LEAST = 1e-12
"""Share of a length's variance that keeps equal spans apart."""

_COMPARED = 400
"""Rows of a source by which placements are compared."""


@dataclass(frozen=True, eq=False)
class StatedProblem(Question):
    """Where to put the sensors of some bending axes, by all that the joint states.

    Attributes:
        joint: the joint.
        axes: those whose sensors have the same spans.
        sources: shapes to fit to, each with its weight.
        sensors: number n of sensors of an axis, fixed ones included.
        constraints: what the builder allows.
        by_tip: whether the tip is what counts, or the segments' angles.

    Raises:
        InputError: constraints that make no sense for this joint, or sensors that differ.
    """

    joint: "Joint"
    axes: tuple[str, ...]
    sources: Sequence[Source]
    sensors: int
    constraints: Constraints = field(default_factory=Constraints)
    by_tip: bool = False

    def __post_init__(self) -> None:
        self.constraints.check(self.segments, self.sensors)

    @property
    def segments(self) -> int:
        """Number m of segments."""
        return self.joint.geometry.segments

    @property
    def key(self) -> Hashable:
        """Alike for questions about a joint that have the same answer."""
        return self.sensors, self.axes

    @cached_property
    def noise(self) -> float:
        """Largest stated noise of a length over its radius, radians; 0 where none is stated."""
        return max(self._stated(axis, "noise") / self._stated(axis, "radius") for axis in self.axes)

    @property
    def objective(self) -> str:
        """One of `ccgen.placement.OBJECTIVES`."""
        return "tip" if self.by_tip else "angles"

    @property
    def estimator(self) -> str:
        """The estimation method whose errors placements are judged by."""
        return "noise-aware" if self.noise else "wam"

    @cached_property
    def rows(self) -> Rows:
        """Shapes of all sources that count."""
        return weighed_rows(self.joint, self.sources)

    @cached_property
    def model(self) -> MomentModel:
        """Root mean square errors, which whole populations are evaluated by."""
        axes = [
            AxisMoments.of(self._moment(axis), self._judge(axis), self._deviation(axis), tolerance)
            for axis in self.axes
            for tolerance in [self._stated(axis, "gain_tolerance")]
        ]
        return MomentModel(axes, self._unit)

    def at(self, spans: Spans) -> "Joint":
        """The joint with its sensors there, and no axes but these."""
        return with_spans(self.joint, dict.fromkeys(self.axes, spans))

    def task(self, spans: Spans) -> Task:
        """What the weights of one placement are fitted to."""
        return Task(self.at(spans), self._counted, exact=False)

    def errors(self, spans: Spans) -> list[ErrorRow]:
        """Errors of one placement on each source that counts, without and with noise."""
        task = self.task(spans)
        weights = fit_task(task, self.estimator)
        return [
            errors_of(one.name, missed(task.joint, weights, one.shapes, noise), noise, False)
            for one in self._counted
            for noise in (False, True)
        ]

    def percent(self, spans: Spans) -> float:
        """Objective of one placement in %, by `ccgen.estimation` itself."""
        rows = self.errors(spans)
        if not self.by_tip:
            return self.mean_percent(rows, noise=True)
        squares = [row.tip_rms_m**2 for row in rows if row.noise]
        return float(100.0 * np.sqrt(np.average(squares, weights=self._shares)) / self._length)

    def mean_percent(self, rows: Sequence[ErrorRow], noise: bool) -> float:
        """Mean error of a segment's angle over all sources, % of the range of motion.

        Args:
            rows: what `errors` gave.
            noise: whether noise is part of it.
        """
        means = [
            np.mean([row.mean_percent_rom[axis] for axis in self.axes])
            for row in rows
            if row.noise == noise
        ]
        return float(np.average(means, weights=self._shares))

    def reading_noise(self, axis: str, spans: Spans) -> Floats | None:
        """Noise of normalised readings, tolerances included, (n,), radians; None if not stated."""
        moved = self.at(spans)
        return told_noise(moved, axis, self.rows.second_moment)

    def percents(self, spans: Indices) -> Floats:
        """Objective of each placement in %, shape (P,).

        Weights follow from second moments, the tip from its Jacobian, and errors are those of
        evenly chosen rows where there are many.
        """
        return np.array([self._percent(one) for one in spans])

    def _percent(self, spans: Indices) -> float:
        errors, spreads = [], []
        for axis in self.axes:
            known, spread = self._missed(axis, spans)
            errors.append(known)
            spreads.append(spread)
        weight = self._judges.weight
        if not self.by_tip:
            unit = 100.0 / self.joint.geometry.range_of_motion
            means = [
                folded_mean(known, np.sqrt(np.square(spread).sum(axis=1))).mean(axis=1)
                for known, spread in zip(errors, spreads, strict=True)
            ]
            return float(unit * np.mean(means, axis=0) @ weight)
        squares = np.zeros(len(weight))
        moved = np.zeros((len(weight), 3))
        for axis, known, spread in zip(self.axes, errors, spreads, strict=True):
            J = self._jacobian[..., self.joint.rows(axis)]
            moved += np.einsum("nkm,nm->nk", J, known)
            squares += np.square(np.einsum("nkm,njm->njk", J, spread)).sum(axis=(1, 2))
        squares += np.square(moved).sum(axis=1)
        return float(100.0 * np.sqrt(squares @ weight) / self._length)

    def _missed(self, axis: str, spans: Indices) -> tuple[Floats, Floats]:
        """Errors without noise, shape (N, m), and by each sensor's noise, (N, n, m), radians."""
        x = self._judges.state[:, self.joint.rows(axis)]
        H = _covers(spans, self.segments)
        C = self._moment(axis)
        variance = self._deviation(axis) ** 2
        tolerance = self._stated(axis, "gain_tolerance") ** 2
        clean = H @ C @ H.T
        noise = np.diag(variance + (tolerance + _LEAST) * np.diag(clean))
        gain = np.linalg.solve(clean + noise, H @ C)
        read = x @ H.T
        deviation = np.sqrt(variance + tolerance * np.square(read))
        return read @ gain - x, deviation[:, :, None] * gain

    @cached_property
    def _counted(self) -> list[Source]:
        """Sources that count, as ideal sensors anywhere would read them."""
        return [
            Source(one.name, one.shapes, one.weight)
            for one in self.sources
            if one.weight > 0 and len(one)
        ]

    @cached_property
    def _moments(self) -> Floats:
        return self.rows.second_moment

    @cached_property
    def _judges(self) -> Rows:
        """Rows by which placements are compared."""
        thinned = [one.at_most(_COMPARED) for one in self._counted]
        return weighed_rows(self.joint, thinned)

    @property
    def _shares(self) -> list[float]:
        return [one.weight for one in self._counted]

    @property
    def _length(self) -> float:
        return self.joint.geometry.length

    @property
    def _unit(self) -> float:
        """What root mean square errors of all axes together are told in."""
        geometry = self.joint.geometry
        count = np.sqrt(self.segments * len(self.axes))
        return geometry.length if self.by_tip else float(geometry.range_of_motion * count)

    def _moment(self, axis: str) -> Floats:
        own = self.joint.rows(axis)
        return np.asarray(self._moments[own, own])

    def _judge(self, axis: str) -> Floats:
        """How errors of the segments count together, shape (m, m)."""
        if not self.by_tip:
            return np.eye(self.segments)
        J = self._jacobian[..., self.joint.rows(axis)]
        weight = self._judges.weight
        return np.asarray(np.einsum("nka,nkb,n->ab", J, J, weight, optimize=True))

    def _deviation(self, axis: str) -> float:
        """Standard deviation of a length over its radius, the step of counts included, radians."""
        step = self._stated(axis, "metres_per_count") if self.noise else 0.0
        squares = self._stated(axis, "noise") ** 2 + step**2 / 12.0
        return float(np.sqrt(squares) / self._stated(axis, "radius"))

    def _stated(self, axis: str, key: str) -> float:
        return alike(self.joint, axis, key)

    @cached_property
    def _jacobian(self) -> Floats:
        """Of the tip's place by the bends of rows, shape (N, 3, 2m), metres."""
        state, m = self._judges.state, self.segments
        length = self.joint.geometry.segment_length
        return tip_jacobian(state[:, :m], state[:, m : 2 * m], length)[:, :3]


def _covers(spans: Indices, segments: int) -> Floats:
    """1 where a sensor covers a segment, shape (n, m)."""
    at = np.arange(segments)
    inside = (at >= spans[:, :1]) & (at <= spans[:, 1:])
    return inside.astype(np.float64)
