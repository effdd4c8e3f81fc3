"""From the bytes of a joint file to a `Joint`, through TOML and the checked tables."""

import math
from pathlib import Path

from pydantic import ValidationError

from ccgen.errors import InputError
from ccgen.joint import toml
from ccgen.joint.load_files import load_ranges
from ccgen.joint.messages import KeyProblemError, first_problem, toml_value
from ccgen.joint.names import LONGEST_NAME, name_problem
from ccgen.joint.recordings import recording_files
from ccgen.joint.sensors import axis_sensors, own_keys, sensor_list
from ccgen.joint.specification import AXES, AxisSensors, Can, Geometry, Joint, ShapeSettings
from ccgen.joint.tables import CanTable, JointTable, ShapesTable

_KIND = toml.Kind("joint file", "`ccgen init NAME` writes one that works", "segments = 12")


def read_joint(path: Path) -> Joint:
    """Read and check a joint file.

    Raises:
        InputError: in one line the file, the key (or line), what is wrong, what would be right.
    """
    return read_joint_and_bytes(path)[0]


def read_joint_and_bytes(path: Path) -> tuple[Joint, bytes]:
    """Read and check a joint file, and return its bytes too: a pipe can be read but once.

    Raises:
        InputError: as `read_joint`.
    """
    data = toml.read_bytes(path, _KIND)
    return parse_joint(toml.decoded(data, str(path)), str(path), path.parent), data


def parse_joint(text: str, source: str, folder: Path = Path()) -> Joint:
    """Check the text of a joint file.

    Args:
        text: what the file holds.
        source: names it in messages.
        folder: where the paths in it lead from.

    Raises:
        InputError: as `read_joint`.
    """
    document = toml.parse(text, source, _KIND)
    try:
        return _joint(JointTable.model_validate(document), source, folder)
    except ValidationError as error:
        raise InputError(f"{source}: {first_problem(error, JointTable)}") from None
    except KeyProblemError as problem:
        raise InputError(f"{source}: {problem}") from None


def _joint(table: JointTable, source: str, folder: Path) -> Joint:
    _check_name(table.name)
    segments, precision = table.geometry.segments, table.fixed_point.precision
    u, v = (axis_sensors(table.sensors, axis, segments, precision) for axis in AXES)
    _check_method(table.estimator.method, {"u": u, "v": v})
    _check_ids(table.can, _fewest_frames(table, len(u.spans) + len(v.spans)))
    return Joint(
        name=table.name,
        geometry=Geometry(
            segments=segments,
            length=float(table.geometry.length),
            range_of_motion=math.radians(table.geometry.range_of_motion),
        ),
        sensors=(*sensor_list("u", u), *sensor_list("v", v)),
        axes=AXES,
        parts=((0, len(u.spans)), (len(u.spans), len(u.spans) + len(v.spans))),
        u=u,
        v=v,
        shapes=_shapes(table.shapes),
        method=table.estimator.method,
        precision=precision,
        can=Can(**table.can.model_dump()),
        source=source,
        own_keys=frozenset(own_keys(table.sensors)),
        recordings=recording_files(table, folder),
        loads=load_ranges(table),
    )


def _check_name(name: str) -> None:
    problem = name_problem(name)
    if problem is not None:
        raise KeyProblemError(
            f"name: {toml_value(name)} {problem}; "
            f'write a C identifier of at most {LONGEST_NAME} characters, such as "shoulder"'
        )


def _shapes(table: ShapesTable) -> ShapeSettings:
    for i, case in enumerate(table.cases):
        if case in table.cases[:i]:
            raise KeyProblemError(
                f'shapes.cases[{i}]: "{case}" stands there twice; write each case once'
            )
    return ShapeSettings(tuple(table.cases), table.fit_samples, table.score_samples)


def _check_method(method: str, axes: dict[str, AxisSensors]) -> None:
    unknown = [name for name, axis in axes.items() if axis.transducer.noise is None]
    if method == "noise-aware" and unknown:
        table = "sensors" if len(unknown) == len(axes) else f"sensors.{unknown[0]}"
        raise KeyProblemError(
            f'{table}.transducer.noise: missing, but method = "noise-aware" weighs by it; '
            'write noise = 2e-05 (m, one standard deviation), or method = "wam"'
        )


def _fewest_frames(table: JointTable, sensors: int) -> int:
    """Return how many frames the joint needs at least: lengths, angles, tip and status.

    What counts of more than 24 bits need is known only with their range, in `ccgen.can.layout`.
    """
    payload = 61 if table.can.fd else 6
    count_bytes, angle_bytes = (2, 2) if table.fixed_point.precision == 16 else (3, 4)
    lengths = math.ceil(sensors / (payload // count_bytes))
    angles = math.ceil(2 * table.geometry.segments / (payload // angle_bytes))
    return lengths + angles + 2


def _check_ids(can: CanTable, frames: int) -> None:
    bits = 29 if can.extended else 11
    highest = 2**bits - frames
    if can.base_id > highest:
        raise KeyProblemError(
            f"can.base_id: {frames} frames from {can.base_id:#x} on exceed {bits} bits; write at "
            f"most {highest:#x}" + ("" if can.extended else ", or extended = true")
        )
