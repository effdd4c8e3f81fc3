"""A fitted joint: its weights with all that follows from them, in floats and in integers."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ccgen.errors import ArgumentError, ReachError
from ccgen.estimation import (
    FIT_METHODS,
    ErrorRow,
    Weights,
    elongation_warning,
    error_rows,
    fit_joint,
)
from ccgen.estimation.estimate import Estimate, estimate
from ccgen.fixedpoint.formats import quantise
from ccgen.fixedpoint.model import FixedPointModel, Floats
from ccgen.joint import AXES, Joint, Sensor
from ccgen.sensing.noise import second_moment, told_noise
from ccgen.shapes import (
    Shapes,
    bent_alike,
    fit_shapes,
    joined,
    score_shapes,
)
from ccgen.shapes.given import given_shapes, reach


@dataclass(frozen=True, eq=False)
class Fit:
    """What was fitted to a joint, and what is exported of it.

    Attributes:
        joint: the joint.
        method: name of the estimation method.
        weights: by output axis; they apply to normalised readings, (l - l0) / (r p).
        shapes: the rows that the weights were fitted to.
        sensors: the joint's, with the gains and zeros that the estimate uses.
    """

    joint: Joint
    method: str
    weights: Mapping[str, Weights]
    shapes: Shapes
    sensors: tuple[Sensor, ...]

    @cached_property
    def model(self) -> FixedPointModel:
        """The integer reference model.

        Its formats hold the shapes; where those are not the joint's own load cases, or where axes
        meet in a sensor, also the joint at its range of motion in all axes at once.

        Raises:
            FormatError: no format fits; names the sensor, the key and the remedy.
        """
        alone = self._is_stated and not self.joint.couples
        held = self.shapes if alone else joined([self.shapes, _at_range(self.joint)])
        return quantise(self.joint, self.weights, held)

    @property
    def noise(self) -> dict[str, Floats | None]:
        """Deviation of the normalised readings of each output axis; None where not stated.

        With the step of the counts, and the tolerance of the gains over the shapes of the fit.
        """
        moment = second_moment(self.shapes.state)
        return {axis: told_noise(self.joint, axis, moment) for axis in self.weights}

    @property
    def errors(self) -> tuple[ErrorRow, ...]:
        """How far estimates are from the shapes of each source."""
        return self._scored[0]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know before relying on the fit."""
        return self._scored[1]

    def estimate(self, counts: ArrayLike) -> Estimate:
        """Estimate the joint's state in double precision.

        Args:
            counts: shape (N, n), in the joint's order of sensors; NaN for no reading.

        Raises:
            ArgumentError: another form, or lengths in the place of counts.
        """
        return estimate(self.joint, self.sensors, self.weights, counts)

    @property
    def _is_stated(self) -> bool:
        """Whether all rows are the joint's load cases."""
        return set(self.shapes.source) == {"cases"}

    @cached_property
    def _scored(self) -> tuple[tuple[ErrorRow, ...], tuple[str, ...]]:
        joint, rows, warnings = self.joint, [], []
        noise, fitted = self.noise, self.weights
        try:
            between = score_shapes(joint)
            rows += error_rows(joint, fitted, between, noise, "cases", held_out=True)
        except ReachError as error:
            warnings.append(f"the load cases are left out of the errors: {error}")
        for source in dict.fromkeys(self.shapes.source):
            if source == "cases":
                continue
            given = self.shapes.of_source(source)
            rows += error_rows(joint, fitted, given, noise, source, held_out=False)
        bent = elongation_warning(joint, fitted)
        if bent is not None and joint.geometry.elongation is not None:
            warnings.append(bent)
        share = reach(joint, self.shapes)
        if share > 1.0 and not self._is_stated:
            warnings.append(
                f"the shapes reach {share:.3g} times the range of motion; formats grow with them"
            )
        return tuple(rows), tuple(warnings)


def _at_range(joint: Joint) -> Shapes:
    """The joint bent as far as it goes, to either side in both axes at once, and stretched so."""
    geometry = joint.geometry
    if not joint.couples:
        farthest = np.full(geometry.segments, geometry.range_of_motion)
        bends = np.array([farthest, -farthest])
        return bent_alike(bends, len(geometry.sections), "range of motion")
    both = (-geometry.range_of_motion, geometry.range_of_motion)
    sides = [both if axis in joint.axes else (0.0,) for axis in AXES]
    corners = np.array(list(product(*sides, geometry.elongation or (0.0,))))
    columns = (geometry.segments, geometry.segments, len(geometry.sections))
    u, v, h = (np.outer(corners[:, k], np.ones(count)) for k, count in enumerate(columns))
    return Shapes(u, v, h, ("range of motion",) * len(corners))


def fit(
    joint: Joint,
    method: str | None = None,
    shapes: ArrayLike | Mapping[str, ArrayLike] | Shapes | None = None,
) -> Fit:
    """Fit the weights of a joint's estimator.

    Args:
        joint: the joint.
        method: one of `ccgen.estimation.FIT_METHODS`, instead of the joint's own.
        shapes: what to fit to instead of what the joint states: segment angles of shape (N, m) in
            radians, which both axes take; arrays by axis, {"u": ..., "v": ...}; or
            `ccgen.Shapes`.

    Raises:
        ArgumentError: an unknown method, or shapes that are not the joint's; InputError: a method
            that the joint's sensors do not allow; ReachError: a shape that no load reaches.
    """
    if method is not None and method not in FIT_METHODS:
        raise ArgumentError(
            f"{method!r} is unknown; give one of {', '.join(FIT_METHODS)}", "method"
        )
    rows = fit_shapes(joint) if shapes is None else given_shapes(joint, shapes)
    sensors = tuple(replace(sensor, zero=sensor.zero or 0) for sensor in joint.sensors)
    weights = fit_joint(joint, method, rows)
    return Fit(joint, method or joint.method, weights, rows, sensors)
