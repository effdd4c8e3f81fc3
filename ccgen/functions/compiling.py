"""Compiles a user's functions for the formats that a joint's angles have."""

from collections.abc import Mapping
from typing import Any

from ccgen.errors import ArgumentError, FormatError, InputError
from ccgen.fixedpoint.model import FixedPointModel
from ccgen.functions.integer import JointFunctions
from ccgen.functions.module import Module
from ccgen.polynomial import Compiled, Input, Output, compile_function
from ccgen.polynomial.compiler import output_ranges

DEFAULT_ERROR = 1e-4
"""Of an output for which the module states none, as a share of the width of its range."""


def compile_functions(module: Module, model: FixedPointModel) -> JointFunctions:
    """Compile every function of a module for all angles and elongations that formats hold.

    Raises:
        InputError: a function is no polynomial, has inputs that the joint has not, or no plan of
            32 bits meets its error; names file and function.
    """
    compiled = tuple(_compiled(module, function, model) for function in module.functions)
    return JointFunctions(compiled, module.path.name, module.sha256)


def _compiled(module: Module, function: Any, model: FixedPointModel) -> Compiled:
    name = function.name()
    place = f"{module.path}: {name}"
    inputs = _inputs(place, function, model)
    try:
        wanted = _outputs(function, inputs, module.errors.get(name, {}))
        return compile_function(function, inputs, wanted)
    except ArgumentError as error:
        raise InputError(f"{place}: {error.problem}") from error
    except FormatError as error:
        raise InputError(f"{module.path}: {error}") from error


def _inputs(place: str, function: Any, model: FixedPointModel) -> dict[str, Input]:
    """Ranges and formats of a function's inputs, which are axes of the joint."""
    if not function.n_in() or not function.n_out():
        raise InputError(f"{place}: has no inputs or no outputs; give it some of {_axes(model)}")
    inputs = {}
    for index, name in enumerate(function.name_in()):
        if name not in model.axes:
            raise InputError(f"{place}: the input {name} is none of the joint's: {_axes(model)}")
        axis = model.axes[name]
        rows, columns = function.size_in(index)
        if min(rows, columns) != 1 or rows * columns != axis.segments:
            raise InputError(
                f"{place}: the input {name} has {rows} x {columns} elements; the joint has "
                f"{_axes(model)}"
            )
        end = axis.angle_limit * 2.0**-axis.fraction_bits
        inputs[name] = Input((-end, end), axis.fraction_bits, model.precision)
    return inputs


def _axes(model: FixedPointModel) -> str:
    """The joint's axes with their lengths."""
    kinds = {"h": "elongations"}
    return ", ".join(
        f"{name} ({axis.segments} {kinds.get(name, 'angles')})" for name, axis in model.axes.items()
    )


def _outputs(
    function: Any, inputs: Mapping[str, Input], errors: Mapping[str, float]
) -> dict[str, Output]:
    """The error of every output: as stated, or by the width of its range."""
    ranges = output_ranges(function, inputs)
    return {
        name: Output(errors[name] if name in errors else DEFAULT_ERROR * _size(*ranges[name]))
        for name in function.name_out()
    }


def _size(low: float, high: float) -> float:
    """Width of a range; of a constant its magnitude, or 1."""
    return high - low or abs(high) or 1.0
