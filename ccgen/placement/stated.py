"""The question of a placement where a joint states more than load cases, or the tip is what counts.

Placements are judged by the expected error on the shapes that weights are fitted to, each source
weighed as the joint weighs it, under noise and tolerances: the mean absolute error of a segment's
angle in % of the range of motion, or the root mean square error of the tip in % of the length.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.errors import ErrorRow, errors_of, missed, tip_changes
from ccgen.estimation.fit import Task, fit_task
from ccgen.estimation.folded import folded_mean
from ccgen.estimation.sources import Rows, Source, weighed_rows
from ccgen.joint.layouts import AnySpans
from ccgen.kinematics import tip_jacobian
from ccgen.placement.constraints import Constraints
from ccgen.placement.groups import Group
from ccgen.placement.moments import GroupMoments, MomentModel
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.question import Question

if TYPE_CHECKING:
    from ccgen.joint import Joint

_LEAST = 1e-12
"""Share of a length's variance that keeps equal spans apart."""

_COMPARED = 400
"""Rows of a source by which placements are compared."""


@dataclass(frozen=True, eq=False, kw_only=True)
class StatedProblem(Question):
    """Where to put sensors, by all that the joint states.

    Attributes:
        joint: the joint.
        sources: shapes to fit to, each with its weight.
        constraints: what the builder allows.
        by_tip: whether the tip is what counts, or the segments' angles.

    Raises:
        InputError: constraints that make no sense for this joint.
    """

    joint: "Joint"
    sources: Sequence[Source]
    constraints: Constraints = field(default_factory=Constraints)
    by_tip: bool = False

    def __post_init__(self) -> None:
        self.constraints.check(self.segments, self.sensors)

    @property
    def segments(self) -> int:
        """Number m of segments."""
        return self.joint.geometry.segments

    @property
    @abstractmethod
    def bending(self) -> tuple[str, ...]:
        """Bending axes whose errors count."""

    @property
    @abstractmethod
    def noisy(self) -> bool:
        """Whether noise is stated."""

    @cached_property
    @abstractmethod
    def groups(self) -> tuple[Group, ...]:
        """The sensors, by what is read together."""

    @abstractmethod
    def at(self, spans: AnySpans) -> "Joint":
        """The joint with its sensors there."""

    @property
    def objective(self) -> str:
        """One of `ccgen.placement.OBJECTIVES`."""
        return "tip" if self.by_tip else "angles"

    @property
    def estimator(self) -> str:
        """The estimation method whose errors placements are judged by."""
        return "noise-aware" if self.noisy else "wam"

    @cached_property
    def rows(self) -> Rows:
        """Shapes of all sources that count."""
        return weighed_rows(self.joint, self.sources)

    @cached_property
    def model(self) -> MomentModel:
        """Root mean square errors, which whole populations are evaluated by."""
        parts = [
            GroupMoments.of(group, self._moment(group), self._judge(group)) for group in self.groups
        ]
        return MomentModel(parts, self._unit)

    def task(self, spans: AnySpans) -> Task:
        """What the weights of one placement are fitted to."""
        return Task(self.at(spans), self._counted, exact=False)

    def errors(self, spans: AnySpans) -> list[ErrorRow]:
        """Errors of one placement on each source that counts, without and with noise."""
        task = self.task(spans)
        weights = fit_task(task, self.estimator)
        return [
            errors_of(one.name, missed(task.joint, weights, one.shapes, noise), noise, False)
            for one in self._counted
            for noise in (False, True)
        ]

    def percent(self, spans: AnySpans) -> float:
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
            np.mean([row.mean_percent_rom[axis] for axis in self.bending])
            for row in rows
            if row.noise == noise
        ]
        return float(np.average(means, weights=self._shares))

    def percents(self, spans: Indices) -> Floats:
        """Objective of each placement in %, shape (P,).

        Weights follow from second moments, the tip from its Jacobian, and errors are those of
        evenly chosen rows where there are many.
        """
        return np.array([self._percent(one) for one in spans])

    def _percent(self, spans: Indices) -> float:
        found = [(group, *self._missed(group, spans[group.slots])) for group in self.groups]
        weight = self._judges.weight
        if not self.by_tip:
            unit = 100.0 / self.joint.geometry.range_of_motion
            means = [
                folded_mean(known[:, part], np.sqrt(np.square(spread[..., part]).sum(axis=1))).mean(
                    axis=1
                )
                for group, known, spread in found
                for axis, part in group.axes.items()
                if axis in self.bending
            ]
            return float(unit * np.mean(means, axis=0) @ weight)
        squares = np.zeros(len(weight))
        moved = np.zeros((len(weight), 3))
        for group, known, spread in found:
            J = self._jacobian[..., group.rows]
            moved += np.einsum("nkm,nm->nk", J, known)
            squares += np.square(np.einsum("nkm,njm->njk", J, spread)).sum(axis=(1, 2))
        squares += np.square(moved).sum(axis=1)
        return float(100.0 * np.sqrt(squares @ weight) / self._length)

    def _missed(self, group: Group, spans: Indices) -> tuple[Floats, Floats]:
        """Errors without noise, shape (N, R), and by each sensor's noise, (N, n, R)."""
        x = self._judges.state[:, group.rows]
        H = group.response(spans)
        C = self._moment(group)
        variance = np.square(group.deviation)[group.kinds]
        tolerance = np.square(group.tolerance)[group.kinds]
        clean = H @ C @ H.T
        noise = np.diag(variance + (tolerance + _LEAST) * np.diag(clean))
        gain = np.linalg.solve(clean + noise, H @ C)
        gain[:, ~group.estimated] = 0.0
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
        count = np.sqrt(self.segments * len(self.bending))
        return geometry.length if self.by_tip else float(geometry.range_of_motion * count)

    def _moment(self, group: Group) -> Floats:
        return np.asarray(self._moments[group.rows, group.rows])

    def _judge(self, group: Group) -> Floats:
        """How errors of the rows that a group reads count together, shape (R, R)."""
        if not self.by_tip:
            counted = np.zeros(len(group.estimated))
            for axis, part in group.axes.items():
                counted[part] = axis in self.bending
            return np.diag(counted)
        J = self._jacobian[..., group.rows]
        weight = self._judges.weight
        return np.asarray(np.einsum("nka,nkb,n->ab", J, J, weight, optimize=True))

    @cached_property
    def _jacobian(self) -> Floats:
        """Of the tip's place by the states of rows, shape (N, 3, 2m + S), metres."""
        state, m = self._judges.state, self.segments
        lengths = self.joint.geometry.segment_length * (1.0 + self._stretch(state))
        bends = tip_jacobian(state[:, :m], state[:, m : 2 * m], lengths)[:, :3]
        return np.concatenate([bends, tip_changes(self.joint, state)[..., 2 * m :]], axis=-1)

    def _stretch(self, state: Floats) -> Floats:
        """Elongation of each segment, shape (N, m)."""
        return np.repeat(state[:, 2 * self.segments :], self.joint.geometry.sections, axis=1)
