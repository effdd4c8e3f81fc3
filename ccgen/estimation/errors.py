"""What weights get wrong on shapes: the figures that a user would see on the joint.

With readings y = H x + e of rows x, an estimate errs by (W H - I) x, which is known, and by W e,
whose covariance is: e has the stated noise, the step of the counts, and a share of the length
change itself where gains are known to a tolerance. Means of absolute errors and of squares follow
without sampling; the tip follows from shapes that are off by one standard deviation of one sensor
at a time, to first order in the noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.axes import estimated
from ccgen.estimation.folded import folded_mean
from ccgen.estimation.weights import Floats, Weights
from ccgen.kinematics import tip_pose
from ccgen.sensing.noise import length_variance
from ccgen.sensing.readings import length_changes, normaliser

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import Shapes

WORST = 3.0
"""Standard deviations of noise in the worst error of the tip."""


@dataclass(frozen=True)
class StationErrors:
    """Root mean square errors at a body or marker, the reference's own noise taken off."""

    position_rms_m: float
    bend_rms_deg: Mapping[str, float]
    """By axis: of the bend since the station before; empty without orientations."""
    arc_length_rms_m: float | None
    """From the base, where the joint elongates."""


@dataclass(frozen=True)
class ErrorRow:
    """Errors on the rows of one source.

    Angles are told by bending axis, "u" and "v" as the joint estimates them.
    """

    source: str
    held_out: bool
    """Whether the weights that are judged were fitted without the rows they are judged on."""
    noise: bool
    """Whether noise, quantisation and tolerances are part of the errors."""
    mean_percent_rom: Mapping[str, float]
    """Mean absolute error of a segment, % of the range of motion (equation 12)."""
    rms_deg: Mapping[str, float]
    """Root mean square error of a segment, degrees."""
    total_bend_rms_deg: Mapping[str, float]
    """Root mean square error of the sum of all segments, degrees."""
    tip_rms_m: float
    tip_max_m: float
    """The worst row's; with noise three standard deviations more."""
    elongation_rms_percent: float | None
    """Of a section, % of its length; None where the joint does not estimate elongation."""
    stations: Mapping[str, StationErrors] | None = None


@dataclass(frozen=True, eq=False)
class Missed:
    """By how much estimates of N rows are off: what is known, and the spread of what is not.

    Attributes:
        joint: the joint.
        weights: of its output axes.
        state: true states, shape (N, 2m + S).
        estimate: of readings without noise, or of real ones, same shape.
        deviation: of each normalised reading, shape (N, n); zeros leave the noise out.
        rounding: root mean square of what fixed point adds to a value of an axis.
    """

    joint: "Joint"
    weights: Mapping[str, Weights]
    state: Floats
    estimate: Floats
    deviation: Floats
    rounding: Mapping[str, float]

    def known(self, axis: str) -> Floats:
        """Estimate minus truth of an axis without noise, shape (N, m or S)."""
        own = self.joint.rows(axis)
        return np.asarray(self.estimate[:, own] - self.state[:, own])

    def spread(self, axis: str) -> Floats:
        """Standard deviation that noise adds, shape (N, m or S)."""
        own = self.weights[axis]
        variance: Floats = self._squares[:, self.joint.own(axis)] @ np.square(own.matrix).T
        return np.asarray(np.sqrt(variance + self.rounding.get(axis, 0.0) ** 2))

    def total_spread(self, axis: str) -> Floats:
        """Standard deviation that noise adds to the sum of all segments, shape (N,)."""
        own = self.weights[axis]
        row = np.square(own.matrix.sum(axis=0))
        variance: Floats = self._squares[:, self.joint.own(axis)] @ row
        return np.asarray(np.sqrt(variance + own.segments * self.rounding.get(axis, 0.0) ** 2))

    @cached_property
    def tip(self) -> tuple[Floats, Floats]:
        """Distance of the estimated tip without noise, and what noise adds, shape (N,), metres."""
        at = tips(self.joint, self.estimate)
        known = np.linalg.norm(at - tips(self.joint, self.state), axis=-1)
        variance = np.zeros(len(self.state))
        for j in np.flatnonzero(self.deviation.any(axis=0)).tolist():
            step: Floats = self.deviation[:, [j]] * self._per_reading(j)
            moved = tips(self.joint, self.estimate + step)
            variance += np.square(moved - at).sum(axis=-1)
        return known, np.sqrt(variance)

    @cached_property
    def _squares(self) -> Floats:
        return np.square(self.deviation)

    def _per_reading(self, sensor: int) -> Floats:
        """Change of the estimate for a unit of one normalised reading, shape (2m + S,)."""
        one = np.zeros(len(self.joint.sensors))
        one[sensor] = 1.0
        zero = np.zeros_like(one)
        change: Floats = estimated(self.joint, self.weights, one)
        return change - estimated(self.joint, self.weights, zero)


def tips(joint: "Joint", state: Floats) -> Floats:
    """Places of the tip, shape (..., 3), metres, for states of shape (..., 2m + S)."""
    geometry = joint.geometry
    m = geometry.segments
    stretch = np.repeat(state[..., 2 * m :], geometry.sections, axis=-1)
    pose = tip_pose(state[..., :m], state[..., m : 2 * m], geometry.segment_length * (1 + stretch))
    return np.asarray(pose[..., :3, 3])


def deviations(joint: "Joint", state: Floats, noise: Floats | None = None) -> Floats:
    """Standard deviations of the normalised readings of these states, shape (N, n).

    Args:
        joint: states noise, step and tolerances.
        state: shape (N, 2m + S).
        noise: of the lengths, quantisation included, where it is known better than stated,
            shape (n,), metres.
    """
    variance = length_variance(joint) if noise is None else np.square(noise)
    tolerance = np.array([sensor.gain_tolerance for sensor in joint.sensors])
    lengths = np.square(tolerance * length_changes(joint, state)) + variance
    return np.asarray(np.sqrt(lengths) / normaliser(joint))


def missed(
    joint: "Joint",
    weights: Mapping[str, Weights],
    shapes: "Shapes",
    noise: bool,
    lengths_noise: Floats | None = None,
    rounding: Mapping[str, float] | None = None,
) -> Missed:
    """Errors of weights on simulated shapes.

    Args:
        joint: the joint.
        weights: of its output axes.
        shapes: N rows.
        noise: whether readings have noise, counts steps, gains tolerances and angles rounding.
        lengths_noise: as for `deviations`.
        rounding: root mean square of what fixed point adds to a value of an axis.
    """
    state = shapes.state
    ideal = length_changes(joint, state) / normaliser(joint)
    estimate = estimated(joint, weights, ideal)
    deviation = deviations(joint, state, lengths_noise) if noise else np.zeros_like(ideal)
    return Missed(joint, weights, state, estimate, deviation, (rounding or {}) if noise else {})


def errors_of(source: str, found: Missed, noise: bool, held_out: bool) -> ErrorRow:
    """The figures of errors.

    Args:
        source: its name.
        found: the errors.
        noise: whether noise is part of them.
        held_out: whether the weights do not know the rows.
    """
    joint = found.joint
    bending = [axis for axis in joint.axes if axis != "h"]
    rom = joint.geometry.range_of_motion
    known = {axis: found.known(axis) for axis in joint.axes}
    spread = {axis: found.spread(axis) for axis in joint.axes}
    tip, tip_spread = found.tip
    return ErrorRow(
        source=source,
        held_out=held_out,
        noise=noise,
        mean_percent_rom={
            a: float(100.0 * folded_mean(known[a], spread[a]).mean() / rom) for a in bending
        },
        rms_deg={a: float(np.degrees(_rms(known[a], spread[a]))) for a in bending},
        total_bend_rms_deg={
            a: float(np.degrees(_rms(known[a].sum(axis=1), found.total_spread(a)))) for a in bending
        },
        tip_rms_m=_rms(tip, tip_spread),
        tip_max_m=float(np.max(tip + WORST * tip_spread)),
        elongation_rms_percent=100.0 * _rms(known["h"], spread["h"]) if "h" in known else None,
    )


def _rms(known: Floats, spread: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(known) + np.square(spread))))
