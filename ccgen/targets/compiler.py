"""Compilers: that of the host, what every one of them is asked to check, how one is run."""

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from ccgen.errors import ArgumentError, InputError, ToolError

WARNINGS = (
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion",
    "-Wshadow", "-Wundef", "-Wmissing-prototypes", "-Wvla", "-Werror",
)  # fmt: skip
"""Warnings under which every exported file compiles."""

LEVELS = ("-O0", "-Os", "-O2", "-O3")
"""Levels of optimisation at which angles are the same, bit for bit."""

LEVEL = "-O2"
"""The level of optimisation unless another is asked for."""


def level_named(optimise: str) -> str:
    """The compiler's option for a level such as "2" or "s".

    Raises:
        ArgumentError: it is none of `LEVELS`.
    """
    level = f"-O{optimise}"
    if level not in LEVELS:
        known = ", ".join(one.removeprefix("-O") for one in LEVELS)
        raise ArgumentError(f"{optimise!r} is unknown; give one of {known}", "optimise")
    return level


def compiler() -> list[str]:
    """Command of the host's C compiler: $CC, or the first of cc, gcc and clang.

    $CC is read as a shell does: a program, then flags, each in quotes where it has spaces. A whole
    value that is a program is taken as one, spaces or not.

    Raises:
        ToolError: there is none.
    """
    chosen = _chosen(os.environ.get("CC", ""))
    for command in [chosen] if chosen else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]):
            return command
    looked_for = f"$CC = {shlex.join(chosen)}" if chosen else "$CC, cc, gcc and clang"
    raise ToolError(
        f"no C compiler found (looked for {looked_for}); install one, "
        f"for example with `apt-get install gcc` or `brew install gcc`, or set CC"
    )


def _chosen(value: str) -> list[str]:
    """Words of $CC."""
    if shutil.which(value.strip()):
        return [value.strip()]
    try:
        return shlex.split(value)
    except ValueError as error:
        raise ToolError(f"$CC = {value}: {str(error).lower()}; close the quotation") from None


def sources(directory: Path) -> list[Path]:
    """C files of the joint and the runtime in an exported folder, as absolute paths.

    A compiler takes relative ones that begin with - or @ for something else.

    Raises:
        InputError: there are none.
    """
    found = sorted((directory.absolute() / "src").rglob("*.c"))
    if not found:
        raise InputError(f"{directory}: holds no src/*.c; name a folder that `ccgen export` wrote")
    return found


def run_compiler(command: Sequence[str], folder: Path, failure: str) -> None:
    """Run a compiler that leaves its own temporary files in `folder`, where they end with it.

    It speaks English whatever the language of the machine, so that its reason is found.

    Args:
        command: the compiler and its arguments.
        folder: a temporary one.
        failure: what is said before the compiler's reason.

    Raises:
        ToolError: it ended with an error.
    """
    place = {**os.environ, "TMPDIR": str(folder), "LC_ALL": "C"}
    try:
        done = subprocess.run(
            command, capture_output=True, encoding="utf-8", errors="replace", check=False, env=place
        )
    except OSError as error:
        raise ToolError(f"{command[0]}: {(error.strerror or str(error)).lower()}") from error
    if done.returncode != 0:
        raise ToolError(f"{failure}: {_first_error(done.stderr)}")


def _first_error(messages: str) -> str:
    """The line of a compiler's or linker's messages that says what is wrong."""
    lines = [line for line in messages.strip().splitlines() if not line.startswith("collect2")]
    words = ("error", "warning", "undefined", "overflowed", "is full")
    telling = (line for line in lines if any(word in line for word in words))
    return next(telling, lines[-1] if lines else "failed without a message")
