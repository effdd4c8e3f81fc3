"""An exported folder's integer reference model as C, for drivers that hold a node against it."""

from collections.abc import Iterable
from pathlib import Path

from ccgen.fixedpoint import AxisModel
from ccgen.fixedpoint.fallback import Fallbacks
from ccgen.fixedpoint.model import SensorRanges
from ccgen.targets.exported import open_exported


def reference(folder: Path) -> str:
    """Axes and sensors of the model: the text of fuzz_reference.h."""
    exported = open_exported(folder)
    axes = ", ".join(
        _axis(axis, exported.guarded.fallbacks.get(name))
        for name, axis in exported.model.axes.items()
    )
    sensors = ", ".join(_sensors(exported.model.readings, exported.layout.missing_bits))
    return (
        f"static const reference_t reference[] = {{{axes}}};\n"
        f"static const reference_sensor_t reference_sensors[PORT_SENSORS] = {{{sensors}}};\n"
    )


def _axis(model: AxisModel, fallbacks: Fallbacks | None) -> str:
    rows = [None] * model.sensors if fallbacks is None else fallbacks.rows
    fields = [str(n) for n in (model.first, model.sensors, model.segments, model.shift)]
    fields.append(_numbers(model.bias))
    fields.append(_table(model.weights))
    fields.append(str("uvh".index(model.axis)))
    fields.append(f"{{{', '.join('false' if one is None else 'true' for one in rows)}}}")
    fields.append(f"{{{', '.join('{{0}}' if one is None else _table(one) for one in rows)}}}")
    return f"{{{', '.join(fields)}}}"


def _sensors(readings: SensorRanges, bits: Iterable[int]) -> Iterable[str]:
    low, high, relative = readings.minimum, readings.maximum, readings.relative
    ranges = [low, high, low - high, high - low, low, high]
    if relative is not None:
        ranges = [low, high, relative.minimum, relative.maximum]
        ranges += [relative.zero_minimum, relative.zero_maximum]
    for j, bit in enumerate(bits):
        yield f"{_numbers(values[j] for values in ranges)[:-1]}, {bit}}}"


def _table(rows: Iterable[Iterable[int]]) -> str:
    return f"{{{', '.join(map(_numbers, rows))}}}"


def _numbers(values: Iterable[int]) -> str:
    return f"{{{', '.join(f'INT64_C({value})' for value in values)}}}"
