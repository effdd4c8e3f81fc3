"""A joint's sensors from its recordings: gain, zero, noise and delay, each with its deviation.

Reference shapes, where recordings have them, tell gains and zeros through
`ccgen.recordings.reference`; poses that are known without cameras add what they tell.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ccgen.calibration.bent import found_places
from ccgen.calibration.places import Place
from ccgen.calibration.seen import Seen, correlation, gain_of, pooled
from ccgen.calibration.sources import Followed, Sources, counted, sources_of, without
from ccgen.calibration.suspicious import Suspicion, Zeros, shifted, suspicious
from ccgen.calibration.told import Found, Told, together
from ccgen.errors import ArgumentError, InputError
from ccgen.joint import Joint, Sensor
from ccgen.joint.calibration import (
    Calibration,
    SensorCalibration,
    calibrated,
    sensors_fingerprint,
)
from ccgen.joint.calibration_file import calibration_text, uncalibrated
from ccgen.joint.file import read_joint
from ccgen.joint.messages import KeyProblemError
from ccgen.outputs import write_file
from ccgen.recordings.learning import independent_rows

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LARGEST_GAIN_STD = 0.1
"""Deviation of a gain, share of it, above which a recording does not determine it."""

_LEAST_MOTION = 5.0
"""Root mean square motion of a sensor, in deviations of its noise, that shows its gain."""
_ALIKE = 0.8
"""Correlation of readings with what they should be above which their plain gain is believed."""
_LEFT_OUT = ("swapped", "stuck")
"""Kinds of suspicious sensors of which nothing is written: they did not read their own place."""


@dataclass(frozen=True)
class Calibrated:
    """What recordings told of a joint's sensors.

    Attributes:
        calibration: what goes into the calibration file; `ccgen.load` applies it.
        places: where each sensor was found to run, in the joint's order.
        suspicious: sensors that do not read what the joint file says.
        notes: what else is to be said, a line each.
    """

    calibration: Calibration
    places: tuple[Place, ...]
    suspicious: tuple[Suspicion, ...]
    notes: tuple[str, ...]

    def write(self, path: str | Path) -> None:
        """Write the calibration file, whole or not at all.

        Raises:
            InputError: the place cannot be written.
        """
        write_file(Path(path), calibration_text(self.calibration).encode())


def calibrate(joint: Joint | str | Path) -> Calibrated:
    """Find gains, zeros, noise and delay of a joint's sensors from its recordings to fit to.

    Args:
        joint: path of its file, whose calibration is not read; or a joint without one.

    Raises:
        InputError: no recording tells of the sensors, or too little; in one line which, and what
            would.
    """
    if isinstance(joint, str | Path):
        joint = read_joint(Path(joint), uncalibrated)
    if joint.calibration_content:
        raise ArgumentError("is calibrated already; give the path of its file", "joint")
    recordings = counted(joint)
    names = [sensor.name for sensor in joint.sensors]
    sources = sources_of(joint, recordings)
    suspects = suspicious(names, sources.seen)
    near = _near(joint, sources.seen, suspects)
    silent = [_is(suspects, sensor, *_LEFT_OUT) for sensor in joint.sensors]
    if near != joint or any(silent):
        # Shapes rest on readings where cameras leave them open: without those that mislead.
        sources = sources_of(near, [without(one, silent) for one in recordings])
        kept = [one for one in suspects if one.kind != "slipping"]
        known = {one.name for one in kept}
        again = suspicious(names, sources.seen)
        suspects = (*kept, *(one for one in again if one.name not in known))
    noise = _noise(near, sources)
    found = together([*_told(sources.followed), *(one.told for one in sources.held)])
    suspects = (*suspects, *_shifted(joint, sources, noise.value, suspects))
    read = _read(sources)
    _check_determined(joint, sources, found, read, suspects)
    delay, delay_std = _delay(sources.followed)
    calibration = Calibration(
        joint=joint.name,
        fingerprint=sensors_fingerprint(joint),
        sensors=_sensors(near, found, noise, read, suspects),
        delay=delay,
        delay_std=delay_std,
        recordings=tuple(dict(pair for one in recordings for pair in one.hashes).items()),
    )
    try:
        calibrated(joint, calibration)
    except KeyProblemError as problem:
        raise InputError(f"{joint.source}: {problem}") from None
    notes = (*sources.notes, *_unread(joint, read | np.array(silent)))
    return Calibrated(calibration, found_places(near, sources.followed), suspects, notes)


def _near(joint: Joint, seen: Sequence[Seen], suspects: Sequence[Suspicion]) -> Joint:
    """The joint with nominal gains near those that it has: references expect gains about 1."""
    sensors = []
    for j, sensor in enumerate(joint.sensors):
        x, y = pooled(seen, j, j)
        gain = gain_of(x, y)
        if (
            abs(gain - 1.0) > LARGEST_GAIN_STD
            and abs(correlation(x, y)) > _ALIKE
            and not _is(suspects, sensor, *_LEFT_OUT)
        ):
            sensor = replace(sensor, metres_per_count=sensor.metres_per_count / gain)
        sensors.append(sensor)
    return replace(joint, sensors=tuple(sensors))


def _is(suspects: Sequence[Suspicion], sensor: Sensor, *kinds: str) -> bool:
    return any(one.name == sensor.name and one.kind in kinds for one in suspects)


def _told(followed: Sequence[Followed]) -> Iterator[Told]:
    """What references told: gains of all recordings once, the zero of each."""
    for i, one in enumerate(followed):
        unknown = np.full(len(one.zero), np.nan)
        gain, std = (unknown, unknown) if i else (one.gain, one.gain_std)
        yield Told.of(gain, std, one.zero, one.zero_std)


@dataclass(frozen=True, eq=False)
class _Noise:
    """Of readings at nominal gain, shape (n,), metres; NaN where not known."""

    value: Floats
    std: Floats


def _noise(joint: Joint, sources: Sources) -> _Noise:
    """Noise of the sensors on the move where there are references, else at rest or in poses."""
    if not sources.followed:
        value, std = np.full((2, len(joint.sensors)), np.nan)
        for held in sources.held:
            better = ~(std <= held.noise_std)
            value, std = np.where(better, held.noise, value), np.where(better, held.noise_std, std)
        return _Noise(value, std)
    followed = sources.followed
    value = followed[0].noise
    independent = sum(_independent(one) for one in followed)
    return _Noise(value, value / np.sqrt(2.0 * np.maximum(independent, 1.0)))


def _independent(one: Followed) -> Floats:
    """Independent rows of each sensor's misfit, shape (n,)."""
    return np.array(
        [0.0 if np.isnan(m).all() else independent_rows(m[:, None]) for m in one.misfit(False).T]
    )


def _shifted(
    joint: Joint, sources: Sources, noise: Floats, suspects: Sequence[Suspicion]
) -> Iterator[Suspicion]:
    """Sensors whose zero differs between recordings, besides those that are suspicious already."""
    zeros = [Zeros(one.recording.source, one.zero, one.zero_std) for one in sources.followed]
    known = {one.name for one in suspects}
    found = shifted([sensor.name for sensor in joint.sensors], zeros, noise)
    return (one for one in found if one.name not in known)


def _read(sources: Sources) -> Flags:
    """Which sensors were read where the shape is known, shape (n,)."""
    at_rest = [np.isfinite(one.noise) for one in sources.straight]
    moving = [(~np.isnan(one.lengths + one.expected)).any(axis=0) for one in sources.seen]
    return np.asarray(np.any([*at_rest, *moving], axis=0))


def _unread(joint: Joint, read: Flags) -> Iterator[str]:
    names = [sensor.name for sensor, one in zip(joint.sensors, read, strict=True) if not one]
    if names:
        yield (
            f"{joint.source}: recordings: no counts where the shape is known of "
            f"sensor{'' if len(names) == 1 else 's'} {', '.join(names)}, left as the file states"
        )


def _check_determined(
    joint: Joint, sources: Sources, found: Found, read: Flags, suspects: Sequence[Suspicion]
) -> None:
    """Check that gains are determined wherever the joint moved, and that there is something.

    Raises:
        InputError: names the sensors, and what would determine them.
    """
    if not read.any():
        raise InputError(
            f"{joint.source}: recordings: no sensor has counts where the shape is known; record "
            "counts and shapes at the same time"
        )
    if not sources.seen:
        return
    vague = ~(found.gain_std <= LARGEST_GAIN_STD * np.abs(found.gain)) | _still(sources)
    names = [
        sensor.name
        for j, sensor in enumerate(joint.sensors)
        if read[j] and vague[j] and not _is(suspects, sensor, *_LEFT_OUT)
    ]
    if names:
        these = "sensor" if len(names) == 1 else "sensors"
        raise InputError(
            f"{joint.source}: recordings: they do not determine the gain of {these} "
            f"{', '.join(names)} (within {100 * LARGEST_GAIN_STD:.0f} %); record the joint while "
            "it bends where and how these read, in both axes and to both sides"
        )


def _still(sources: Sources) -> Flags:
    """Which sensors bodies and markers move too little for gains that are not just expected.

    Without dense references gains are held near the nominal ones, and look certain without any
    motion.
    """
    if not sources.followed or any(one.reference.dense for one in sources.followed):
        return np.zeros(len(sources.step), dtype=np.bool_)
    moved = np.nanmax([np.nanstd(one.expected, axis=0) for one in sources.followed], axis=0)
    return np.asarray(moved < _LEAST_MOTION * sources.followed[0].noise)


def _delay(followed: Sequence[Followed]) -> tuple[float | None, float | None]:
    """By how much the sensors lag, all recordings together; None where none tells."""
    told = [
        (one.reference.delay_s, one.reference.delay_std_s)
        for one in followed
        if one.recording.timed and np.isfinite(one.reference.delay_std_s)
    ]
    stated = [seconds for seconds, std in told if std == 0]
    if stated:
        return float(np.mean(stated)), 0.0
    if not told:
        return None, None
    seconds, std = np.array(told).T
    weight = 1.0 / np.square(std)
    return float(seconds @ weight / weight.sum()), float(weight.sum() ** -0.5)


def _sensors(
    joint: Joint, found: Found, noise: _Noise, read: Flags, suspects: Sequence[Suspicion]
) -> tuple[SensorCalibration, ...]:
    return tuple(
        SensorCalibration(sensor.name)
        if not read[j] or _is(suspects, sensor, *_LEFT_OUT)
        else _sensor(sensor, j, found, noise, _is(suspects, sensor, "slipping"))
        for j, sensor in enumerate(joint.sensors)
    )


def _sensor(sensor: Sensor, j: int, found: Found, noise: _Noise, slips: bool) -> SensorCalibration:
    """What was found of one sensor, in counts and in metres that are true ones."""
    nominal, gain = sensor.metres_per_count, float(found.gain[j])
    known, zeroed = np.isfinite(found.gain_std[j]), np.isfinite(found.zero_std[j]) and not slips
    heard = np.isfinite(noise.value[j])
    counted = nominal**2 / 12.0  # variance that the step of the counts adds
    variance = max(float(noise.value[j]) ** 2 - counted, 0.0) if heard else 0.0
    return SensorCalibration(
        name=sensor.name,
        metres_per_count=nominal / gain if known else None,
        metres_per_count_std=float(abs(nominal) * found.gain_std[j] / gain**2) if known else None,
        zero=float(found.zero[j]) / nominal if zeroed else None,
        zero_std=float(found.zero_std[j]) / abs(nominal) if zeroed else None,
        noise=variance**0.5 / abs(gain) if heard else None,
        noise_std=float(noise.std[j]) / abs(gain) if heard else None,
    )
