"""From the bytes of a joint file to a `Joint`, through TOML and the checked tables."""

from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from ccgen.errors import ArgumentError, InputError
from ccgen.joint import listed, sensors, toml
from ccgen.joint.axes import check_seen, output_axes, parts_of
from ccgen.joint.calibration import calibrated
from ccgen.joint.calibration_file import Calibrations, beside, parse_calibration
from ccgen.joint.frames import SINGLE_FRAMES, frames_for
from ccgen.joint.geometry import geometry_of
from ccgen.joint.load_files import load_ranges
from ccgen.joint.messages import KeyProblemError, first_problem, toml_value
from ccgen.joint.names import LONGEST_NAME, name_problem
from ccgen.joint.places import own_place
from ccgen.joint.recordings import recording_files
from ccgen.joint.specification import (
    AXES,
    PUBLISHED,
    AxisSensors,
    Can,
    Geometry,
    Joint,
    Sensor,
    ShapeSettings,
)
from ccgen.joint.tables import CanTable, JointTable

_SOURCES = {
    "cases": "a load case to shapes.cases",
    "loads": "[loads]",
    "recordings": '[[recordings]] of use = "fit"',
}

_KIND = toml.Kind("joint file", "`ccgen init NAME` writes one that works", "segments = 12")


def load(path: str | Path) -> Joint:
    """Read and check a joint file.

    Raises:
        InputError: in one line the file, the key (or line), what is wrong, what would be right.
    """
    return read_joint(Path(path))


def parse(text: str, folder: str | Path = ".") -> Joint:
    """Check the text of a joint file.

    Args:
        text: what the file would hold.
        folder: where the paths in it lead from.

    Raises:
        ArgumentError: it is no text; InputError: as `load`.
    """
    if not isinstance(text, str):
        raise ArgumentError("is no text; give what a joint file holds, or load its path", "text")
    return parse_joint(text, "joint.toml", Path(folder))


def read_joint(path: Path, calibrations: Calibrations | None = None) -> Joint:
    """Read and check a joint file, which may be a pipe: it is read once.

    Args:
        path: where it is.
        calibrations: as of `parse_joint`.

    Raises:
        InputError: in one line the file, the key (or line), what is wrong, what would be right.
    """
    data = toml.read_bytes(path, _KIND)
    joint = parse_joint(toml.decoded(data, str(path)), str(path), path.parent, calibrations)
    return replace(joint, content=data)


def parse_joint(
    text: str, source: str, folder: Path = Path(), calibrations: Calibrations | None = None
) -> Joint:
    """Check the text of a joint file.

    Args:
        text: what the file holds.
        source: names it in messages.
        folder: where the paths in it lead from.
        calibrations: gives the calibration file that it names; the one at its path by default.

    Raises:
        InputError: as `read_joint`.
    """
    document = toml.parse(text, source, _KIND)
    try:
        joint = _joint(JointTable.model_validate(document), source, folder)
        joint = _with_calibration(joint, calibrations or beside(folder))
        _check_method(joint)
    except ValidationError as error:
        raise InputError(f"{source}: {first_problem(error, JointTable)}") from None
    except KeyProblemError as problem:
        raise InputError(f"{source}: {problem}") from None
    return replace(joint, content=text.encode("utf-8", "surrogateescape"))


def _joint(table: JointTable, source: str, folder: Path) -> Joint:
    _check_name(table.name)
    loads, geometry = load_ranges(table), geometry_of(table)
    elongates = geometry.elongation is not None
    axes = output_axes(table, elongates)
    found = _sensors(table, axes, geometry)
    joint = Joint(
        name=table.name,
        geometry=geometry,
        sensors=found.sensors,
        axes=axes,
        parts=parts_of(found.sensors, axes, elongates),
        u=found.sets.get("u"),
        v=found.sets.get("v"),
        shapes=_shapes(table),
        method=table.estimator.method,
        fallback=table.estimator.fallback,
        check=table.estimator.check,
        false_alarms=table.estimator.false_alarms,
        precision=table.fixed_point.precision,
        float_kinematics=table.kinematics.float,
        can=_can(table.can),
        source=source,
        own_keys=frozenset({*sensors.own_keys(table.sensors), *listed.own_keys(table)}),
        recordings=recording_files(table, folder),
        loads=loads,
        calibration=table.calibration,
    )
    _check_ids(table.can, _fewest_frames(table, joint))
    return joint


def _with_calibration(joint: Joint, calibrations: Calibrations) -> Joint:
    """The joint with the calibration that its file names.

    Raises:
        InputError: there is none, or it is damaged; KeyProblemError: it is not of this joint.
    """
    if joint.calibration is None:
        return joint
    try:
        data = calibrations(joint.calibration)
        if data is None:
            return joint
        calibration = parse_calibration(data, joint.calibration)
    except InputError as error:
        raise InputError(f"{joint.source}: calibration: {error}") from None
    return replace(calibrated(joint, calibration), calibration_content=data)


@dataclass(frozen=True)
class _Sensors:
    """All sensors of a joint, and the paper's sets that they are where the file has those."""

    sensors: tuple[Sensor, ...]
    sets: dict[str, AxisSensors]


def _sensors(table: JointTable, axes: tuple[str, ...], geometry: Geometry) -> _Sensors:
    if table.sensor:
        listed_ones = listed.listed_sensors(table, geometry)
        check_seen(listed_ones, axes, geometry)
        return _Sensors(listed_ones, {})
    for axis in AXES:
        if axis in table.sensors.model_fields_set and axis not in axes:
            raise KeyProblemError(
                f'sensors.{axis}: stands there, but estimator.axes leaves "{axis}" out; '
                "remove one of them"
            )
    bending = [axis for axis in AXES if axis in axes]
    sets = sensors.sensor_sets(table.sensors, bending, geometry, table.fixed_point.precision)
    return _Sensors(
        tuple(sensor for axis in bending for sensor in sets[axis][1]),
        {axis: alike for axis, (alike, _) in sets.items()},
    )


def _check_name(name: str) -> None:
    problem = name_problem(name)
    if problem is not None:
        raise KeyProblemError(
            f"name: {toml_value(name)} {problem}; "
            f'write a C identifier of at most {LONGEST_NAME} characters, such as "shoulder"'
        )


def _shapes(table: JointTable) -> ShapeSettings:
    shapes = table.shapes
    for i, case in enumerate(shapes.cases):
        if case in shapes.cases[:i]:
            raise KeyProblemError(
                f'shapes.cases[{i}]: "{case}" stands there twice; write each case once'
            )
    return ShapeSettings(
        tuple(shapes.cases), shapes.fit_samples, shapes.score_samples, _source_weights(table)
    )


def _source_weights(table: JointTable) -> tuple[tuple[str, float], ...]:
    """Return the stated weights of sources.

    Raises:
        KeyProblemError: a source that the file does not have, or none left to fit to.
    """
    there = {
        "cases": bool(table.shapes.cases),
        "loads": "loads" in table.model_fields_set,
        "recordings": any(recording.use == "fit" for recording in table.recordings),
    }
    if not any(there.values()):
        raise KeyProblemError(
            "shapes.cases: [] leaves no shapes to fit to; name a load case there, or state [loads] "
            "or [[recordings]]"
        )
    stated = {
        name: weight for name in there if (weight := getattr(table.shapes.weight, name)) is not None
    }
    for name, weight in stated.items():
        if weight and not there[name]:
            raise KeyProblemError(
                f"shapes.weight.{name}: {weight} for a source that is not there; "
                f"remove it, or add {_SOURCES[name]}"
            )
    if all(stated.get(name) == 0.0 for name in there if there[name]):
        raise KeyProblemError(
            "shapes.weight: is 0 for every source; write a weight above 0 for one of them"
        )
    return tuple(stated.items())


def _check_method(joint: Joint) -> None:
    """Check that what the method weighs by is known of all sensors, or may be by recordings."""
    if any(recording.use == "fit" for recording in joint.recordings):
        return
    silent = [j for j, sensor in enumerate(joint.sensors) if sensor.noise is None]
    if joint.method == "noise-aware" and silent:
        everywhere = len(silent) == len(joint.sensors)
        place = "sensors.transducer.noise" if everywhere else own_place(joint, silent[0], "noise")
        raise KeyProblemError(
            f'{place}: missing, but method = "noise-aware" weighs by it; '
            'write noise = 2e-05 (m, one standard deviation), or method = "wam"'
        )


def _fewest_frames(table: JointTable, joint: Joint) -> int:
    """Return how many identifiers the joint needs at least.

    What counts of more than 24 bits need is known only with their range, in `ccgen.can.layout`.
    """
    count_bytes, angle_bytes = (2, 2) if joint.precision == 16 else (3, 4)
    rows = {"u": joint.geometry.segments, "v": joint.geometry.segments}
    rows["h"] = len(joint.geometry.sections)
    fd = table.can.fd
    lengths = frames_for(len(joint.sensors), fd, count_bytes)
    angles = frames_for(sum(rows[axis] for axis in joint.axes), fd, angle_bytes)
    return lengths + angles + SINGLE_FRAMES


def _can(table: CanTable) -> Can:
    values = table.model_dump()
    doubled = [kind for kind in PUBLISHED if values["publish"].count(kind) > 1]
    if doubled:
        raise KeyProblemError(f'can.publish: names "{doubled[0]}" twice; write each kind once')
    if table.rate_switch and not table.fd:
        raise KeyProblemError(
            "can.rate_switch: true, but classic CAN has one bit rate; leave it out, or fd = true"
        )
    published = tuple(kind for kind in PUBLISHED if kind in values["publish"])
    return Can(**(values | {"publish": published}))


def _check_ids(can: CanTable, frames: int) -> None:
    bits = 29 if can.extended else 11
    highest = 2**bits - frames
    if can.base_id > highest:
        raise KeyProblemError(
            f"can.base_id: {frames} frames from {can.base_id:#x} on exceed {bits} bits; write at "
            f"most {highest:#x}" + ("" if can.extended else ", or extended = true")
        )
