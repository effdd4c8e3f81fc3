"""A fitted joint: its weights with all that follows from them, in floats and in integers."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ccgen.errors import ArgumentError, FormatError, InputError
from ccgen.estimation import FIT_METHODS
from ccgen.estimation.advice import advice
from ccgen.estimation.estimate import Estimate, estimate
from ccgen.estimation.fit import Task, fit_task
from ccgen.estimation.fitted import FittedWeights
from ccgen.estimation.recorded import recorded
from ccgen.estimation.sources import Source, simulated_sources, still_axes
from ccgen.estimation.weights import Weights
from ccgen.fixedpoint.advice import fixed_point_advice
from ccgen.fixedpoint.bounds import rms
from ccgen.fixedpoint.fallback import served
from ccgen.fixedpoint.formats import quantise
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.joint_checks import JointChecks, joint_checks
from ccgen.fixedpoint.model import FixedPointModel, Floats
from ccgen.fixedpoint.ranges import at_range, count_gains
from ccgen.fixedpoint.serving import ServedAxis, quantise_with_fallbacks
from ccgen.joint import AXES, Joint, Sensor
from ccgen.joint.units import unit_doubts
from ccgen.recordings.progress import Report, in_silence
from ccgen.sensing.counts import counts_of, nominal_zero
from ccgen.sensing.noise import second_moment, told_noise
from ccgen.shapes import Shapes, joined
from ccgen.shapes.given import given_shapes, reach

if TYPE_CHECKING:
    from ccgen.fixedpoint.jacobian import JacobianModel
    from ccgen.fixedpoint.pose import PoseModel


@dataclass(frozen=True, eq=False)
class Fit(FittedWeights):
    """What was fitted to a joint, and what is exported of it.

    Attributes:
        joint: the joint, as its file has it.
        method: name of the estimation method.
        weights: by output axis; they apply to normalised readings, (l - l0) / (r p).
        task: the sources of shapes that the weights were fitted to, and how much each counts.
    """

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """The joint's, with the gains and zeros that the estimate uses.

        A zero that nothing states is that of the model: 0, or for counts that are never negative
        their middle, or what is nearest to it with counts for the range of motion.
        """
        sensors = self.sensed.sensors
        zeros = [nominal_zero(sensor) for sensor in sensors]
        if any(sensor.zero is None for sensor in sensors):
            with suppress(FormatError):  # no format holds the joint: its zeros stay nominal
                zeros = self.plain.readings.zero.tolist()
        return tuple(
            sensor if sensor.zero is not None else replace(sensor, zero=zero)
            for sensor, zero in zip(sensors, zeros, strict=True)
        )

    @cached_property
    def shapes(self) -> Shapes:
        """The rows that the weights were fitted to."""
        return joined([source.shapes for source in self.task.sources if source.weight > 0])

    @cached_property
    def model(self) -> FixedPointModel:
        """The integer reference model, in formats that its fallbacks share.

        Its axes are those of `plain`, with a coarser shift where a fallback needs larger weights.

        Raises:
            FormatError: as of `plain`.
        """
        if not self.sensed.fallback:
            return self.plain
        return replace(self.plain, axes={axis: one.model for axis, one in self._served.items()})

    @cached_property
    def plain(self) -> FixedPointModel:
        """The integer model of the weights alone.

        Its formats hold the shapes; where those are not the joint's own load cases, or where axes
        meet in a sensor, also the joint at its range of motion in all axes at once.

        Raises:
            FormatError: no format fits; names the sensor, the key and the remedy.
        """
        return quantise(self.sensed, self.weights, self._held)

    @cached_property
    def poses(self) -> "PoseModel":
        """Poses in integers, of the angles that `model` has.

        Raises:
            FormatError: as of `model`, or the angles reach too far for poses of 32 bits.
        """
        from ccgen.fixedpoint.pose_plan import closest_poses, pose_task

        task = pose_task(self.sensed, self.model, self._held)
        try:
            return closest_poses(task)
        except FormatError as error:
            raise FormatError(f"{self.joint.source}: geometry.range_of_motion: {error}") from None

    @cached_property
    def jacobian(self) -> "JacobianModel":
        """The tip Jacobian in integers, of the angles that `model` has.

        Raises:
            FormatError: as of `poses`.
        """
        from ccgen.fixedpoint.jacobian_plan import jacobian_model

        poses = self.poses
        try:
            return jacobian_model(poses)
        except FormatError as error:
            raise FormatError(f"{self.joint.source}: geometry.range_of_motion: {error}") from None

    @cached_property
    def guarded(self) -> GuardedModel:
        """The integer reference model with what serves and watches over sensors that fail.

        Raises:
            FormatError: as of `plain`; ReachError: no draw of the joint's loads gives a shape.
        """
        served = self._served if self.sensed.fallback else {}
        fallbacks = {axis: one.fallbacks for axis, one in served.items()}
        return GuardedModel(self.model, fallbacks, self.checks.groups)

    @cached_property
    def _served(self) -> Mapping[str, ServedAxis]:
        """Each axis with what serves without one of its sensors."""
        return {
            axis: quantise_with_fallbacks(self.task, axis, own, self._free[axis], self._held)
            for axis, own in self.weights.items()
        }

    @cached_property
    def serving(self) -> Mapping[str, Sequence[Weights | None]]:
        """Weights of each axis without each of its sensors, as they are exported.

        None where the axis is lost; empty without fallbacks. Where no format fits, and nothing is
        exported, they are those that no format limits.
        """
        if not self.sensed.fallback:
            return {}
        try:
            return {axis: one.weights for axis, one in self._served.items()}
        except FormatError:
            return self._free

    @cached_property
    def _free(self) -> Mapping[str, Sequence[Weights | None]]:
        """Weights of each axis without each of its sensors, as large as they are fitted."""
        found = {}
        for axis, own in self.weights.items():
            first = self.sensed.own(axis).start
            found[axis] = [self.fallback(axis, first + j) for j in range(own.sensors)]
        return found

    @cached_property
    def checks(self) -> JointChecks:
        """How the joint's sensors are held against each other, and which faults are seen.

        Raises:
            ReachError: no draw of the joint's loads gives a shape.
        """
        return joint_checks(self.sensed, self.shapes, lambda: self.plain)

    @property
    def noise(self) -> dict[str, Floats | None]:
        """Deviation of the normalised readings of each output axis; None where not stated.

        With the step of the counts, and the tolerance of the gains over the shapes of the fit.
        """
        moment = second_moment(self.shapes.state)
        return {axis: told_noise(self.sensed, axis, moment) for axis in self.weights}

    @cached_property
    def rounding(self) -> Mapping[str, float]:
        """Root mean square of what fixed point adds to a value of an axis, as the axis has it.

        Unknown, and empty, where no format fits; `plain` says why.
        """
        try:
            axes = self.model.axes
        except FormatError:
            return {}
        units = dict.fromkeys(AXES, self.joint.geometry.range_of_motion) | {"h": 1.0}
        return {
            axis: units[axis] / 100.0 * model.rms_error_percent_rom for axis, model in axes.items()
        }

    def rounding_without(self, sensor: int) -> Mapping[str, float]:
        """The same while a sensor is lost: between what serves in integers and as it was fitted."""
        found = dict(self.rounding)
        if not found or not self.sensed.fallback:
            return found
        for axis, one in self._served.items():
            own = self.sensed.own(axis)
            weights = self.fallback(axis, sensor) if own.start <= sensor < own.stop else None
            if weights is None:
                continue
            counts = counts_of(self.sensed, self.stated.shapes)[:, own]
            absent = np.arange(own.start, own.stop) == sensor
            rows = np.broadcast_to(absent, counts.shape)
            values = served(one.model, one.fallbacks.rows, counts, rows)
            ideal = counts @ count_gains(self.sensed, axis, weights).T
            found[axis] = rms(one.model.radians(values) - ideal)
        return found

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """What is odd of the joint's numbers and of its fixed point, a sentence each."""
        said = fixed_point_advice(self.joint, lambda: self.plain)
        return (*unit_doubts(self.joint), *said)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know before relying on the fit, a sentence each."""
        said = [*self.doubts, *advice(self)]
        share = reach(self.sensed, self.shapes)
        if share > 1.0 and not self._is_stated:
            said.append(
                f"the shapes reach {share:.3g} times the range of motion; formats grow with them"
            )
        return tuple(said)

    def estimate(self, counts: ArrayLike) -> Estimate:
        """Estimate the joint's state in double precision.

        Where one sensor of an axis gives no reading, the weights serve that were fitted without
        it, as in the exported C; they are fitted when first needed. The axis is NaN, and the tip
        with it, where two or more give none, where the others do not tell it, and where the joint
        has `fallback = false`. Sensors are not held against each other.

        Args:
            counts: shape (N, n), in the joint's order of sensors; NaN for no reading. What is
                missing may differ from row to row.

        Raises:
            ArgumentError: another form, or lengths in the place of counts.
        """

        def serving(axis: str, sensor: int) -> Weights | None:
            return self.serving[axis][sensor] if self.serving else None

        return estimate(self.sensed, self.sensors, self.weights, serving, counts)

    @cached_property
    def _held(self) -> Shapes:
        """Shapes that formats hold."""
        alone = self._is_stated and not self.sensed.couples
        return self.shapes if alone else joined([self.shapes, at_range(self.sensed)])

    @property
    def _is_stated(self) -> bool:
        """Whether all rows are the joint's load cases."""
        return set(self.shapes.source) == {"cases"}


def fit(
    joint: Joint,
    method: str | None = None,
    shapes: ArrayLike | Mapping[str, ArrayLike] | Shapes | None = None,
    report: Report = in_silence,
) -> Fit:
    """Fit the weights of a joint's estimator.

    Args:
        joint: the joint.
        method: one of `ccgen.estimation.FIT_METHODS`, instead of the joint's own.
        shapes: what to fit to instead of what the joint states: segment angles of shape (N, m) in
            radians, which both axes take; arrays by axis, {"u": ..., "v": ...}; or
            `ccgen.Shapes`.
        report: told of progress where something takes long: what, steps done, steps in all.

    Raises:
        ArgumentError: an unknown method, or shapes that are not the joint's; InputError: a method
            that the joint's sensors do not allow, or a recording that is wrong; ReachError: a
            shape that no load reaches.
    """
    if method is not None and method not in FIT_METHODS:
        raise ArgumentError(
            f"{method!r} is unknown; give one of {', '.join(FIT_METHODS)}", "method"
        )
    own = method or joint.method
    if shapes is not None or not joint.recordings:
        sources = simulated_sources(joint) if shapes is None else _given(joint, shapes)
        _check_moved(joint, sources, shapes is not None)
        task = Task(joint, sources)
        return Fit(joint, own, fit_task(task, own), task, report=report)
    return _fit_recorded(joint, own, report)


def _fit_recorded(joint: Joint, method: str, report: Report) -> Fit:
    """Fit a joint that names recordings, to fit to or to score with."""
    from ccgen.recordings.reading import read_recordings

    report("recordings", 0, len(joint.recordings))
    recordings = read_recordings(joint)
    report("recordings", len(recordings), len(recordings))
    found = recorded(joint, recordings, report=report)
    simulated = simulated_sources(joint, bool(found.shaped))
    sources = [*simulated, *found.sources()]
    _check_moved(joint, sources, False)
    task = Task(found.joint, sources)
    return Fit(joint, method, fit_task(task, method), task, recordings, found, report)


def _check_moved(joint: Joint, sources: Sequence[Source], given: bool) -> None:
    """Refuse shapes from which an axis would learn to answer zero."""
    still = still_axes(joint, sources)
    if not still:
        return
    what = "elongates the joint" if still[0] == "h" else f"bends axis {still[0]}"
    said = f'no shape {what}; give some that do, or leave "{still[0]}" out of estimator.axes'
    if given:
        raise ArgumentError(said, "shapes")
    key = "recordings" if joint.recordings else "loads"
    raise InputError(f"{joint.source}: {key}: {said}")


def _given(joint: Joint, shapes: ArrayLike | Mapping[str, ArrayLike] | Shapes) -> list[Source]:
    """Shapes that are given, by source, each row counting the same."""
    rows = given_shapes(joint, shapes)
    parts = [rows.of_source(name) for name in dict.fromkeys(rows.source)]
    return [Source(part.source[0], part, len(part) / len(rows)) for part in parts]
