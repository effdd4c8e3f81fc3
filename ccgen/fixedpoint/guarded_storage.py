"""Fallbacks and checks as JSON records, beside the axes of `model.json`."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ccgen.fixedpoint import bounds
from ccgen.fixedpoint.consistency import GroupCheck
from ccgen.fixedpoint.fallback import Fallbacks
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.model import AxisModel, FixedPointModel
from ccgen.fixedpoint.storage import load_record, model_from_record, model_record


def guarded_json(guarded: GuardedModel, beside: Mapping[str, Any] | None = None) -> str:
    """Return `model.json`: a model with what serves and watches over its sensors.

    Args:
        guarded: the model.
        beside: further keys.
    """
    record = model_record(guarded.model) | guard_record(guarded) | dict(beside or {})
    return json.dumps(record, indent=1) + "\n"


def load_guarded(path: Path) -> GuardedModel:
    """Read it back.

    Raises:
        InputError: as of `load_model`.
    """
    return load_record(path, lambda record: guarded_model(model_from_record(record), record))


def guard_record(guarded: GuardedModel) -> dict[str, Any]:
    """The keys "fallbacks" and "checks"."""
    return {
        "fallbacks": {
            axis: {
                "rows": [None if rows is None else rows.tolist() for rows in own.rows],
                "saturates": own.saturates,
            }
            for axis, own in guarded.fallbacks.items()
        },
        "checks": [
            {
                "first": group.first,
                "weights": group.weights.tolist(),
                "kept": group.kept,
                "quiet_bits": group.quiet_bits,
                "directions": group.directions.tolist(),
                "threshold": group.threshold.tolist(),
                "margin": group.margin.tolist(),
            }
            for group in guarded.groups
        ],
    }


def guarded_model(model: FixedPointModel, record: dict[str, Any]) -> GuardedModel:
    """The model with what a record holds, checked against overflow again.

    Raises:
        KeyError, TypeError, ValueError: no record of this model.
    """
    fallbacks = {
        name: _fallbacks(model.axis(name), own) for name, own in record["fallbacks"].items()
    }
    groups = tuple(_group(model, own) for own in record["checks"])
    return GuardedModel(model, fallbacks, groups)


def _fallbacks(axis: AxisModel, record: dict[str, Any]) -> Fallbacks:
    rows = [None if one is None else np.array(one, dtype=np.int64) for one in record["rows"]]
    if len(rows) != axis.sensors:
        raise ValueError(f"axis {axis.axis}: {len(rows)} fallbacks of {axis.sensors} sensors")
    limit = 2 ** (2 * axis.precision - 1) - 1
    for j, one in enumerate(rows):
        if one is None:
            continue
        if one.shape != axis.weights.shape or one[:, j].any():
            raise ValueError(f"axis {axis.axis}: fallback {j} of another shape")
        sums = bounds.largest_accumulator(one, axis.bias, axis.span) + (1 << axis.shift)
        if np.abs(one).max() > axis.angle_limit or sums > limit:
            raise ValueError(f"axis {axis.axis}: fallback {j} does not fit the format")
    return Fallbacks(rows, bool(record["saturates"]))


def _group(model: FixedPointModel, record: dict[str, Any]) -> GroupCheck:
    weights, directions, threshold, margin = (
        np.array(record[key], dtype=np.int64)
        for key in ("weights", "directions", "threshold", "margin")
    )
    kept, bits = int(record["kept"]), int(record["quiet_bits"])
    group = GroupCheck(
        int(record["first"]), model.precision, weights, kept, bits, directions, threshold, margin
    )
    parts = [axis for axis in model.axes.values() if axis.part == group.own]
    count = len(threshold)
    square = weights.shape == directions.shape == (count, count)
    if not parts or not square or margin.shape != (count,) or not 1 <= kept <= count:
        raise ValueError(f"check of sensors {group.own.start} to {group.own.stop - 1}")
    steps = np.concatenate([threshold, margin])
    fits = (steps >= 0).all() and (steps < 2**31).all() and 0 <= bits <= 2 * model.precision - 2
    fits &= bool((np.abs(directions) < 2**15).all())
    if not fits or np.abs(weights).max() > 2 ** (model.precision - 1) - 1:
        raise ValueError(f"check of sensors from {group.first} does not fit the precision")
    flaw = group.flaw(parts[0].span)
    if flaw is not None:
        raise ValueError(f"check of sensors from {group.first}: {flaw}")
    return group
