"""A user's own functions in C: what functions.h.j2 and functions.c.j2 are filled with."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from ccgen import __version__, resources
from ccgen.digits import rounded_up
from ccgen.errors import ArgumentError, InputError
from ccgen.functions import JointFunctions
from ccgen.functions.integer import outputs_of
from ccgen.joint.specification import OUTPUT_AXES
from ccgen.polynomial import Compiled
from ccgen.polynomial.c_text import c_context, require_names


def functions_files(name: str, functions: JointFunctions) -> dict[str, str]:
    """The C file and header of a joint's own functions, by file name.

    Args:
        name: of the joint.
        functions: at least one.

    Raises:
        InputError: a name that C cannot have, or that two have.
    """
    values = {
        "name": name,
        "version": __version__,
        "source": functions.source,
        "functions": functions_context(name, functions),
    }
    _require_names(name, functions)
    return {
        f"{name}_functions.{ending}": resources.template(f"functions.{ending}.j2").render(values)
        for ending in ("h", "c")
    }


def functions_context(name: str, functions: JointFunctions) -> list[dict[str, Any]]:
    """What templates know of each function."""
    return [_context(name, function) for function in functions.compiled]


def _context(name: str, function: Compiled) -> dict[str, Any]:
    outputs = outputs_of(function)
    inputs = {one.name: one.element is None for one in function.plan.inputs}
    parameters = [f"const {name}_angles_t *angles"]
    for output, row in outputs.items():
        single = row[0].element is None
        parameters.append(f"int32_t *{output}" if single else f"int32_t {output}[{len(row)}]")
    symbol = _symbol(name, function)
    results = [
        {
            "name": output,
            "said": output if row[0].element is None else f"An element of {output}",
            "macro": _macro(symbol, output),
            "bits": row[0].fraction_bits,
            "elements": len(row),
            "single": row[0].element is None,
            "bound": f"{rounded_up(float(max(function.bounds[output])), 2):.1e}",
        }
        for output, row in outputs.items()
    ]
    return c_context(function) | {
        "symbol": symbol,
        "parameters": ", ".join(parameters),
        "pointers": list(outputs),
        "lists": [axis for axis, single in inputs.items() if not single],
        "scalars": [axis for axis, single in inputs.items() if single],
        "results": results,
    }


def _require_names(name: str, functions: JointFunctions) -> None:
    """Refuse names that C cannot have, or that meet within the header."""
    try:
        require_names(name, functions.compiled)
    except ArgumentError as error:
        raise InputError(f"{functions.source}: {error.problem}") from error
    for function in functions.compiled:
        for output in outputs_of(function):
            if output in ("angles", *OUTPUT_AXES):
                raise InputError(
                    f"{functions.source}: {function.name}: an output is called {output}, as the "
                    "joint's angles are; rename it"
                )
    for symbol, count in Counter(_symbols(name, functions)).items():
        if count > 1:
            raise InputError(f"{functions.source}: {symbol} would be in C twice; rename an output")


def _symbols(name: str, functions: JointFunctions) -> Iterable[str]:
    """All that C knows by name of them."""
    for function in functions.compiled:
        symbol = _symbol(name, function)
        yield symbol
        yield from (_macro(symbol, output) for output in outputs_of(function))


def _symbol(name: str, function: Compiled) -> str:
    return f"{name}_{function.name}"


def _macro(symbol: str, output: str) -> str:
    return f"{symbol}_{output}_BITS".upper()


def require_free(name: str, functions: JointFunctions, texts: Mapping[str, str]) -> None:
    """Refuse functions that would meet what a joint's C has already.

    Args:
        name: of the joint.
        functions: its functions.
        texts: contents of its other files, by path.

    Raises:
        InputError: naming function and file.
    """
    for symbol in _symbols(name, functions):
        pattern = re.compile(rf"\b{re.escape(symbol)}\b")
        for path, text in texts.items():
            if path.startswith("src/") and pattern.search(text):
                raise InputError(
                    f"{functions.source}: {path} has {symbol} already; rename the function or "
                    "its output"
                )
