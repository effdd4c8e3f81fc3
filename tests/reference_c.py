"""An exported folder's integer reference model as C, for drivers that hold a node against it."""

from collections.abc import Iterable
from pathlib import Path

from ccgen.fixedpoint import AxisModel
from ccgen.fixedpoint.model import SensorRanges
from ccgen.targets.exported import open_exported


def reference(folder: Path) -> str:
    """Axes and sensors of the model: the text of fuzz_reference.h."""
    exported = open_exported(folder)
    axes = ", ".join(map(_axis, exported.model.axes.values()))
    sensors = ", ".join(_sensors(exported.model.readings, exported.layout.missing_bits))
    return (
        f"static const reference_t reference[] = {{{axes}}};\n"
        f"static const reference_sensor_t reference_sensors[PORT_SENSORS] = {{{sensors}}};\n"
    )


def _axis(model: AxisModel) -> str:
    fields = [str(n) for n in (model.first, model.sensors, model.segments, model.shift)]
    fields.append(_numbers(model.bias))
    fields.append(f"{{{', '.join(map(_numbers, model.weights))}}}")
    return f"{{{', '.join(fields)}}}"


def _sensors(readings: SensorRanges, bits: Iterable[int]) -> Iterable[str]:
    low, high, relative = readings.minimum, readings.maximum, readings.relative
    ranges = [low, high, low - high, high - low, low, high]
    if relative is not None:
        ranges = [low, high, relative.minimum, relative.maximum]
        ranges += [relative.zero_minimum, relative.zero_maximum]
    for j, bit in enumerate(bits):
        yield f"{_numbers(values[j] for values in ranges)[:-1]}, {bit}}}"


def _numbers(values: Iterable[int]) -> str:
    return f"{{{', '.join(f'INT64_C({value})' for value in values)}}}"
