"""What to tell of the fixed point that a fit would be exported in, in plain words."""

from collections.abc import Callable, Iterator

import numpy as np

from ccgen.digits import at_least
from ccgen.errors import FormatError
from ccgen.fixedpoint.model import AxisModel, FixedPointModel
from ccgen.joint import Joint
from ccgen.joint.places import sensor_key

_MATTERS = 1.0
"""Proven bound of what fixed point adds, in % of the range of motion, that is told of."""


def fixed_point_advice(joint: Joint, model: Callable[[], FixedPointModel]) -> Iterator[str]:
    """Say where no format fits, or where the one that does adds more than the estimate bears.

    Args:
        joint: the joint.
        model: makes its model.
    """
    try:
        axes = model().axes
    except FormatError as error:
        yield unexportable(error)
        return
    for axis, own in axes.items():
        if own.worst_error_percent_rom > _MATTERS:
            unit = "length" if axis == "h" else "range of motion"
            yield (
                f"{joint.source}: fixed_point.precision: fixed point adds up to "
                f"{at_least(own.worst_error_percent_rom)} % of the {unit} to axis {axis}; "
                f"{_remedy(joint, own)}"
            )


def unexportable(error: FormatError) -> str:
    """What to tell of a joint that can be fitted all the same."""
    return f"{error}; as it is, no fixed point can be exported"


def _remedy(joint: Joint, axis: AxisModel) -> str:
    if joint.precision == 16:
        return "write precision = 32"
    widest = axis.first + int(np.argmax(axis.maximum - axis.minimum))
    return f"narrow {sensor_key(joint, widest, 'range')}"
