"""What a node's model is known by on the bus."""

import hashlib
import json
from dataclasses import asdict
from typing import Any

import numpy as np

from ccgen.can.layout import FrameLayout
from ccgen.fixedpoint import AxisModel
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.guarded_storage import guard_record

_FORMAT = ("precision", "first", "shift", "fraction_bits", "saturates")
_TABLES = ("weights", "bias", "minimum", "maximum", "zero")


def fingerprint(guarded: GuardedModel, layout: FrameLayout) -> int:
    """32 bits of weights, formats, ranges, zeros and frames; HEALTH carries the low 16.

    Weights are those of fallbacks and checks, too.

    Names, descriptions and versions leave it as it is.
    """
    frames: dict[str, Any] = asdict(layout)
    del frames["name"]
    frames["sensors"] = len(layout.sensors)
    record = {
        "axes": {name: _axis_record(axis) for name, axis in guarded.model.axes.items()},
        "guard": guard_record(guarded),
        "frames": frames,
    }
    text = json.dumps(record, sort_keys=True, separators=(",", ":"))
    return int.from_bytes(hashlib.sha256(text.encode("ascii")).digest()[:4], "little")


def _axis_record(axis: AxisModel) -> dict[str, Any]:
    record: dict[str, Any] = {key: getattr(axis, key) for key in _FORMAT}
    record |= {key: np.asarray(getattr(axis, key)).tolist() for key in _TABLES}
    if axis.relative is not None:
        record["relative"] = {key: table.tolist() for key, table in asdict(axis.relative).items()}
    return record
