"""Sensors that a file lists one by one in [[sensor]], anywhere around the joint."""

from collections.abc import Iterator

from ccgen.joint.layouts import AnySpan
from ccgen.joint.messages import KeyProblemError, missing_key, toml_value
from ccgen.joint.names import LONGEST_NAME, sensor_name_problem
from ccgen.joint.sensor_tables import SensorsTable, SensorTable
from ccgen.joint.sensors import is_each, sensor_of
from ccgen.joint.spans import metres_span, segments_span
from ccgen.joint.specification import Geometry, Sensor
from ccgen.joint.tables import JointTable
from ccgen.joint.transducers import Stated, transducer


def listed_sensors(table: JointTable, geometry: Geometry) -> tuple[Sensor, ...]:
    """Return the sensors of [[sensor]] in the order of the file.

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    _check_alone(table.sensors)
    names = [sensor.name for sensor in table.sensor]
    for i, name in enumerate(names):
        _check_name(f"sensor[{i}].name", name, names[:i])
    return tuple(_sensor(table, i, geometry) for i in range(len(names)))


def own_keys(table: JointTable) -> Iterator[str]:
    """Full names of the keys in each [[sensor]]."""
    for i, sensor in enumerate(table.sensor):
        yield from (f"sensor[{i}].{key}" for key in sorted(sensor.model_fields_set))


def _check_alone(table: SensorsTable) -> None:
    """Check that [sensors] holds nothing but the transducer's keys that all sensors share."""
    beside = sorted(table.model_fields_set - {"transducer"})
    if beside:
        raise KeyProblemError(
            f"sensors.{beside[0]}: stands beside [[sensor]], which says it of each sensor; "
            "remove one of them"
        )


def _check_name(key: str, name: str, before: list[str]) -> None:
    problem = sensor_name_problem(name)
    if problem is not None:
        raise KeyProblemError(
            f"{key}: {toml_value(name)} {problem}; "
            f'write a C identifier of at most {LONGEST_NAME} characters, such as "near_left"'
        )
    # Capitals make constants in C of a name, so that names must differ without regard to them.
    same = next((i for i, other in enumerate(before) if other.lower() == name.lower()), None)
    if same is not None:
        how = "is" if before[same] == name else "differs in capitals only from"
        raise KeyProblemError(
            f"{key}: {toml_value(name)} {how} the name of sensor[{same}]; "
            "give each sensor a name of its own"
        )


def _sensor(table: JointTable, i: int, geometry: Geometry) -> Sensor:
    sensor = table.sensor[i]
    counts = transducer(lambda key: _stated(table, i, key), table.fixed_point.precision)
    return sensor_of(
        sensor.name, _span(sensor, i, geometry), sensor.angle, float(sensor.radius), counts
    )


def _span(sensor: SensorTable, i: int, geometry: Geometry) -> AnySpan:
    if sensor.span is not None and sensor.span_m is not None:
        raise KeyProblemError(
            f"sensor[{i}].span_m: stands beside span; remove one of them, either says it all"
        )
    if sensor.span is not None:
        return segments_span(f"sensor[{i}].span", sensor.span, geometry.segments)
    if sensor.span_m is not None:
        return metres_span(f"sensor[{i}].span_m", sensor.span_m, geometry)
    raise KeyProblemError(missing_key(f"sensor[{i}].span", SensorTable.model_fields["span"]))


def _stated(table: JointTable, i: int, key: str) -> Stated:
    """What the file says of a key of the transducer of sensor i, for itself or for all."""
    own = getattr(table.sensor[i], key)
    if own is not None:
        return Stated(own, f"sensor[{i}].{key}")
    place, value = f"sensors.transducer.{key}", getattr(table.sensors.transducer, key)
    if not is_each(value, place):
        return Stated(value, place)
    if len(value) != len(table.sensor):
        raise KeyProblemError(
            f"{place}: {len(value)} values for {len(table.sensor)} sensors; "
            "write one value, or one for each"
        )
    return Stated(value[i], f"{place}[{i}]")
