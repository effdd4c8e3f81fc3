"""What a calibration says of a joint's sensors, and the joint with it in place.

Gains, zeros and noise that were found replace those that the joint file states. They belong to
sensors as they were when they were found: a hash tells whether the file still states the same ones.
"""

import hashlib
import json
from dataclasses import dataclass, replace

from ccgen.joint.messages import KeyProblemError
from ccgen.joint.specification import (
    CALIBRATED,
    AxisSensors,
    Joint,
    Sensor,
    Transducer,
    count_limits,
)


@dataclass(frozen=True)
class SensorCalibration:
    """What was found of one sensor; None where it was not."""

    name: str
    metres_per_count: float | None = None
    """Negative where the count falls as the sensor lengthens."""
    metres_per_count_std: float | None = None
    zero: float | None = None
    """Count of the straight joint."""
    zero_std: float | None = None
    noise: float | None = None
    """One standard deviation of the length besides the step of the counts, metres."""
    noise_std: float | None = None


@dataclass(frozen=True)
class Calibration:
    """What a calibration file holds; standard deviations beside the values."""

    joint: str
    """Name of the joint."""
    fingerprint: str
    """Of the sensors that were calibrated, `sensors_fingerprint`."""
    sensors: tuple[SensorCalibration, ...]
    delay: float | None = None
    """Seconds by which the sensors lag behind the reference; None without one."""
    delay_std: float | None = None
    recordings: tuple[tuple[str, str], ...] = ()
    """Files that it was found from, as the joint file names them, with their SHA-256."""


def sensors_fingerprint(joint: Joint) -> str:
    """SHA-256 of what a joint file states of its sensors, without what a calibration replaces.

    Nominal gains count: where they change, so did the sensors.

    Args:
        joint: without its calibration.
    """
    sensors = [
        [s.name, s.start, s.end, s.angle, s.radius, s.metres_per_count, s.bits, s.signed]
        for s in joint.sensors
    ]
    stated = [joint.geometry.segments, joint.geometry.length, sensors]
    return hashlib.sha256(json.dumps(stated).encode()).hexdigest()


def calibrated(joint: Joint, calibration: Calibration) -> Joint:
    """Return the joint with what was found of its sensors.

    Args:
        joint: as its file states it.
        calibration: of that joint.

    Raises:
        KeyProblemError: it is of another joint or of other sensors, or a zero is no count.
    """
    again = f"run `ccgen calibrate {joint.source}` again"
    if calibration.joint != joint.name:
        raise KeyProblemError(
            f'calibration: is of joint "{calibration.joint}", this one is "{joint.name}"; '
            f"name the file of this joint, or {again}"
        )
    if calibration.fingerprint != sensors_fingerprint(joint):
        raise KeyProblemError(
            "calibration: is older than the sensors, which the joint file states otherwise now; "
            f"{again}, or remove the key"
        )
    found = {one.name: one for one in calibration.sensors}
    unknown = sorted(found.keys() - {sensor.name for sensor in joint.sensors})
    if unknown:
        raise KeyProblemError(f'calibration: the joint has no sensor "{unknown[0]}"; {again}')
    sensors = tuple(
        _calibrated(sensor, found[sensor.name], again) if sensor.name in found else sensor
        for sensor in joint.sensors
    )
    whole = replace(joint, sensors=sensors)
    return replace(whole, u=_alike(whole, "u"), v=_alike(whole, "v"))


def _calibrated(sensor: Sensor, found: SensorCalibration, again: str) -> Sensor:
    zero = sensor.zero if found.zero is None else round(found.zero)
    low, high = sensor.range or count_limits(sensor.bits, sensor.signed)
    if found.zero is not None and not low <= round(found.zero) <= high:
        raise KeyProblemError(
            f'calibration: zero {found.zero:g} of sensor "{sensor.name}" is no count from {low} to '
            f"{high}, which the joint file states; correct bits or range there, or {again}"
        )
    gain, noise = found.metres_per_count, found.noise
    return replace(
        sensor,
        metres_per_count=sensor.metres_per_count if gain is None else gain,
        zero=zero,
        zero_origin=sensor.zero_origin if found.zero is None else CALIBRATED,
        noise=sensor.noise if noise is None else noise,
    )


def _alike(joint: Joint, axis: str) -> AxisSensors | None:
    """The paper's set of an axis, with what its sensors have in common now."""
    stated = joint.u if axis == "u" else joint.v
    if stated is None:
        return None
    own = {_transducer(sensor) for sensor in joint.sensors[joint.members(axis)]}
    return replace(stated, transducer=own.pop() if len(own) == 1 else None)


def _transducer(sensor: Sensor) -> Transducer:
    return Transducer(
        bits=sensor.bits,
        metres_per_count=sensor.metres_per_count,
        noise=sensor.noise,
        range=sensor.range,
        signed=sensor.signed,
        zero=sensor.zero,
        gain_tolerance=sensor.gain_tolerance,
    )
