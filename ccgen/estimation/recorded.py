"""Recordings of a joint, as shapes to fit to and as what estimates are held against.

What recordings tell of the sensors goes into the joint that weights are fitted for: gains and the
noise that is left, unless a calibration tells them, and zeros that nothing else states.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.estimation.sources import Source, source_weights
from ccgen.estimation.weights import Floats
from ccgen.joint.specification import RECORDED
from ccgen.recordings.progress import Report, in_silence
from ccgen.sensing.readings import normaliser
from ccgen.shapes import Shapes, within_axes

if TYPE_CHECKING:
    from ccgen.joint import Joint, Sensor
    from ccgen.recordings.recording import Recording
    from ccgen.recordings.reference import Reference

BLOCKS = 5
"""Of time, each held out in turn."""

_LEAST_NOISE = 1e-9
"""Metres; the step of the counts, which is told apart, may be all that there is."""


@dataclass(frozen=True)
class StiffnessProfile:
    """Stiffness of equal parts of a joint from its base, as `stiffness_profile` states it."""

    profile: tuple[float, ...]
    """With a mean of 1."""
    std: tuple[float, ...]
    """One standard deviation of each, share of it."""

    @property
    def lines(self) -> tuple[str, str]:
        """What to paste into [loads], and how sure it is."""
        profile = ", ".join(f"{value:.2f}" for value in self.profile)
        std = ", ".join(f"{100 * value:.0f}" for value in self.std)
        return f"stiffness_profile = [{profile}]", f"standard deviations in %: {std}"


@dataclass(frozen=True, eq=False)
class Recorded:
    """All recordings of a joint, and what they tell of its sensors.

    Attributes:
        stated: the joint as its file has it.
        references: of each recording, in the order of the file.
    """

    stated: "Joint"
    references: Sequence["Reference"]

    @property
    def fitted(self) -> list["Reference"]:
        """Those that are there to fit to, which tell of the sensors."""
        return [one for one in self.references if one.use == "fit"]

    @property
    def shaped(self) -> list["Reference"]:
        """Those of them that weights are fitted to: the straight joint alone is no shape."""
        return [one for one in self.fitted if np.nan_to_num(one.state).any()]

    @cached_property
    def joint(self) -> "Joint":
        """The joint with the gains, zeros and noise that its recordings tell."""
        counted = [one for one in self.fitted if one.lengths is not None]
        if not counted:
            return self.stated
        zeros = np.array([_known(one.zero) for one in counted])
        first = counted[0]
        found = first.gain, first.gain_std, first.noise
        unknown = np.full(len(self.stated.sensors), np.nan)
        if self.stated.calibration is not None:
            found = (unknown,) * 3
        elif not any(one.lengths is not None for one in self.shaped):
            found = unknown, unknown, first.noise
        told = zip(self.stated.sensors, _mean(zeros), *map(_known, found), strict=True)
        return replace(self.stated, sensors=tuple(_told(*one) for one in told))

    @property
    def stiffness(self) -> "StiffnessProfile | None":
        """How stiff parts of the joint are against each other, where recordings tell it."""
        told = [one.compliance for one in self.fitted if one.compliance is not None]
        if not told:
            return None
        compliance, std = told[0]
        profile = np.exp(-compliance)
        return StiffnessProfile(tuple((profile / profile.mean()).tolist()), tuple(std.tolist()))

    def readings(self, reference: "Reference") -> Floats | None:
        """Normalised readings of a reference's counts, shape (N, n); None without counts."""
        if reference.lengths is None:
            return None
        nominal = np.array([sensor.metres_per_count for sensor in self.stated.sensors])
        actual = np.array([sensor.metres_per_count for sensor in self.joint.sensors])
        stated = np.array(
            [np.nan if sensor.zero is None else sensor.zero for sensor in self.stated.sensors]
        )
        own = _known(reference.zero)
        kept = np.array([sensor.zero or 0 for sensor in self.joint.sensors]) * nominal
        zero = np.where(np.isnan(stated), np.where(np.isnan(own), kept, own), stated * nominal)
        return np.asarray((reference.lengths - zero) * (actual / nominal / normaliser(self.joint)))

    def source(self, reference: "Reference", weight: float, without: int | None = None) -> Source:
        """A recording as a source; its rows are those whose shape is known.

        Args:
            reference: the recording.
            weight: of the source.
            without: number of a block whose rows are left out.

        Raises:
            InputError: no such row.
        """
        rows = self.rows(reference)
        if not rows.any():
            axes = " and ".join(self.stated.axes)
            raise InputError(
                f"{self.stated.source}: {reference.name}: no row tells every segment of {axes}; "
                "record all of them, or leave an axis out of estimator.axes"
            )
        if without is not None:
            rows &= reference.block != without
        readings = self.readings(reference)
        return Source(
            reference.name,
            self.shapes(reference, rows),
            weight,
            readings=None if readings is None else readings[rows],
            moment=None if reference.dense else reference.second_moment,
        )

    def rows(self, reference: "Reference") -> NDArray[np.bool_]:
        """Which rows have a shape that is known in every axis that is estimated, shape (N,)."""
        joint = self.stated
        known = [reference.state[:, joint.rows(axis)] for axis in joint.axes]
        return np.asarray(~np.isnan(np.concatenate(known, axis=1)).any(axis=1))

    def shapes(self, reference: "Reference", rows: NDArray[np.bool_]) -> Shapes:
        """Some rows of a reference as shapes; what no axis estimates is 0 where it is not known."""
        m = self.stated.geometry.segments
        state = np.nan_to_num(reference.state[rows])
        parts = state[:, :m], state[:, m : 2 * m], state[:, 2 * m :]
        return within_axes(self.stated, Shapes(*parts, (reference.name,) * len(state)))

    def sources(self, without: int | None = None) -> list[Source]:
        """Those to fit to, with the weight that recordings have, shared evenly by them."""
        share = source_weights(self.stated, True)["recordings"] / max(1, len(self.shaped))
        return [self.source(one, share, without) for one in self.shaped]


def recorded(
    joint: "Joint",
    recordings: Sequence["Recording"],
    without: int | None = None,
    whole: Recorded | None = None,
    report: Report = in_silence,
) -> Recorded:
    """References of recordings.

    Args:
        joint: as its file has it.
        recordings: its recordings, read.
        without: number of a block from whose rows nothing is learned.
        whole: what was found with nothing left out, to begin with.
        report: told of the progress.

    Raises:
        InputError: a recording that does not tell shapes.
    """
    from ccgen.recordings.references import references

    begin = () if whole is None else whole.references
    return Recorded(joint, references(joint, recordings, without, begin, report))


def _known(values: Floats | None) -> Floats:
    assert values is not None
    return values


def _mean(zeros: Floats) -> Floats:
    """Mean of each sensor's zeros, NaN where no recording tells it."""
    there = ~np.isnan(zeros)
    total = np.where(there, zeros, 0.0).sum(axis=0)
    return np.asarray(np.where(there.any(axis=0), total / np.maximum(there.sum(axis=0), 1), np.nan))


def _told(sensor: "Sensor", zero: float, gain: float, gain_std: float, noise: float) -> "Sensor":
    """A sensor with what recordings tell of it; numbers that are NaN tell nothing."""
    step = sensor.metres_per_count
    found = sensor
    if not np.isnan(gain):
        found = replace(found, metres_per_count=step / gain, gain_tolerance=abs(gain_std / gain))
    if not np.isnan(zero) and sensor.zero is None:
        found = replace(found, zero=round(zero / step), zero_origin=RECORDED)
    if not np.isnan(noise):
        rest = max(noise**2 - step**2 / 12.0, _LEAST_NOISE**2)
        found = replace(found, noise=float(np.sqrt(rest)))
    return found
