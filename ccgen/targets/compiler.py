"""Compilers: that of the host, what every one of them is asked to check, how one is run."""

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from ccgen.errors import InputError, ToolError

WARNINGS = (
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion",
    "-Wshadow", "-Wundef", "-Wmissing-prototypes", "-Wvla", "-Werror",
)  # fmt: skip
"""Warnings under which every exported file compiles."""

LEVELS = ("-O0", "-Os", "-O2", "-O3")
"""Levels of optimisation at which angles are the same, bit for bit."""

LEVEL = "-O2"
"""The level of optimisation unless another is asked for."""


def compiler() -> list[str]:
    """Command of the host's C compiler: $CC, or the first of cc, gcc and clang.

    Raises:
        ToolError: there is none.
    """
    chosen = os.environ.get("CC", "").split()
    for command in [chosen] if chosen else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]):
            return command
    looked_for = f"$CC = {' '.join(chosen)}" if chosen else "$CC, cc, gcc and clang"
    raise ToolError(
        f"no C compiler found (looked for {looked_for}); install one, "
        f"for example with `apt-get install gcc` or `brew install gcc`, or set CC"
    )


def sources(directory: Path) -> list[Path]:
    """C files of the joint and the runtime in an exported folder.

    Raises:
        InputError: there are none.
    """
    found = sorted((directory / "src").rglob("*.c"))
    if not found:
        raise InputError(f"{directory}: holds no src/*.c; name a folder that `ccgen export` wrote")
    return found


def run_compiler(command: Sequence[str], folder: Path, failure: str) -> None:
    """Run a compiler that leaves its own temporary files in `folder`, where they end with it.

    Args:
        command: the compiler and its arguments.
        folder: a temporary one.
        failure: what is said before the compiler's reason.

    Raises:
        ToolError: it ended with an error.
    """
    place = {**os.environ, "TMPDIR": str(folder)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=place)
    if done.returncode != 0:
        raise ToolError(f"{failure}: {_first_error(done.stderr)}")


def _first_error(messages: str) -> str:
    """The line of a compiler's or linker's messages that says what is wrong."""
    lines = [line for line in messages.strip().splitlines() if not line.startswith("collect2")]
    words = ("error", "warning", "undefined", "overflowed", "is full")
    telling = (line for line in lines if any(word in line for word in words))
    return next(telling, lines[-1] if lines else "failed without a message")
