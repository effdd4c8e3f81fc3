"""What the templates are filled with: plain values, no decisions left to a template."""

import math
from typing import Any

import numpy as np

from ccgen import FORMAT_VERSION, __version__
from ccgen.can.fingerprint import fingerprint
from ccgen.can.layout import COMMANDS, FAULT_MEANINGS, HEALTH_MS, RESULT_MEANINGS, FrameLayout
from ccgen.can.load import load_percent
from ccgen.digits import at_least
from ccgen.estimation import ErrorRow, noise_gain
from ccgen.export import vectors
from ccgen.export.literals import float_literal
from ccgen.fixedpoint import AxisModel, Fit, FixedPointModel
from ccgen.joint import AXES, Joint
from ccgen.sensing.counts import counts_of
from ccgen.sensing.noise import stated_noise, still_counts
from ccgen.shapes import Shapes, unstretched

SHAPE_VECTORS = 8
BLOCKS = 8
BLOCK_SNAPSHOTS = 64

_ROUNDING = 1e-9
"""% of ROM below which an error is none."""

_SHAPES = {
    "cases": "simulated shapes",
    "loads": "shapes of the stated loads",
    "other loads": "shapes of other loads",
}

_EVALUATED = (
    "shift", "fraction_bits", "saturates", "narrow", "minimum", "maximum", "zero", "bias", "biases",
    "rows",
)  # fmt: skip
"""What an axis's code depends on: axes that agree in all of it share tables and code."""


def common_context(joint: Joint, method: str) -> dict[str, Any]:
    """Names, versions and the joint's geometry."""
    geometry = joint.geometry
    return {
        "name": joint.name,
        "NAME": joint.name.upper(),
        "version": __version__,
        "format_version": FORMAT_VERSION,
        "segments": geometry.segments,
        "length_m": geometry.length,
        "segment_length_mm": f"{1000.0 * geometry.segment_length:.6g}",
        "rom_deg": f"{math.degrees(geometry.range_of_motion):.6g}",
        "method": method,
        "precision": joint.precision,
    }


def model_context(fitted: Fit) -> dict[str, Any]:
    """Formats, weights and accuracy of both axes."""
    axes = {axis: _axis_context(fitted, fitted.model.axis(axis)) for axis in AXES}
    shared = all(axes["u"][key] == axes["v"][key] for key in _EVALUATED)
    axes["v"]["tables"] = "u" if shared else "v"
    return {"axes": axes, "kernels": _kernels(axes, fitted.joint)}


def _kernels(axes: dict[str, dict[str, Any]], joint: Joint) -> list[dict[str, Any]]:
    """The functions that evaluate an axis: one for both where they differ in numbers alone.

    Each lists its model's fields in their order: what its axes agree on from a constant model,
    which decides the code, the rest as a field of the model that the function is called with.
    """
    same_code = all(bool(axes["u"][key]) == bool(axes["v"][key]) for key in ("saturates", "biases"))
    together = same_code and axes["u"]["sensors"] == axes["v"]["sensors"]
    groups = [AXES] if together else [(axis,) for axis in AXES]
    kernels = []
    for group in groups:
        members = [axes[axis] for axis in group]
        function = "evaluate" if together else f"evaluate_{group[0]}"
        for member in members:
            member["function"] = function
        kernels.append({"function": function, "fields": _fields(members, joint)})
    return kernels


def _fields(members: list[dict[str, Any]], joint: Joint) -> list[str]:
    own = f"{members[0]['tables']}_axis"

    def field(key: str) -> str:
        agreed = len({member[key] for member in members}) == 1
        return f"{own}.{key}" if agreed else f"model->{key}"

    flags = ("saturates", "narrow") if joint.precision == 16 else ("saturates",)
    known = [field(key) for key in ("sensors", "shift", "fraction_bits", *flags)]
    tables = [f"model->{key}" for key in ("minimum", "maximum", "zero", "bias")]
    biases = "model->biases" if members[0]["biases"] else "NULL"
    weights = "model->rows" if joint.precision == 16 else "model->weights"
    return [f"{own}.segments", *known, *tables, biases, weights]


def can_context(layout: FrameLayout, joint: Joint, model: FixedPointModel) -> dict[str, Any]:
    """The layout of the frames, and the tables of them for headers and the folder's README."""
    bits = [f"CCGEN_PUBLISH_{kind.upper()}" for kind in layout.publish]
    ranges = model.readings
    still = still_counts(joint, ranges.maximum - ranges.minimum).tolist()
    return {
        "fingerprint": fingerprint(model, layout),
        "publish": " | ".join(bits) or "0",
        "health_ms": HEALTH_MS,
        "commands": COMMANDS,
        "results": list(RESULT_MEANINGS.items()),
        "capture": {
            "minimum": [f"INT32_C({count})" for count in ranges.minimum.tolist()],
            "maximum": [f"INT32_C({count})" for count in ranges.maximum.tolist()],
            "still": [f"INT32_C({count})" for count in still],
        },
        "layout": layout,
        "faults": list(FAULT_MEANINGS.items()),
        "bitrate": joint.can.bitrate,
        "bus_load_percent": at_least(load_percent(layout, joint.can.bitrate)),
        "profile": "P05" if layout.fd else "P01",
        "tip_metres_per_step": float_literal(2.0**-layout.tip_fraction_bits),
        "tip_steps_per_metre": float_literal(2.0**layout.tip_fraction_bits),
    }


def selftest_context(joint: Joint, model: FixedPointModel, shapes: Shapes) -> dict[str, Any]:
    """Vectors with the right angles, and checksums of drawn blocks."""
    limits = [model.axis(a) for a in AXES]
    blocks = [vectors.block(model, seed, BLOCK_SNAPSHOTS) for seed in range(BLOCKS)]
    sums = [vectors.checksum(model.estimate(block.counts, block.zeros)) for block in blocks]
    count_bytes = joint.precision // 8
    state = count_bytes * 2 * (model.u.sensors + model.v.sensors + model.segments)
    return {
        "vectors": _vectors(joint, model, shapes),
        "minimum": [int(x) for axis in limits for x in axis.minimum],
        "maximum": [int(x) for axis in limits for x in axis.maximum],
        "checksums": sums,
        "block_snapshots": BLOCK_SNAPSHOTS,
        "stack_bytes": 100 * math.ceil((state + 150) / 100),
    }


def _axis_context(fitted: Fit, axis: AxisModel) -> dict[str, Any]:
    joint, weights = fitted.joint, fitted.weights[axis.axis]
    sensors, first = joint.axis(axis.axis), joint.sensors[joint.own(axis.axis)][0]
    return {
        "axis": axis.axis,
        "tables": axis.axis,
        "sensors": axis.sensors,
        "spans": sensors.spans,
        "radius_mm": f"{1000.0 * first.radius:.6g}",
        "micrometres_per_count": f"{1e6 * first.metres_per_count:.6g}",
        "shift": axis.shift,
        "fraction_bits": axis.fraction_bits,
        "radians_per_step": float_literal(2.0**-axis.fraction_bits),
        "degrees_per_step": f"{math.degrees(2.0**-axis.fraction_bits):.3g}",
        "headroom_bits": axis.headroom_bits,
        "saturates": axis.saturates,
        "narrow": axis.narrow,
        "minimum": axis.minimum.tolist(),
        "maximum": axis.maximum.tolist(),
        "zero": axis.zero.tolist(),
        **_bias_context(axis),
        "words_per_row": (axis.sensors + 1) // 2,
        "rows": [{"weights": w, "pairs": _pairs(w)} for w in axis.weights.tolist()],
        "worst_error_percent_rom": at_least(axis.worst_error_percent_rom),
        "rms_error_percent_rom": f"{axis.rms_error_percent_rom:.2g}",
        "scores": [
            _score(row, axis.axis)
            for row in fitted.errors
            if not row.noise or stated_noise(joint) is not None
        ],
        "noise_gain": f"{noise_gain(weights):.3g}",
    }


def _score(row: ErrorRow, axis: str) -> dict[str, Any]:
    """An error of the fit as the folder's README tells it; what is rounding alone is none."""
    percent = row.mean_percent_rom[axis]
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


def _pairs(row: list[int]) -> list[tuple[int, int]]:
    padded = row + [0] * (len(row) % 2)
    return list(zip(padded[0::2], padded[1::2], strict=True))


def _vectors(joint: Joint, model: FixedPointModel, shapes: Shapes) -> list[dict[str, list[int]]]:
    """Shapes from every load case, and the corners with the most and the least of everything."""
    every = slice(None, None, max(1, len(shapes) // SHAPE_VECTORS))
    bent = [angles[every][:SHAPE_VECTORS] for angles in (shapes.u, shapes.v)]
    counts = counts_of(joint, unstretched(bent[0], bent[1], len(joint.geometry.sections)))
    readings = {
        a: [*counts[:, joint.own(a)], model.axis(a).minimum, model.axis(a).maximum] for a in AXES
    }
    return [
        {
            "counts_u": u.tolist(),
            "counts_v": v.tolist(),
            "angles_u": model.u.estimate(u).tolist(),
            "angles_v": model.v.estimate(v).tolist(),
        }
        for u, v in zip(readings["u"], readings["v"][::-1], strict=True)
    ]
