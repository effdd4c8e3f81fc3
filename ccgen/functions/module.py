"""A user's Python module of CasADi functions, run and read."""

import hashlib
import math
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from ccgen.errors import InputError

ERRORS = "errors"
"""Of a module, what its functions' outputs may be off: by function, one for all or by output."""


@dataclass(frozen=True)
class Module:
    """What a module defines.

    Attributes:
        path: of its file.
        sha256: of the file's content, as it was run.
        functions: every `casadi.Function` at module level whose name has no underscore before it.
        errors: wanted errors by function and output.
    """

    path: Path
    sha256: str
    functions: tuple[Any, ...]
    errors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def read_module(path: str | Path) -> Module:
    """Run a module and take its functions.

    Args:
        path: of a Python file; what it prints goes to stderr, and it may import what lies beside.

    Raises:
        InputError: it cannot be read or run, or defines nothing that could be compiled.
    """
    file = Path(path)
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}; name a Python file") from error
    found = _public(_run(file, content))
    functions = _functions(file, found)
    digest = hashlib.sha256(content).hexdigest()
    return Module(file, digest, functions, _errors(file, found.get(ERRORS, {}), functions))


def _run(file: Path, content: bytes) -> dict[str, Any]:
    """The module's names after it has run."""
    module = ModuleType(file.stem)
    module.__file__ = str(file)
    folder = str(file.resolve().parent)
    sys.path.insert(0, folder)
    try:
        with redirect_stdout(sys.stderr):
            exec(compile(content, str(file), "exec"), vars(module))
    except (Exception, SystemExit) as error:
        raise InputError(f"{file}{_line(file, error)}: {_said(error)}") from error
    finally:
        sys.path.remove(folder)
    return vars(module)


def _line(file: Path, error: BaseException) -> str:
    """The last line of the file that was running, with a colon before it."""
    if isinstance(error, SyntaxError):
        return f":{error.lineno}" if error.lineno else ""
    lines = []
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(file):
            lines.append(trace.tb_lineno)
        trace = trace.tb_next
    return f":{lines[-1]}" if lines else ""


def _said(error: BaseException) -> str:
    """The kind of an error and the first line of what it says."""
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__


def _public(names: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in names.items() if not name.startswith("_")}


def _functions(file: Path, names: Mapping[str, Any]) -> tuple[Any, ...]:
    """The functions, each once, in the order in which they were assigned."""
    import casadi

    found: dict[str, Any] = {}
    for value in names.values():
        if not isinstance(value, casadi.Function):
            continue
        name = value.name()
        if name in found and found[name].__hash__() != value.__hash__():
            raise InputError(f"{file}: two functions are called {name}; rename one")
        found[name] = value
    if not found:
        raise InputError(
            f"{file}: defines no casadi.Function at module level; assign one to a name without an "
            "underscore before it"
        )
    return tuple(found.values())


def _errors(file: Path, stated: Any, functions: tuple[Any, ...]) -> dict[str, dict[str, float]]:
    known = {function.name(): function.name_out() for function in functions}
    if not isinstance(stated, Mapping):
        raise InputError(f"{file}: {ERRORS}: is no dict; write {ERRORS} = {{{_example(known)}}}")
    found = {}
    for name, own in stated.items():
        if name not in known:
            raise InputError(
                f"{file}: {ERRORS}: {name!r} is no function of the module; it has "
                f"{', '.join(known)}"
            )
        outputs = known[name]
        table: Mapping[str, Any] = own if isinstance(own, Mapping) else dict.fromkeys(outputs, own)
        for output, value in table.items():
            place = f"{file}: {ERRORS}: {name}"
            if output not in outputs:
                raise InputError(f"{place}: {output!r} is no output; it has {', '.join(outputs)}")
            if not _is_error(value):
                raise InputError(
                    f"{place}: {value!r} is no error; write a number above 0, or a dict of one "
                    "for each output"
                )
        found[name] = {output: float(value) for output, value in table.items()}
    return found


def _is_error(value: Any) -> bool:
    known = isinstance(value, int | float) and not isinstance(value, bool)
    return known and math.isfinite(value) and value > 0


def _example(known: Mapping[str, list[str]]) -> str:
    return f'"{next(iter(known))}": 1e-5'
