"""Shapes that a user gives as arrays, checked: their form, their unit, how far they reach."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.errors import ArgumentError
from ccgen.joint import AXES
from ccgen.shapes.library import Shapes

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]

GIVEN = "given"
"""Source of rows that came as arrays."""

_FARTHEST = 5.0
"""Shapes that reach so many times the range of motion are rather angles in another unit."""


def given_shapes(
    joint: "Joint", shapes: ArrayLike | Mapping[str, ArrayLike] | Shapes, argument: str = "shapes"
) -> Shapes:
    """Rows of shapes from what a caller gave.

    Args:
        joint: whose shapes they are.
        shapes: angles of shape (N, m), radians, that both axes take; or arrays by axis, "u" and
            "v" of shape (N, m), radians, and "h" of shape (N, S), shares of the length; or rows.
        argument: name of the argument, for messages.

    Raises:
        ArgumentError: another form, a number that is not finite, angles in degrees, or a segment
            beyond 90 degrees.
    """
    rows = _rows(joint, shapes, argument)
    if not len(rows):
        raise ArgumentError("hold no row; give at least one", argument)
    for name in ("u", "v"):
        _check_angles(joint, getattr(rows, name), name, argument)
    _check_elongation(joint, rows, argument)
    return rows


def reach(joint: "Joint", shapes: Shapes) -> float:
    """Largest segment angle of the rows, as a multiple of the range of motion."""
    largest = max(np.abs(shapes.u).max(initial=0.0), np.abs(shapes.v).max(initial=0.0))
    return float(largest / joint.geometry.range_of_motion)


def angle_problem(joint: "Joint", angle: float) -> str | None:
    """What is wrong with a segment's angle in radians, and what would be right; None if nothing."""
    range_of_motion = joint.geometry.range_of_motion
    if not math.isfinite(angle):
        return f"{angle} is no angle; give radians within ±1.57"
    if _in_degrees(joint, angle):
        return (
            f"{angle:.4g} rad is {abs(angle) / range_of_motion:.0f} times the range of motion of "
            f"{range_of_motion:.4g} rad, as degrees would be; give radians, numpy.radians(...)"
        )
    if abs(angle) > math.pi / 2:
        return f"{angle:.4g} rad is more than 90 degrees a segment; give radians within ±1.57"
    return None


def _in_degrees(joint: "Joint", angle: float) -> bool:
    share = abs(angle) / joint.geometry.range_of_motion
    return share > _FARTHEST and math.radians(share) < _FARTHEST


def _rows(
    joint: "Joint", shapes: ArrayLike | Mapping[str, ArrayLike] | Shapes, argument: str
) -> Shapes:
    geometry = joint.geometry
    if isinstance(shapes, Shapes):
        for name, count in (("u", geometry.segments), ("h", len(geometry.sections))):
            _check_columns(getattr(shapes, name), count, name, argument)
        return shapes
    if not isinstance(shapes, Mapping):
        if joint.couples:
            raise ArgumentError(
                "are one array, but sensors of this joint read more than one axis; give arrays by "
                'axis, {"u": ..., "v": ...}',
                argument,
            )
        shapes = dict.fromkeys([axis for axis in AXES if axis in joint.axes], shapes)
    arrays = _by_axis(joint, shapes, argument)
    return Shapes(**arrays, source=(GIVEN,) * len(arrays["u"]))


def _by_axis(joint: "Joint", shapes: Mapping[str, ArrayLike], argument: str) -> dict[str, Floats]:
    """Arrays of u, v and h, zeros for an axis that the joint does not estimate."""
    columns = {"u": joint.geometry.segments, "v": joint.geometry.segments}
    columns["h"] = len(joint.geometry.sections)
    for name in shapes:
        if name not in columns:
            raise ArgumentError(f'have an axis "{name}"; known: "u", "v" and "h"', argument)
    for name in joint.axes:
        if name not in shapes and name != "h":
            raise ArgumentError(f'lack the axis "{name}", which the joint estimates', argument)
    arrays = {name: _array(shapes[name], columns[name], name, argument) for name in shapes}
    lengths = {name: len(array) for name, array in arrays.items()}
    if len(set(lengths.values())) != 1:
        told = ", ".join(f"{count} of {name}" for name, count in lengths.items())
        raise ArgumentError(f"have {told or 'no'} rows; give as many of each axis", argument)
    rows = next(iter(lengths.values()))
    return {name: arrays.get(name, np.zeros((rows, count))) for name, count in columns.items()}


def _array(values: ArrayLike, columns: int, name: str, argument: str) -> Floats:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ArgumentError(
            f"{name} is no array of numbers; give one of shape (N, {columns})", argument
        ) from None
    _check_columns(array, columns, name, argument)
    return array


def _check_columns(array: Floats, columns: int, name: str, argument: str) -> None:
    if array.ndim == 2 and array.shape[1] == columns:
        return
    turned = array.ndim == 2 and array.shape[0] == columns
    raise ArgumentError(
        f"{name} has shape {array.shape}, not (N, {columns}); give a row for each shape"
        + (", which its transpose has" if turned else ""),
        argument,
    )


def _check_angles(joint: "Joint", angles: Floats, name: str, argument: str) -> None:
    _check_finite(angles, name, argument)
    largest = float(angles.flat[np.abs(angles).argmax()])
    problem = angle_problem(joint, largest)
    if problem is not None:
        raise ArgumentError(f"{name} reaches too far: {problem}", argument)


def _check_elongation(joint: "Joint", shapes: Shapes, argument: str) -> None:
    _check_finite(shapes.h, "h", argument)
    largest = float(np.abs(shapes.h).max())
    if largest >= 1.0:
        raise ArgumentError(
            f"h reaches {largest:.4g}, but an elongation is a share of the length; give shares, "
            "such as 0.05 for 5 per cent",
            argument,
        )
    if largest and joint.geometry.elongation is None:
        raise ArgumentError("h is not 0, but this joint does not elongate; leave it out", argument)


def _check_finite(array: Floats, name: str, argument: str) -> None:
    wrong = np.argwhere(~np.isfinite(array))
    if len(wrong):
        row, column = wrong[0]
        raise ArgumentError(
            f"{name}[{row}, {column}] is {array[row, column]}; leave out rows without a number",
            argument,
        )
