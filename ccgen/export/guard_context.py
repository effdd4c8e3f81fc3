"""What the templates know of sensors that fail: what serves without them, what watches them."""

from collections.abc import Sequence
from typing import Any

from ccgen.can.layout import FrameLayout
from ccgen.export.fields import Field, fields_of
from ccgen.export.literals import rows_context
from ccgen.fixedpoint import Fit
from ccgen.fixedpoint.consistency import GroupCheck
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.watch import BACK_AFTER, OUT_AFTER


def guard_context(fitted: Fit, layout: FrameLayout) -> dict[str, Any]:
    """Fallbacks and checks: how many bytes, and the tables of each group that is checked."""
    guarded = fitted.guarded
    fields = fields_of(fitted.joint, layout)
    groups = [_group(guarded, group, fields) for group in guarded.groups]
    for k, group in enumerate(groups):
        alike = (one for one in groups[:k] if _kernel(one) == _kernel(group))
        group["function"] = next((one["function"] for one in alike), f"check_{group['name']}")
    return {
        "fallback_bytes": guarded.flash_bytes,
        "groups": groups,
        "out_after": OUT_AFTER,
        "back_after": BACK_AFTER,
        "checkers": [one for one in groups if one["function"] == f"check_{one['name']}"],
    }


def _kernel(group: dict[str, Any]) -> tuple[Any, ...]:
    return group["sensors"], group["narrow"], group["kept"], group["quiet_bits"]


def _group(guarded: GuardedModel, group: GroupCheck, fields: Sequence[Field]) -> dict[str, Any]:
    field = next(one for one in fields if one.first <= group.first < one.part.stop)
    behind = group.first - field.first
    axes = [axis for axis in guarded.model.axes.values() if axis.part == group.own]
    literal = "INT32_C({})".format
    return {
        "name": "".join(axis.axis for axis in axes),
        "reads": f"{field.field}{f' + {behind}' if behind else ''}",
        "sensors": group.sensors,
        "bit": field.bit + behind,
        "narrow": all(axis.narrow for axis in axes),
        "axes": sum(1 << 2 * "uvh".index(axis.axis) for axis in axes),
        "rows": rows_context(group.weights.tolist()),
        "kept": group.kept,
        "quiet_bits": group.quiet_bits,
        "shift": group.shift,
        "directions": group.directions.tolist(),
        "threshold": [literal(value) for value in group.threshold.tolist()],
        "margin": [literal(value) for value in group.margin.tolist()],
    }
