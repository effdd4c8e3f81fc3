"""What weights get wrong on shapes: the figures that a user would see on the joint.

With readings y = H x + e of rows x, an estimate errs by (W H - I) x, which is known, and by W e,
whose covariance is: e has the stated noise, the step of the counts, and a share of the length
change itself where gains are known to a tolerance. Means of absolute errors and of squares follow
without sampling; the tip follows from its derivatives, to first order in the noise.

Real readings bring their noise along. Where the true shape is known to a covariance only, as from
markers, that adds to the spread: an error's mean square is that about the most probable shape, and
the variance of the truth about it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ccgen.estimation.axes import estimated
from ccgen.estimation.folded import folded_mean
from ccgen.estimation.weights import Floats, Weights
from ccgen.kinematics import tip_position, tip_slopes
from ccgen.sensing.noise import length_variance
from ccgen.sensing.readings import length_changes, normaliser

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.recordings.stations import StationErrors
    from ccgen.shapes import Shapes

WORST = 3.0
"""Standard deviations of noise in the worst error of the tip."""


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
    stations: Mapping[str, "StationErrors"] | None = None
    """Of a recording with bodies or markers, by their names."""

    def record(self) -> dict[str, Any]:
        """What JSON can say of the row: None where nothing is known, stations where there are."""
        found = asdict(self)
        if self.stations is None:
            del found["stations"]
        else:
            found["stations"] = {name: _known_alone(one) for name, one in found["stations"].items()}
        return found


@dataclass(frozen=True, eq=False)
class Missed:
    """By how much estimates of N rows are off: what is known, and the spread of what is not.

    Attributes:
        joint: the joint.
        weights: of its output axes.
        state: true states, shape (N, 2m + S).
        estimate: of readings without noise, or of real ones, same shape; NaN where there is none.
        deviation: of each normalised reading, shape (N, n); zeros leave the noise out.
        rounding: root mean square of what fixed point adds to a value of an axis.
        covariance: of the true states, shape (N, 2m + S, 2m + S); None where they are known.
        place: true places of the tip, shape (N, 3), metres; None where the states tell them. A
            joint that twists bears its tip elsewhere.
        place_spread: standard deviation of the distance from there, shape (N,), metres; None where
            the covariance tells it.
    """

    joint: "Joint"
    weights: Mapping[str, Weights]
    state: Floats
    estimate: Floats
    deviation: Floats
    rounding: Mapping[str, float]
    covariance: Floats | None = None
    place: Floats | None = None
    place_spread: Floats | None = None

    def truth(self, axis: str) -> Floats:
        """True values of an axis, shape (N, m or S)."""
        return self.state[:, self.joint.rows(axis)]

    def known(self, axis: str) -> Floats:
        """Estimate minus truth of an axis without noise, shape (N, m or S)."""
        return np.asarray(self.estimate[:, self.joint.rows(axis)] - self.truth(axis))

    def spread(self, axis: str) -> Floats:
        """Standard deviation that noise adds, shape (N, m or S)."""
        own = self.weights[axis]
        variance: Floats = self._squares[:, self.joint.own(axis)] @ np.square(own.matrix).T
        if self.covariance is not None:
            own_variance = np.diagonal(self.covariance, axis1=1, axis2=2)
            variance = variance + own_variance[:, self.joint.rows(axis)]
        return np.asarray(np.sqrt(variance + self.rounding.get(axis, 0.0) ** 2))

    def total_spread(self, axis: str) -> Floats:
        """Standard deviation that noise adds to the sum of all segments, shape (N,)."""
        own = self.weights[axis]
        row = np.square(own.matrix.sum(axis=0))
        variance: Floats = self._squares[:, self.joint.own(axis)] @ row
        if self.covariance is not None:
            part = self.joint.rows(axis)
            variance = variance + self.covariance[:, part, part].sum(axis=(1, 2))
        return np.asarray(np.sqrt(variance + own.segments * self.rounding.get(axis, 0.0) ** 2))

    @cached_property
    def tip(self) -> tuple[Floats, Floats]:
        """Distance of the estimated tip without noise, and what noise adds, shape (N,), metres."""
        at = tips(self.joint, self.estimate)
        true = tips(self.joint, self.state) if self.place is None else self.place
        known = np.linalg.norm(at - true, axis=-1)
        variance = np.zeros(len(self.state))
        if self.deviation.any():
            per_reading = tip_changes(self.joint, self.estimate) @ self._gain
            variance += np.einsum("ncj,nj->n", np.square(per_reading), self._squares)
        if self.place_spread is not None:
            variance += np.square(self.place_spread)
        elif self.covariance is not None:
            slope = tip_changes(self.joint, self.state)
            variance += np.einsum("nca,nab,ncb->n", slope, self.covariance, slope, optimize=True)
        return known, np.sqrt(variance)

    @cached_property
    def _squares(self) -> Floats:
        return np.square(self.deviation)

    @property
    def _gain(self) -> Floats:
        """Change of the estimate by every normalised reading, shape (2m + S, n)."""
        count = len(self.joint.sensors)
        straight = estimated(self.joint, self.weights, np.zeros(count))
        return np.asarray((estimated(self.joint, self.weights, np.eye(count)) - straight).T)


@dataclass(frozen=True, eq=False)
class Pooled:
    """Errors of several weights, each on rows of its own, such as blocks that were held out."""

    parts: Sequence[Missed]

    @property
    def joint(self) -> "Joint":
        """The joint."""
        return self.parts[0].joint

    def truth(self, axis: str) -> Floats:
        """As of `Missed`, all rows."""
        return np.concatenate([part.truth(axis) for part in self.parts])

    def known(self, axis: str) -> Floats:
        """As of `Missed`, all rows."""
        return np.concatenate([part.known(axis) for part in self.parts])

    def spread(self, axis: str) -> Floats:
        """As of `Missed`, all rows."""
        return np.concatenate([part.spread(axis) for part in self.parts])

    def total_spread(self, axis: str) -> Floats:
        """As of `Missed`, all rows."""
        return np.concatenate([part.total_spread(axis) for part in self.parts])

    @property
    def tip(self) -> tuple[Floats, Floats]:
        """As of `Missed`, all rows."""
        known, spread = zip(*(part.tip for part in self.parts), strict=True)
        return np.concatenate(known), np.concatenate(spread)


def tips(joint: "Joint", state: Floats) -> Floats:
    """Places of the tip, shape (..., 3), metres, for states of shape (..., 2m + S)."""
    return tip_position(*_bends_and_lengths(joint, state))


def tip_changes(joint: "Joint", state: Floats) -> Floats:
    """Derivatives of the tip's place by the state, shape (N, 3, 2m + S)."""
    geometry = joint.geometry
    slopes = tip_slopes(*_bends_and_lengths(joint, state))
    firsts = np.cumsum([0, *geometry.sections[:-1]])
    stretch = geometry.segment_length * np.add.reduceat(slopes.h, firsts, axis=-1)
    return np.concatenate([slopes.u, slopes.v, stretch], axis=-1)


def _bends_and_lengths(joint: "Joint", state: Floats) -> tuple[Floats, Floats, Floats]:
    geometry = joint.geometry
    m = geometry.segments
    stretch = np.repeat(state[..., 2 * m :], geometry.sections, axis=-1)
    return state[..., :m], state[..., m : 2 * m], geometry.segment_length * (1 + stretch)


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
    readings: Floats | None = None,
) -> Missed:
    """Errors of weights on shapes, simulated or with readings of their own.

    Args:
        joint: the joint.
        weights: of its output axes.
        shapes: N rows.
        noise: whether readings have noise, counts steps, gains tolerances and angles rounding.
        lengths_noise: as for `deviations`.
        rounding: root mean square of what fixed point adds to a value of an axis.
        readings: normalised, noise and all, shape (N, n); without them those of ideal sensors.
    """
    state = shapes.state
    ideal = length_changes(joint, state) / normaliser(joint)
    estimate = estimated(joint, weights, ideal if readings is None else readings)
    simulated = noise and readings is None
    deviation = deviations(joint, state, lengths_noise) if simulated else np.zeros_like(ideal)
    return Missed(joint, weights, state, estimate, deviation, (rounding or {}) if noise else {})


def _known_alone(record: Mapping[str, Any]) -> dict[str, Any]:
    return {
        key: _known_alone(value)
        if isinstance(value, Mapping)
        else (None if value != value else value)  # NaN alone differs from itself
        for key, value in record.items()
    }


def errors_of(
    source: str,
    found: Missed | Pooled,
    noise: bool,
    held_out: bool,
    stations: Mapping[str, "StationErrors"] | None = None,
) -> ErrorRow:
    """The figures of errors; rows without an estimate do not count.

    Args:
        source: its name.
        found: the errors.
        noise: whether noise is part of them.
        held_out: whether the weights do not know the rows.
        stations: errors at bodies and markers.
    """
    joint = found.joint
    bending = [axis for axis in joint.axes if axis != "h"]
    rom = joint.geometry.range_of_motion
    errors = {axis: _known(found.known(axis), found.spread(axis)) for axis in joint.axes}
    totals = {
        axis: _known(found.known(axis).sum(axis=1), found.total_spread(axis)) for axis in bending
    }
    tip, tip_spread = _known(*found.tip)
    return ErrorRow(
        source=source,
        held_out=held_out,
        noise=noise,
        mean_percent_rom={a: float(100.0 * folded_mean(*errors[a]).mean() / rom) for a in bending},
        rms_deg={a: float(np.degrees(_rms(*errors[a]))) for a in bending},
        total_bend_rms_deg={a: float(np.degrees(_rms(*totals[a]))) for a in bending},
        tip_rms_m=_rms(tip, tip_spread),
        tip_max_m=float(np.max(tip + WORST * tip_spread)),
        elongation_rms_percent=100.0 * _rms(*errors["h"]) if "h" in errors else None,
        stations=stations,
    )


@dataclass(frozen=True)
class StandardDeviations:
    """Root mean square errors of every estimated value and of the tip."""

    axes: Mapping[str, tuple[float, ...]]
    """By output axis, of each segment in radians, of each section as a share of its length."""
    tip_m: float
    """Distance, metres."""


def standard_deviations(found: Missed | Pooled) -> StandardDeviations:
    """Standard deviations of the estimate about the truth, rows without an estimate left out."""
    axes = {}
    for axis in found.joint.axes:
        squares = np.square(found.known(axis)) + np.square(found.spread(axis))
        axes[axis] = tuple(np.sqrt(np.nanmean(squares, axis=0)).tolist())
    return StandardDeviations(axes, _rms(*_known(*found.tip)))


def _known(error: Floats, spread: Floats) -> tuple[Floats, Floats]:
    """Errors and their spread where there is an estimate."""
    missing = np.isnan(error)
    return (error[~missing], spread[~missing]) if missing.any() else (error, spread)


def _rms(known: Floats, spread: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(known) + np.square(spread))))
