"""Errors as one line on stderr and an exit status; the traceback only when asked for."""

import functools
import sys
import traceback
from collections.abc import Callable
from typing import ParamSpec

import typer

from ccgen.cli.output import note
from ccgen.errors import CcgenError

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
        except CcgenError as error:
            _fail(str(error), error.exit_status)
        except BrokenPipeError:
            raise
        except OSError as error:
            _fail(_system_message(error), CcgenError.exit_status)

    return run


def _fail(message: str, status: int) -> None:
    if Debug.on:
        traceback.print_exc(file=sys.stderr)
    note(f"error: {message}")
    raise typer.Exit(status)


def _system_message(error: OSError) -> str:
    reason = (error.strerror or str(error) or type(error).__name__).lower()
    return f"{error.filename}: {reason}" if error.filename else reason
