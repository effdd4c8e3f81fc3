"""What the templates know of the estimator: sensors, axes, and the functions that evaluate them."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ccgen.can.layout import FrameLayout
from ccgen.digits import at_least
from ccgen.estimation import ErrorRow, noise_gain
from ccgen.export.fields import Field, fields_of
from ccgen.export.literals import float_literal, rows_context
from ccgen.fixedpoint import AxisModel, Fit
from ccgen.fixedpoint.fallback import Fallbacks
from ccgen.fixedpoint.model import Integers, RelativeRange, SensorRanges
from ccgen.joint import AXES, Joint, Sensor
from ccgen.sensing.arrangement import angle_degrees
from ccgen.sensing.noise import stated_noise

_ROUNDING = 1e-9
"""% of ROM below which an error is none."""

_SHAPES = {
    "cases": "simulated shapes",
    "loads": "shapes of the stated loads",
    "other loads": "shapes of other loads",
}

_EVALUATED = (
    "sensors", "shift", "fraction_bits", "saturates", "narrow", "bias", "biases", "rows", "without",
)  # fmt: skip
"""What an axis's code depends on: axes that agree in all of it share tables and code."""

_ABOUT = {"u": "Bending about x (u)", "v": "Bending about y (v)"}


def model_context(fitted: Fit, layout: FrameLayout) -> dict[str, Any]:
    """Sensors, formats, weights and accuracy of all axes."""
    joint, model = fitted.sensed, fitted.model
    fields = fields_of(joint, layout)
    axes = _axes_context(fitted, fields)
    return {
        "sensors": {
            "number": len(joint.sensors),
            "said": " + ".join(str(field.sensors) for field in fields),
            "names": [] if layout.own_sets else layout.sensors,
            "table": _sensors_context(joint, model.readings),
        },
        "reads_said": ", ".join(f"counts.{field.field}" for field in fields),
        "bending": [axis for axis in joint.axes if axis in AXES],
        "fields": _fields_context(joint, model.readings, fields),
        "relative": model.readings.bounds_differences,
        "axes": axes,
        "values": model.values,
        "kernels": _kernels(axes, joint, bool(fitted.guarded.groups)),
        "angles_said": _angles_said(joint),
        "estimated_said": _estimated_said(joint),
        "mask_said": _mask_said(fields),
        "columns_said": _columns_said(joint),
    }


def _angles_said(joint: Joint) -> str:
    bending = " and ".join(_ABOUT[axis] for axis in joint.axes if axis in _ABOUT)
    said = bending.replace(" and Bending", " and") + " of every segment"
    return said + (", elongation (h) of every section" if "h" in joint.axes else "")


def _estimated_said(joint: Joint) -> str:
    sections = " and the elongation of all sections" if "h" in joint.axes else ""
    return f"the angles of all segments{sections}"


def _columns_said(joint: Joint) -> str:
    first, *more = joint.axes
    rest = [f"then {axis}{' of every section' if axis == 'h' else ''}" for axis in more]
    return ", ".join([f"{first} of segment 0 to the last", *rest])


def _mask_said(fields: Sequence[Field]) -> str:
    said = []
    for field in fields:
        which = "sensor j" if field.field == "sensor" else f"sensor j of axis {field.field}"
        said.append(f"bit {f'{field.bit} + ' if field.bit else ''}j: {which}")
    return ", ".join(said)


def _fields_context(
    joint: Joint, readings: SensorRanges, fields: Sequence[Field]
) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for field in fields:
        record = _counted(readings, field)
        tables = [one for one in found if one["tables"] == one["own_tables"]]
        same = (k for k, one in enumerate(tables) if _agree(one, record, list(record)))
        number = next(same, len(tables))
        found.append(
            {
                **asdict(field),
                **record,
                "own_tables": field.tables,
                "tables": [*tables, asdict(field)][number]["tables"],
                "table": number,
                "spans": [_span_said(sensor) for sensor in joint.sensors[field.part]],
            }
        )
    return found


def _counted(readings: SensorRanges, field: Field) -> dict[str, list[int]]:
    """What a list's checks depend on: lists that agree in all of it share tables."""
    arrays = {key: getattr(readings, key) for key in ("minimum", "maximum", "zero")}
    if readings.relative is not None:
        arrays |= relative_arrays(readings.relative)
    return {key: values[field.part].tolist() for key, values in arrays.items()}


def relative_arrays(relative: RelativeRange) -> dict[str, Integers]:
    """Ranges relative to a zero under the names that they have in C."""
    return {
        "difference_minimum": relative.minimum,
        "difference_maximum": relative.maximum,
        "zero_minimum": relative.zero_minimum,
        "zero_maximum": relative.zero_maximum,
    }


def _sensors_context(joint: Joint, readings: SensorRanges) -> list[dict[str, Any]]:
    rows = [
        {
            "name": sensor.name,
            "where": _where_said(sensor),
            "angle": f"{angle_degrees(sensor):.4g}",
            "radius_mm": f"{1000.0 * sensor.radius:.6g}",
            "micrometres_per_count": f"{1e6 * sensor.metres_per_count:.6g}",
        }
        for sensor in joint.sensors
    ]
    arrays = {key: getattr(readings, key) for key in ("minimum", "maximum", "zero")}
    if readings.relative is not None:
        arrays |= relative_arrays(readings.relative)
    return [
        row | {key: int(values[j]) for key, values in arrays.items()} for j, row in enumerate(rows)
    ]


def _where_said(sensor: Sensor) -> str:
    """Segments of a span, or its borders where it covers segments in part."""
    if sensor.start % 1 or sensor.end % 1:
        return f"{sensor.start:.4g} to {sensor.end:.4g} segments from the base"
    return f"segments {sensor.start:g} to {sensor.end - 1:g}"


def _span_said(sensor: Sensor) -> str:
    return f"{sensor.name}: {_where_said(sensor)}, at {angle_degrees(sensor):.4g} degrees"


def _axes_context(fitted: Fit, fields: Sequence[Field]) -> dict[str, dict[str, Any]]:
    axes: dict[str, dict[str, Any]] = {}
    first = 0
    for name, axis in fitted.model.axes.items():
        own = _axis_context(fitted, axis)
        same = (one["tables"] for one in axes.values() if _agree(one, own, _EVALUATED))
        field = next(one for one in fields if one.first <= axis.first < one.part.stop)
        behind = axis.first - field.first
        axes[name] = own | {
            "tables": next(same, name),
            "first_value": first,
            "bit": field.bit + behind,
            "place": "uvh".index(name),
            "reads": f"{field.field}{f' + {behind}' if behind else ''}",
        }
        first += axis.segments
    return axes


def _agree(one: dict[str, Any], other: dict[str, Any], keys: Sequence[str]) -> bool:
    return all(one[key] == other[key] for key in keys)


def _kernels(axes: dict[str, dict[str, Any]], joint: Joint, checked: bool) -> list[dict[str, Any]]:
    """The functions that evaluate an axis: one for those that differ in numbers alone.

    Each lists its model's fields in their order: what its axes agree on from a constant model,
    which decides the code, the rest as a field of the model that the function is called with.
    """
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for axis in axes.values():
        key = (axis["saturates"], bool(axis["biases"]), axis["sensors"], len(axis["rows"]))
        groups.setdefault(key, []).append(axis)
    kernels = []
    for members in groups.values():
        names = "".join(member["axis"] for member in members)
        function = "evaluate" if len(groups) == 1 else f"evaluate_{names}"
        for member in members:
            member["function"] = function
        alike = len(members) > 1 and len({member["tables"] for member in members}) == 1
        # Called with one model alone, the compiler folds it into one function by itself.
        once = "CCGEN_ONCE" if alike or checked else "CCGEN_SHARED"
        kernels.append(
            {
                "function": function,
                "fields": _kernel_fields(members, joint),
                "once": once,
                "fallback_words": max(_fallback_words(member, joint) for member in members),
            }
        )
    return kernels


def _fallback_words(axis: dict[str, Any], joint: Joint) -> int:
    """Words of the rows that serve without one of an axis's sensors; 0 where none do."""
    words = axis["words_per_row"] if joint.precision == 16 else axis["sensors"]
    return len(axis["rows"]) * words if axis["without"] else 0


def _kernel_fields(members: list[dict[str, Any]], joint: Joint) -> list[str]:
    own = f"{members[0]['tables']}_axis"

    def field(key: str) -> str:
        agreed = len({member[key] for member in members}) == 1
        return f"{own}.{key}" if agreed else f"model->{key}"

    flags = ("saturates", "narrow") if joint.precision == 16 else ("saturates",)
    known = [field(key) for key in ("sensors", "shift", "fraction_bits", *flags)]
    biases = "model->biases" if members[0]["biases"] else "NULL"
    weights = "model->rows" if joint.precision == 16 else "model->weights"
    return [f"{own}.segments", *known, field("bias"), biases, weights]


def _axis_context(fitted: Fit, axis: AxisModel) -> dict[str, Any]:
    joint, weights = fitted.sensed, fitted.weights[axis.axis]
    own = fitted.guarded.fallbacks.get(axis.axis)
    step = 2.0**-axis.fraction_bits
    said = f"{100.0 * step:.3g} %" if axis.axis == "h" else f"{math.degrees(step):.3g}°"
    return {
        "axis": axis.axis,
        "sensors": axis.sensors,
        "shift": axis.shift,
        "fraction_bits": axis.fraction_bits,
        "unit_per_step": float_literal(step),
        "step_said": said,
        "headroom_bits": axis.headroom_bits,
        "saturates": axis.saturates or (own is not None and own.saturates),
        "narrow": axis.narrow,
        **_bias_context(axis),
        "words_per_row": (axis.sensors + 1) // 2,
        "rows": rows_context(axis.weights.tolist()),
        "without": _without(own),
        "worst_error_percent_rom": at_least(axis.worst_error_percent_rom),
        "rms_error_percent_rom": f"{axis.rms_error_percent_rom:.2g}",
        "scores": [
            _score(row, axis.axis)
            for row in fitted.errors
            if not row.noise or stated_noise(joint) is not None
        ],
        "noise_gain": f"{noise_gain(weights):.3g}",
    }


def _without(own: Fallbacks | None) -> list[list[dict[str, Any]] | None]:
    """What serves without each sensor: rows, or None where the axis is lost; empty for none."""
    if own is None or all(table is None for table in own.rows):
        return []
    return [None if table is None else rows_context(table.tolist()) for table in own.rows]


def _score(row: ErrorRow, axis: str) -> dict[str, Any]:
    """An error of the fit as the folder's README tells it; what is rounding alone is none."""
    elongation = row.elongation_rms_percent or 0.0  # RMS, % of the length
    percent = elongation if axis == "h" else row.mean_percent_rom[axis]
    return {
        "shapes": _SHAPES.get(row.source, f"{row.source} shapes"),
        "noise": row.noise,
        "percent_rom": f"{percent if percent > _ROUNDING else 0.0:.3g}",
    }


def _bias_context(axis: AxisModel) -> dict[str, Any]:
    """The first segment's bias, and what every segment adds to it where they differ."""
    literal = "INT{}_C({})".format
    bits = 2 * axis.precision
    more = axis.bias - axis.bias[0]
    return {
        "bias": literal(bits, int(axis.bias[0])),
        "biases": [literal(bits, b) for b in more.tolist()] if np.any(more) else [],
    }
