"""The integer reference model of a plan: what the C computes, bit for bit, in NumPy."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.errors import ArgumentError
from ccgen.polynomial.plan import PRODUCTS, Plan, Step

Integers = NDArray[np.int64]


def evaluate(
    plan: Plan, integers: Sequence[tuple[int, int]], values: Mapping[str, ArrayLike]
) -> dict[str, Integers]:
    """Evaluate a plan.

    Args:
        plan: the plan.
        integers: the least and the greatest integer that is proven of every step.
        values: integers of every input by name, of shape (...), or (..., elements) where the input
            has several, column by column. What lies outside a range counts as its nearer end.

    Returns:
        Integers of every output, likewise.

    Raises:
        ArgumentError: an input is missing, unknown, not of integers, or of another shape.
        ArithmeticError: an integer leaves what is proven: a fault of ccgen's own.
    """
    arrays = _inputs(plan, values)
    found: list[Integers] = []
    for number, step in enumerate(plan.steps):
        if step.kind == "input":
            found.append(arrays[number])
            continue
        value = _applied(step, [found[k] for k in step.operands])
        low, high = integers[number]
        if value.size and (value.min() < low or value.max() > high):
            raise ArithmeticError(f"step {number}, {step.kind}: leaves {low} to {high}")
        found.append(value)
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    outputs: dict[str, Any] = {}
    for variable, number in plan.outputs:
        outputs.setdefault(variable.name, []).append(np.broadcast_to(found[number], shape))
        if variable.element is None:
            outputs[variable.name] = np.array(outputs[variable.name][0])
    return {
        name: np.stack(rows, axis=-1) if isinstance(rows, list) else rows
        for name, rows in outputs.items()
    }


def _inputs(plan: Plan, values: Mapping[str, ArrayLike]) -> list[Integers]:
    """Elements of the inputs, within their ranges."""
    names = list(dict.fromkeys(one.name for one in plan.inputs))
    if set(values) != set(names):
        raise ArgumentError(f"has {', '.join(values)}; give {', '.join(names)}", "values")
    found = []
    for variable in plan.inputs:
        array = np.asarray(values[variable.name])
        if array.dtype.kind not in "iu":
            raise ArgumentError(f"{variable.name} is not of integers", "values")
        if variable.element is not None:
            elements = sum(one.name == variable.name for one in plan.inputs)
            if array.ndim == 0 or array.shape[-1] != elements:
                raise ArgumentError(
                    f"{variable.name} has the shape {array.shape}; (..., {elements})", "values"
                )
            array = array[..., variable.element]
        found.append(np.clip(array.astype(np.int64), variable.low, variable.high))
    return found


def _applied(step: Step, operands: list[Integers]) -> Integers:
    """The step's integers; no product or shift of 32-bit numbers leaves 64 bits."""
    if step.kind == "constant":
        return np.array(step.value, dtype=np.int64)
    first = operands[0]
    if step.kind == "add":
        return np.asarray(first + operands[1])
    if step.kind == "subtract":
        return np.asarray(first - operands[1])
    if step.kind == "negate":
        return np.asarray(-first)
    if step.kind == "left":
        return np.asarray(first << step.shift)
    if step.kind == "right":
        return np.asarray((first + step.value) >> step.shift)
    if step.kind in PRODUCTS:
        return np.asarray((first * operands[1]) >> PRODUCTS[step.kind])
    return first
