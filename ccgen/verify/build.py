"""Compiles an exported folder for the host: as a shared library and as a process."""

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

FLAGS = ("-std=c99", "-ffp-contract=off", *WARNINGS)

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


def build_shared(directory: Path, out: Path, level: str = LEVEL) -> Path:
    """Compile the joint and ports/shared into a shared library in the folder `out`."""
    selftest = sorted((directory / "selftest").glob("*_selftest.c"))
    files = [*sources(directory), *selftest, directory / "ports" / "shared" / "shared.c"]
    return _compile(directory, files, out / "libjoint.so", [level, "-shared", "-fPIC"])


def build_process(directory: Path, out: Path, level: str = LEVEL) -> Path:
    """Compile the joint and ports/posix into a program in the folder `out`."""
    files = [*sources(directory), directory / "ports" / "posix" / "main.c"]
    return _compile(directory, files, out / "node", [level])


def _compile(directory: Path, files: Sequence[Path], target: Path, flags: list[str]) -> Path:
    include = [f"-I{directory / 'src'}", f"-I{directory / 'ports'}", f"-I{directory / 'selftest'}"]
    command = [*compiler(), *FLAGS, *flags, *include, *map(str, files), "-o", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip())
        raise ToolError(f"{directory}: {command[0]} does not compile the folder: {first}")
    return target
