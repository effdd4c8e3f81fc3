"""Links a program for the emulator: tables and code from 64 KB on, variables at its RAM."""

from collections.abc import Sequence
from pathlib import Path

from ccgen.cost.emulator import RAM
from ccgen.resources import template
from ccgen.targets.compiler import run_compiler


def link(
    compiler: Sequence[str], files: Sequence[str | Path], roots: Sequence[str], target: Path
) -> Path:
    """Compile and link a program without start-up code.

    Args:
        compiler: the compiler and all of its flags.
        files: sources and objects.
        roots: symbols to keep, with everything that they use.
        target: the program to write; the linker's script and map are written beside it.

    Raises:
        ToolError: the compiler or the linker does not accept the files.
    """
    script = target.with_suffix(".ld")
    script.write_text(template("cost_link.ld.j2").render(ram=hex(RAM)))
    linker = ["-nostartfiles", f"-T{script}", "-Xlinker", f"-Map={target.with_suffix('.map')}"]
    linker += ["-Wl,--gc-sections", *(f"-Wl,--undefined={root}" for root in roots)]
    command = [*compiler, *map(str, files), *linker, "-o", str(target)]
    run_compiler(command, target.parent, command[0])
    return target
