"""The fixed-point model as JSON: `model.json` of an exported folder."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ccgen import FORMAT_VERSION
from ccgen.errors import CheckError, InputError
from ccgen.fixedpoint.model import AxisModel, FixedPointModel, RelativeRange
from ccgen.joint.specification import OUTPUT_AXES

Model = TypeVar("Model")

_ARRAYS = ("weights", "bias", "minimum", "maximum", "zero")
_RELATIVE = ("minimum", "maximum", "zero_minimum", "zero_maximum")
_SCALARS: dict[str, type] = {
    "first": int,
    "shift": int,
    "fraction_bits": int,
    "saturates": bool,
    "headroom_bits": int,
    "worst_error_percent_rom": float,
    "rms_error_percent_rom": float,
}


def model_json(model: FixedPointModel) -> str:
    """Return the model as JSON text; the same model gives the same text."""
    return json.dumps(model_record(model), indent=1) + "\n"


def model_record(model: FixedPointModel) -> dict[str, Any]:
    """The model as what JSON can say."""
    return {
        "format": FORMAT_VERSION,
        "name": model.name,
        "precision": model.precision,
        "axes": {name: _axis_record(axis) for name, axis in model.axes.items()},
    }


def load_model(path: Path) -> FixedPointModel:
    """Read a model back; equal, number for number, to the one that was written.

    Raises:
        InputError: the file is missing, damaged or of another format.
    """
    return load_record(path, model_from_record)


def load_record(path: Path, build: Callable[[dict[str, Any]], Model]) -> Model:
    """Read a model's record back and build what it holds.

    Raises:
        InputError: as of `load_model`.
    """
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        if record["format"] != FORMAT_VERSION:
            raise InputError(
                f"{path}: format: is {record['format']}, this ccgen reads {FORMAT_VERSION}; "
                f"export the joint again"
            )
        return build(record)
    except OSError as error:
        raise InputError(
            f"{path}: {error.strerror}; name a folder that `ccgen export` wrote"
        ) from error
    except (KeyError, TypeError, ValueError, OverflowError, CheckError) as error:
        raise InputError(f"{path}: damaged ({error}); export the joint again") from error


def model_from_record(record: dict[str, Any]) -> FixedPointModel:
    """The model that a record holds.

    Raises:
        KeyError, TypeError, ValueError, OverflowError: no record of a model.
    """
    precision, axes = record["precision"], record["axes"]
    if not set(axes) <= set(OUTPUT_AXES) or not set(axes) & set(OUTPUT_AXES[:2]):
        raise ValueError(f"axes {', '.join(axes)}")
    models = {name: _axis_model(name, precision, axes[name]) for name in axes}
    return FixedPointModel(record["name"], precision, models)


def _axis_record(axis: AxisModel) -> dict[str, Any]:
    arrays = {key: getattr(axis, key).tolist() for key in _ARRAYS}
    record: dict[str, Any] = {key: getattr(axis, key) for key in _SCALARS} | arrays
    if axis.relative is not None:
        record["relative"] = {key: getattr(axis.relative, key).tolist() for key in _RELATIVE}
    return record


def _axis_model(name: str, precision: int, record: dict[str, Any]) -> AxisModel:
    values: dict[str, Any] = {key: kind(record[key]) for key, kind in _SCALARS.items()}
    values |= {key: np.array(record[key], dtype=np.int64) for key in _ARRAYS}
    if "relative" in record:
        ranges = record["relative"]
        arrays = {key: np.array(ranges[key], dtype=np.int64) for key in _RELATIVE}
        values["relative"] = RelativeRange(**arrays)
    model = AxisModel(axis=name, precision=precision, **values)
    _check(model)
    return model


def _check(axis: AxisModel) -> None:
    """Raise ValueError for numbers that are no model's."""
    if axis.precision not in (16, 32) or not 0 <= axis.shift < 2 * axis.precision:
        raise ValueError(f"axis {axis.axis}: precision {axis.precision}, shift {axis.shift}")
    if axis.weights.ndim != 2 or 0 in axis.weights.shape:
        raise ValueError(f"axis {axis.axis}: weights of shape {axis.weights.shape}")
    expected = {"bias": axis.segments} | dict.fromkeys(("minimum", "maximum", "zero"), axis.sensors)
    if axis.relative is not None:
        for key in _RELATIVE:
            if getattr(axis.relative, key).shape != (axis.sensors,):
                raise ValueError(f"axis {axis.axis}: {key} of a relative range of another shape")
    for key, length in expected.items():
        if getattr(axis, key).shape != (length,):
            raise ValueError(
                f"axis {axis.axis}: {key} of shape {getattr(axis, key).shape} beside weights of "
                f"shape {axis.weights.shape}"
            )
