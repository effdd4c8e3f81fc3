"""The question of a placement, and its answer."""

from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ccgen.errors import InputError
from ccgen.estimation import (
    noise_aware,
    score_percent_rom,
    score_with_noise_percent_rom,
    wam,
    wam_matrix,
)
from ccgen.estimation.weights import Weights
from ccgen.joint.layouts import AnySpans
from ccgen.placement.constraints import Constraints
from ccgen.placement.moved import alike, moved
from ccgen.placement.objective import Floats, Indices, ObjectiveModel, objective_model
from ccgen.placement.question import Question, as_spans
from ccgen.sensing.noise import second_moment, told_noise
from ccgen.sensing.readings import readings
from ccgen.shapes import ShapeLibrary, bent_alike, fit_library, score_library

if TYPE_CHECKING:
    from ccgen.joint import Joint

_AT_ONCE = 64
"""Placements whose weights are fitted together."""


@dataclass(frozen=True, eq=False)
class Problem(Question):
    """Where to put the sensors of one bending axis.

    Attributes:
        fit: shapes that weights are fitted to.
        score: shapes that they are scored on.
        sensors: number n of sensors, fixed ones included.
        constraints: what the builder allows.
        noise: standard deviation of a sensor's length over its radius, radians. With 0 the
            objective is the paper's (its cost, eq. 11) with WAM weights, else the expected error
            with noise-aware weights.

    Raises:
        InputError: constraints that make no sense for this joint.
    """

    fit: ShapeLibrary
    score: ShapeLibrary
    sensors: int
    constraints: Constraints = field(default_factory=Constraints)
    noise: float = 0.0

    def __post_init__(self) -> None:
        self.constraints.check(self.segments, self.sensors)

    @property
    def segments(self) -> int:
        """Number m of segments."""
        return int(self.fit.angles.shape[1])

    @property
    def key(self) -> Hashable:
        """Alike for questions about a joint that have the same answer."""
        return self.sensors, self.noise

    @cached_property
    def model(self) -> ObjectiveModel:
        """The libraries, prepared for evaluating whole populations."""
        return objective_model(self.fit, self.score, self.noise)

    @property
    def estimator(self) -> str:
        """The estimation method whose errors placements are judged by."""
        return "noise-aware" if self.noise else "wam"

    @property
    def objective(self) -> str:
        """One of `ccgen.placement.OBJECTIVES`."""
        return "angles" if self.noise else "paper"

    def weights(self, spans: AnySpans) -> Weights:
        """Fit the objective's estimator to one placement."""
        if not self.noise:
            return wam(self.fit, spans)
        return noise_aware(self.fit, spans, self.reading_noise(spans))

    def reading_noise(self, spans: AnySpans) -> Floats:
        """Standard deviation of the normalised readings, shape (n,), radians."""
        return np.array([self.noise / (b - a + 1) for a, b in spans])

    def percent(self, spans: AnySpans) -> float:
        """Objective of one placement in % of the range of motion, by `ccgen.estimation` itself."""
        weights = self.weights(spans)
        if not self.noise:
            return score_percent_rom(weights, self.score)
        noise = self.reading_noise(spans)
        return score_with_noise_percent_rom(weights, self.score, noise)

    def percents(self, spans: Indices) -> Floats:
        """Objective of each placement, weights at the minimum of the soft-L1 loss, shape (P,)."""
        if self.noise:
            return np.array([self.percent(as_spans(one)) for one in spans])
        parts = [self._percents(spans[k : k + _AT_ONCE]) for k in range(0, len(spans), _AT_ONCE)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _percents(self, spans: Indices) -> Floats:
        matrices = wam_matrix(self.fit.angles, spans)
        read = np.moveaxis(readings(self.score.angles, spans), 0, -2)
        errors = np.abs(read @ np.swapaxes(matrices, -1, -2) - self.score.angles)
        result: Floats = 100.0 * errors.mean(axis=(-2, -1)) / self.score.range_of_motion
        return result


@dataclass(frozen=True)
class Placement:
    """Spans found by some method.

    Attributes:
        method: name of the method.
        spans: ordered by first and last segment; of sensors that a file lists, in its order.
        percent: objective in % of the range of motion.
        evaluations: how many placements were evaluated for it.
        optimality: "proven" (no allowed placement is better), "bound" or "none".
        gap: share of the objective between it and a proven lower bound; None without a bound.
    """

    method: str
    spans: AnySpans
    percent: float
    evaluations: int
    optimality: str = "none"
    gap: float | None = None


def joint_problem(
    joint: "Joint",
    axis: str,
    sensors: int,
    constraints: Constraints | None = None,
    with_noise: bool = False,
) -> Problem:
    """Pose the problem for one axis of a user's joint.

    Args:
        joint: the joint.
        axis: "u" or "v".
        sensors: number of sensors to place.
        constraints: what the builder allows.
        with_noise: whether the objective is the expected error under the transducer's noise.

    Raises:
        InputError: a joint whose spans are not free to choose, senseless constraints, or no noise
            stated; ReachError: an unreachable shape.
    """
    check_placeable(joint, axis)
    noise = 0.0
    if with_noise:
        stated = alike(joint, axis, "noise")
        if not stated:
            raise InputError(
                f"{joint.source}: sensors.{axis}.transducer.noise: not stated;"
                " give one standard deviation in metres, or use the paper's objective"
            )
        noise = stated / alike(joint, axis, "radius")
    chosen = constraints or Constraints()
    return Problem(fit_library(joint), score_library(joint), sensors, chosen, noise)


def check_placeable(joint: "Joint", axis: str) -> None:
    """Check that the joint has a set of sensors for this axis, which reads that axis alone.

    Raises:
        InputError: it has none, or leaves the axis out.
    """
    if read_one_by_one(joint):
        raise InputError(
            f"{joint.source}: sensor: its sensors are no sets of one bending axis each; place them "
            "one by one"
        )
    if axis not in joint.axes:
        raise InputError(
            f"{joint.source}: estimator.axes: leaves out {axis}, for which spans are asked; "
            f"choose {' or '.join(a for a in joint.axes if a != 'h')}"
        )


def read_one_by_one(joint: "Joint") -> bool:
    """Whether sensors differ in more than spans and axis: listed, or reading elongation too."""
    return (joint.u is None and joint.v is None) or joint.couples


def placed_noise(
    joint: "Joint", axis: str, spans: AnySpans, library: "ShapeLibrary"
) -> Floats | None:
    """Noise of the readings under which errors are told, if an axis' sensors had other spans.

    Args:
        joint: as `check_placeable` lets pass.
        axis: "u" or "v".
        spans: any number of them.
        library: shapes that tell how far gains are off.

    Returns:
        Shape (n,), radians; None where it is not stated, or differs among the sensors.
    """
    alone = moved(joint, axis, spans)
    if alone is None:
        return None
    bent = bent_alike(library.angles, len(joint.geometry.sections))
    return told_noise(alone, axis, second_moment(bent.state))
