"""The form of a calibration file: TOML, with the joint file's own keys and their deviations."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationError

from ccgen.errors import InputError
from ccgen.joint import toml
from ccgen.joint.calibration import Calibration, SensorCalibration
from ccgen.joint.messages import first_problem
from ccgen.joint.sensor_tables import MOST_SENSORS, Step
from ccgen.joint.specification import Joint
from ccgen.joint.table import Table

FORMAT = 1
"""Version of the form."""

_HINT = "`ccgen calibrate JOINT` writes one"
_KIND = toml.Kind("calibration file", _HINT, 'joint = "finger"')
_DIGITS = 12

Calibrations = Callable[[str], bytes | None]
"""Content of the calibration file that a joint file names; None where it is not to count."""

_Deviation = Annotated[float, Field(ge=0.0)]


class _SensorTable(Table):
    """One of [[sensor]]."""

    name: str = Field(description="the name of a sensor", examples=["u0"])
    metres_per_count: Step | None = Field(
        default=None, description="metres from 1e-12 to 1, or their negative", examples=[2.0e-6]
    )
    metres_per_count_std: _Deviation | None = Field(
        default=None, description="metres, 0 or more", examples=[2.0e-8]
    )
    zero: float | None = Field(default=None, description="a count", examples=[2048.0])
    zero_std: _Deviation | None = Field(
        default=None, description="counts, 0 or more", examples=[0.5]
    )
    noise: Annotated[float, Field(ge=0.0, le=1e3)] | None = Field(
        default=None, description="metres, 0 or more", examples=[2.0e-5]
    )
    noise_std: _Deviation | None = Field(
        default=None, description="metres, 0 or more", examples=[1.0e-6]
    )


class _CalibrationTable(Table):
    """The whole file."""

    format: int = Field(ge=FORMAT, le=FORMAT, description=f"{FORMAT}", examples=[FORMAT])
    joint: str = Field(description="the joint's name", examples=["finger"])
    fingerprint: str = Field(description="a hash of the sensors", examples=["0123456789abcdef"])
    delay: float | None = Field(default=None, description="seconds", examples=[0.012])
    delay_std: _Deviation | None = Field(
        default=None, description="seconds, 0 or more", examples=[0.001]
    )
    recordings: dict[str, str] = Field(
        default={}, description="hashes of files", examples=[{"run1.csv": "0123456789abcdef"}]
    )
    sensor: list[_SensorTable] = Field(
        min_length=1,
        max_length=MOST_SENSORS,
        description=f"1 to {MOST_SENSORS} tables",
        examples=["[[sensor]]"],
    )


def beside(folder: Path) -> Calibrations:
    """Read calibration files whose paths lead from a folder."""
    return lambda name: toml.read_bytes(folder / name, _KIND)


def uncalibrated(name: str) -> None:
    """Read no calibration file."""
    return


def parse_calibration(data: bytes, source: str) -> Calibration:
    """Check the content of a calibration file.

    Args:
        data: what the file holds.
        source: names it in messages.

    Raises:
        InputError: in one line the file, the key (or line), what is wrong, what would be right.
    """
    document = toml.parse(toml.decoded(data, source), source, _KIND)
    try:
        table = _CalibrationTable.model_validate(document)
    except ValidationError as error:
        problem = first_problem(error, _CalibrationTable)
        raise InputError(f"{source}: {problem}; {_HINT}") from None
    names = [sensor.name for sensor in table.sensor]
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise InputError(
            f"{source}: sensor[{names.index(twice)}].name: {json.dumps(twice)} stands there twice; "
            f"remove one of them; {_HINT}"
        )
    return Calibration(
        joint=table.joint,
        fingerprint=table.fingerprint,
        sensors=tuple(SensorCalibration(**sensor.model_dump()) for sensor in table.sensor),
        delay=table.delay,
        delay_std=table.delay_std,
        recordings=tuple(table.recordings.items()),
    )


def check_replaceable(path: Path, joint: Joint, joint_file: Path) -> None:
    """Check that a joint's calibration may take the place of what lies there.

    What was found before may go, whole or not; what others are read from may not.

    Raises:
        InputError: it is the calibration of another joint, the joint file, or a recording.
    """
    try:
        before = toml.parse(toml.read(path, _KIND), str(path), _KIND) if path.is_file() else {}
    except InputError:
        before = {}
    remedy = f'write another, such as calibration = "{joint.name}.calibration.toml"'
    other = before.get("joint") if "fingerprint" in before else joint.name
    if other != joint.name:
        raise InputError(
            f'{joint_file}: calibration: {path.name} is of joint "{other}", this one is '
            f'"{joint.name}", and calibrate would write it anew; {remedy}'
        )
    read = [joint_file]
    for one in joint.recordings:
        read += [one.folder / name for name in (one.file, one.counts, one.dbc) if name]
    if any(path.resolve() == place.resolve() for place in read):
        raise InputError(
            f"{joint_file}: calibration: {path.name} is what the joint is read from, and calibrate "
            f"would write it anew; {remedy}"
        )


def calibration_text(calibration: Calibration) -> str:
    """Return what a calibration file holds, 12 digits a number; `parse_calibration` reads it."""
    return "\n".join(_lines(calibration)) + "\n"


def _lines(calibration: Calibration) -> Iterator[str]:
    yield (
        f"# What recordings of joint {calibration.joint} told of its sensors, by `ccgen calibrate`."
    )
    yield "# It replaces what the joint file states, until that states other sensors."
    yield from ("", f"format = {FORMAT}", f"joint = {json.dumps(calibration.joint)}")
    yield f"fingerprint = {json.dumps(calibration.fingerprint)}"
    if calibration.delay is not None:
        yield f"delay = {_number(calibration.delay)}  # s by which the sensors lag"
    if calibration.delay_std is not None:
        yield f"delay_std = {_number(calibration.delay_std)}"
    if calibration.recordings:
        yield from ("", "[recordings]")
        yield from (f"{_string(name)} = {_string(sha)}" for name, sha in calibration.recordings)
    for sensor in calibration.sensors:
        yield from ("", "[[sensor]]", f"name = {_string(sensor.name)}")
        for key in _SensorTable.model_fields:
            value = getattr(sensor, key)
            if key != "name" and value is not None:
                yield f"{key} = {_number(value)}"


def _number(value: float) -> str:
    """A float of TOML, which is written with a point or an exponent."""
    text = f"{value:.{_DIGITS}g}"
    return text if any(sign in text for sign in ".e") else f"{text}.0"


def _string(text: str) -> str:
    """A string of TOML on one line; bytes of a name that are no text become question marks."""
    whole = text.encode("utf-8", "replace").decode("utf-8")
    return json.dumps(whole, ensure_ascii=False).replace("\x7f", "\\u007f")
