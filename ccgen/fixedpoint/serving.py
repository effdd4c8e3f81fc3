"""An axis in fixed point together with the fallbacks that share its format.

The format is that of the axis' own weights. Fallback weights that exceed it are held at its limit,
and the others fitted again; where that costs a fallback more than a hundredth of its error, the
axis gives up a bit of its shift instead, which halves the resolution of all its weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ccgen.estimation import Weights
from ccgen.estimation.fallback import expected_error, held
from ccgen.estimation.fit import Task
from ccgen.fixedpoint.fallback import Fallbacks, fallbacks, weight_limit
from ccgen.fixedpoint.formats import quantise_axis
from ccgen.fixedpoint.model import AxisModel, Floats
from ccgen.fixedpoint.ranges import count_gains, reading_per_count
from ccgen.shapes import Shapes

_COARSER = 6
"""Most bits of shift that an axis gives up."""

_COSTS = 1.01
"""Times its error without limits that a held fallback may err by,"""
_NEGLIGIBLE = 1e-4
"""and ranges of motion (lengths for "h") more, as much as rounding adds anyway."""

_BEARABLE = 1.0
"""% of the range of motion that rounding may add to a sound axis for the sake of its fallbacks."""


@dataclass(frozen=True, eq=False)
class ServedAxis:
    """An axis and what serves while one of its sensors is lost.

    Attributes:
        model: the axis.
        fallbacks: their integers.
        weights: what those stand for, by lost sensor; None where the axis is lost without it.
    """

    model: AxisModel
    fallbacks: Fallbacks
    weights: Sequence[Weights | None]


def quantise_with_fallbacks(
    task: Task, axis: str, weights: Weights, lost: Sequence[Weights | None], shapes: Shapes
) -> ServedAxis:
    """Fixed-point model of one output axis and of its fallbacks.

    Args:
        task: what weights are fitted to, and the joint.
        axis: an output axis.
        weights: of that axis.
        lost: for each of its sensors the weights without it, or None.
        shapes: that the sensors must follow.

    Raises:
        FormatError: no format fits the axis' own weights.
    """
    joint = task.joint
    allowed = [_allowed(task, axis, one) for one in lost]
    model = quantise_axis(joint, axis, weights, shapes)
    bearable = max(model.worst_error_percent_rom, _BEARABLE)
    for coarser in range(_COARSER + 1):
        following = quantise_axis(joint, axis, weights, shapes, coarser)
        if following.worst_error_percent_rom > bearable:
            break
        model = following
        limit = weight_limit(model) / np.abs(reading_per_count(joint, axis))
        if (
            coarser == _COARSER
            or model.shift == 0
            or all(
                free is None or _bears(task, axis, free, limit, most)
                for free, most in zip(lost, allowed, strict=True)
            )
        ):
            break
    kept = [None if one is None else held(task, axis, one, limit) for one in lost]
    gains = [None if one is None else count_gains(joint, axis, one) for one in kept]
    return ServedAxis(model, fallbacks(model, gains), kept)


def _bears(task: Task, axis: str, free: Weights, limit: Floats, most: float) -> bool:
    """Whether weights within the limit err by no more than is allowed."""
    own = held(task, axis, free, limit)
    return own is free or expected_error(task, axis, own) <= most


def _allowed(task: Task, axis: str, weights: Weights | None) -> float:
    if weights is None:
        return 0.0
    unit = 1.0 if axis == "h" else task.joint.geometry.range_of_motion
    return _COSTS * expected_error(task, axis, weights) + _NEGLIGIBLE * unit
