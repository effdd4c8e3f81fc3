"""Errors as one line on stderr and an exit status; the traceback only when asked for."""

import functools
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, get_type_hints

import typer
from typer.models import ArgumentInfo

from ccgen import __version__
from ccgen.cli.output import note
from ccgen.errors import ArgumentError, CcgenError

_OWN_FAULT = 3
"""The status of a fault of ccgen's own."""

P = ParamSpec("P")


class Debug:
    """Whether errors show their traceback; set by `ccgen --debug`."""

    on = False


def in_one_line(command: Callable[P, None]) -> Callable[P, None]:
    """Wrap a command so that what a user can mend is said in one line."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except ArgumentError as error:
            names = ", ".join(_option(command, argument) for argument in error.arguments)
            _fail(f"{names}: {error.problem}", error.exit_status)
        except CcgenError as error:
            _fail(str(error), error.exit_status)
        except OSError as error:
            _fail(_system_message(error), CcgenError.exit_status)

    return run


def _option(command: Callable[..., Any], argument: str) -> str:
    """The option, or the word, through which a command has the argument of that name."""
    (declared,) = get_type_hints(command, include_extras=True)[argument].__metadata__
    if isinstance(declared, ArgumentInfo):
        return declared.metavar or argument.upper()
    # Where a parameter is annotated, Typer keeps its first name in the place of the default.
    words = [str(word) for word in (declared.default, *(declared.param_decls or ()))]
    names = [word for word in words if word.startswith("--")]
    return names[0] if names else f"--{argument.replace('_', '-')}"


def say(error: OSError) -> int:
    """Say what the system refused, and return the program's status."""
    _explain(_system_message(error))
    return CcgenError.exit_status


def unforeseen(error: Exception) -> int:
    """Say that the fault is ccgen's own and how to report it; return the program's status."""
    what = " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")
    _explain(
        f"a fault of ccgen's own, not of yours: {what} ({_place(error)}); please report it with "
        "this line, the command and its files, and what `ccgen --debug` prints before the line"
    )
    return _OWN_FAULT


def _place(error: Exception) -> str:
    """Where an error came up: the last line of ccgen's on the way there."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "ccgen" in Path(frame.filename).parts]
    if not ours:
        return f"ccgen {__version__}"
    parts = Path(ours[-1].filename).parts
    file = "/".join(parts[len(parts) - 1 - parts[::-1].index("ccgen") :])
    return f"ccgen {__version__}, {file}, line {ours[-1].lineno}"


def _fail(message: str, status: int) -> None:
    _explain(message)
    raise typer.Exit(status)


def _explain(message: str) -> None:
    if Debug.on:
        traceback.print_exc(file=sys.stderr)
    note(f"error: {message}")


def _system_message(error: OSError) -> str:
    reason = (error.strerror or str(error) or type(error).__name__).lower()
    return f"{error.filename}: {reason}" if error.filename else reason
