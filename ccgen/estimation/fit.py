"""From a method's name, or a whole joint, to weights."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.double_double import DoubleDouble, matmul
from ccgen.errors import InputError
from ccgen.estimation.coupled import local, spans_of
from ccgen.estimation.minimum import minimum
from ccgen.estimation.noise_aware import gain, noise_aware
from ccgen.estimation.simple import direct, equal
from ccgen.estimation.soft_l1 import minimise
from ccgen.estimation.sources import Rows, Source, simulated_sources, weighed_rows
from ccgen.estimation.wam import F_SCALE, wam, wam_paper_call
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.noise import length_variance, stated_noise
from ccgen.sensing.readings import (
    exact_readings,
    length_changes,
    normalised_response,
    normaliser,
)
from ccgen.shapes import axis_library, joined
from ccgen.shapes.given import GIVEN

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import ShapeLibrary, Shapes

Integers = NDArray[np.intp]

_MOST_EXACT = 4000
"""Rows up to which weights are solved beyond double precision."""

FIT_METHODS = ("direct", "equal", "wam", "noise-aware", "wam-paper-call")


def fit_weights(
    method: str, library: "ShapeLibrary", spans: AnySpans, noise_rad: ArrayLike | None = None
) -> Weights:
    """Weights by the method of that name, one of `FIT_METHODS`, for the paper's set of an axis.

    Args:
        method: its name.
        library: shapes to fit.
        spans: the n sensors' spans.
        noise_rad: noise of the normalised readings, shape (n,), radians; "noise-aware" needs it.

    Raises:
        InputError: unknown method, spans that the method cannot use, or noise not given.
    """
    segments = library.angles.shape[1]
    if method == "direct":
        return direct(segments, spans)
    if method == "equal":
        return equal(segments, spans)
    if method == "wam":
        return wam(library, spans)
    if method == "wam-paper-call":
        return wam_paper_call(library, spans)
    if method != "noise-aware":
        raise InputError(f"unknown method {method!r}; give one of {', '.join(FIT_METHODS)}")
    if noise_rad is None:
        raise InputError(_NO_NOISE)
    return noise_aware(library, spans, noise_rad)


_NO_NOISE = (
    '"noise-aware" needs the noise of the readings; state sensors.transducer.noise '
    '(metres, one standard deviation) or use "wam"'
)


@dataclass(frozen=True, eq=False)
class Task:
    """What weights of a joint are fitted to.

    Attributes:
        joint: the joint.
        sources: shapes to fit to, each with its weight.
        noise: of all lengths where it is known better than the joint states, quantisation
            included, shape (n,), metres, one standard deviation.
        exact: whether the weights' last bits count, as far as they may.
        general: whether the paper's sets are taken for sensors that may read any axis.
    """

    joint: "Joint"
    sources: Sequence[Source]
    noise: Floats | None = None
    exact: bool = True
    general: bool = False

    @cached_property
    def rows(self) -> Rows:
        """All rows that count."""
        return weighed_rows(self.joint, self.sources)

    @cached_property
    def moments(self) -> Rows:
        """Rows of the shapes' second moments, with readings without noise."""
        if all(source.readings is None and source.moment is None for source in self.sources):
            return self.rows
        return weighed_rows(self.joint, [source.spread for source in self.sources])

    @cached_property
    def deviation(self) -> Floats:
        """Standard deviation of each normalised reading, shape (n,).

        Raises:
            InputError: a noise that is not known.
        """
        noise = _noise(self.joint, self.moments) if self.noise is None else self.noise
        return np.asarray(noise / normaliser(self.joint))

    def readings(
        self, rows: Rows, axis: str, sensors: Integers, divisor: float = 1.0
    ) -> Floats | DoubleDouble:
        """Readings of some sensors of `rows` or `moments` over a divisor, shape (N, k).

        In twice the precision where bits count.
        """
        joint = self.joint
        counted = [source for source in self.sources if source.weight > 0]
        ideal = len(counted) == 1 and counted[0].readings is None
        if not (self.exact and ideal and len(rows.state) <= _MOST_EXACT):
            return rows.readings[:, sensors] / divisor
        state = rows.state / divisor
        if in_the_papers_way(joint) and not self.general:
            spans = spans_of([joint.sensors[j] for j in sensors])
            return exact_readings(state[:, joint.rows(axis)], spans)
        return matmul(state, normalised_response(joint)[sensors].T)


def weights_of(task: Task, axis: str, method: str, missing: int | None = None) -> Weights:
    """Weights of one output axis.

    Args:
        task: what they are fitted to.
        axis: of the joint's.
        method: "direct", "equal", "wam" or "noise-aware".
        missing: a sensor, by its number in the joint, that gives no reading: its column is zero.
            Where a method without a fit has no reading left for a segment, "wam" takes its place.

    Raises:
        InputError: naming the joint's file and the axis: a method that cannot use its sensors, or
            needs a noise that is not stated.
    """
    try:
        return _fitted(task, axis, method, missing)
    except InputError as error:
        where = f"{task.joint.source}: estimator.method: axis {axis}"
        raise InputError(f"{where}: {error}") from error


def in_the_papers_way(joint: "Joint") -> bool:
    """Whether each axis has a set of the paper's kind: whole segments, read by nothing else."""
    sets = [one for one in (joint.u, joint.v) if one is not None]
    whole = all(isinstance(end, int) for one in sets for span in one.spans for end in span)
    return bool(sets) and whole and not joint.couples


def _fitted(task: Task, axis: str, method: str, missing: int | None) -> Weights:
    joint = task.joint
    own = np.arange(*joint.own(axis).indices(len(joint.sensors)))
    spans = spans_of(joint.sensors[joint.own(axis)])
    if method in ("direct", "equal"):
        if missing is None:
            return _without_fit(task, axis, method, spans)
        method = "wam"
    sensors = own[own != missing]
    targets = task.rows.state[:, joint.rows(axis)]
    matrix = np.zeros((targets.shape[1], len(own)))
    if not len(sensors):
        return without_intercept(method, spans, matrix)
    if method == "wam":
        readings = task.readings(task.rows, axis, sensors)
        found = _least_soft_l1(readings, targets, task.rows.weight)
    elif method == "noise-aware":
        found = _least_mean_square(task, axis, sensors)
    else:
        raise InputError(f"unknown method {method!r}; give one of {', '.join(FIT_METHODS[:-1])}")
    matrix[:, sensors - own[0]] = found
    return without_intercept(method, spans, matrix)


def _without_fit(task: Task, axis: str, method: str, spans: AnySpans) -> Weights:
    joint = task.joint
    if in_the_papers_way(joint) and not task.general:
        return (direct if method == "direct" else equal)(joint.geometry.segments, spans)
    return without_intercept(method, spans, local(joint, axis, method))


def _least_soft_l1(readings: Floats | DoubleDouble, targets: Floats, weight: Floats) -> Floats:
    if isinstance(readings, DoubleDouble):
        return minimum(readings, targets, F_SCALE)
    readings, targets, weight = _complete(readings, targets, weight)
    root = np.sqrt(weight / weight.max())
    return minimise(readings * root[:, None], targets * root[:, None], F_SCALE * root)


def _least_mean_square(task: Task, axis: str, sensors: Integers) -> Floats:
    rows = task.moments
    noise, weight = task.deviation[sensors], rows.weight
    targets, root = rows.state[:, task.joint.rows(axis)], np.sqrt(len(weight))
    readings = task.readings(rows, axis, sensors, root)
    if isinstance(readings, DoubleDouble):
        return gain(targets / root, readings, noise)
    readings, targets, weight = _complete(readings, targets / root, weight)
    scale = np.sqrt(weight / weight.sum())[:, None] * root
    system = np.vstack([readings * scale, np.diag(noise)])
    wanted = np.vstack([targets * scale, np.zeros((noise.size, targets.shape[1]))])
    matrix: Floats = np.linalg.lstsq(system, wanted, rcond=None)[0].T
    return matrix


def _complete(readings: Floats, targets: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Rows in which no sensor of the axis lacks its reading."""
    there = ~np.isnan(readings).any(axis=1)
    if there.all():
        return readings, targets, weight
    if not there.any():
        raise InputError("no row has a reading of every sensor; record all sensors together")
    return readings[there], targets[there], weight[there]


def _noise(joint: "Joint", rows: Rows) -> Floats:
    """Standard deviation of each length, shape (n,), metres: noise, counting and tolerance.

    The paper's sets with gains that are known weigh by the stated noise alone: counting adds too
    little to it to be worth weights that differ in their last bits.
    """
    stated = stated_noise(joint)
    if stated is None:
        raise InputError(_NO_NOISE)
    tolerance = np.array([sensor.gain_tolerance for sensor in joint.sensors])
    if in_the_papers_way(joint) and not tolerance.any():
        return stated
    variance = length_variance(joint)
    if tolerance.any():
        # Summed exactly: the weights' bits depend on it.
        weighed = rows.weight[:, None] * np.square(length_changes(joint, rows.state))
        variance = variance + np.square(tolerance) * [math.fsum(column) for column in weighed.T]
    return np.sqrt(variance)


def fit_joint(
    joint: "Joint", method: str | None = None, shapes: "Shapes | None" = None
) -> dict[str, Weights]:
    """Weights of each output axis, under its name.

    Args:
        joint: the joint.
        method: instead of the joint's own.
        shapes: to fit instead of what the joint states.

    Raises:
        InputError: as `weights_of`; ReachError: a shape that no load reaches.
    """
    if shapes is None and joint.recordings:
        # Weights that left them out in silence would be told as the recorded joint's.
        raise InputError(f"{joint.source}: recordings: are not read here; give shapes")
    sources = simulated_sources(joint) if shapes is None else [Source(GIVEN, shapes, 1.0)]
    return fit_task(Task(joint, sources), method)


def fit_axis(joint: "Joint", axis: str, method: str, shapes: "Shapes") -> Weights:
    """Weights of one output axis, fitted to shapes that count alike.

    Raises:
        InputError: as `weights_of`.
    """
    return weights_of(Task(joint, [Source(GIVEN, shapes, 1.0)]), axis, method)


def fit_task(task: Task, method: str | None = None) -> dict[str, Weights]:
    """Weights of each output axis.

    Args:
        task: what they are fitted to.
        method: instead of the joint's own.

    Raises:
        InputError: as `weights_of`.
    """
    joint, method = task.joint, method or task.joint.method
    if method == "wam-paper-call" and in_the_papers_way(joint):
        return {axis: _paper_call(task, axis) for axis in joint.axes}
    return {axis: weights_of(task, axis, method) for axis in joint.axes}


def fit_coupled(joint: "Joint", axis: str, method: str, shapes: "Shapes") -> Weights:
    """Weights of one axis, whatever its sensors read: one matrix H for the whole state.

    With states x = (u, v, h) and normalised readings y = H x + e, the axis is fitted to all sensors
    that it reads.

    Args:
        joint: its sensors.
        axis: "u", "v" or "h".
        method: "direct", "equal", "wam" or "noise-aware".
        shapes: to fit to.

    Raises:
        InputError: unknown method, sensors that it cannot use, or noise not stated.
    """
    return _fitted(Task(joint, [Source(GIVEN, shapes, 1.0)], general=True), axis, method, None)


def _paper_call(task: Task, axis: str) -> Weights:
    shapes = joined([source.shapes for source in task.sources if source.weight > 0])
    library = axis_library(shapes, axis, task.joint.geometry.range_of_motion)
    return wam_paper_call(library, spans_of(task.joint.sensors[task.joint.own(axis)]))
