"""Compiles the bare-metal programs of an exported folder for a core."""

from collections.abc import Sequence
from pathlib import Path

from ccgen.targets.compiler import WARNINGS, run_compiler, sources
from ccgen.targets.cores import Core

FLAGS = ("-std=c99", "-g", "-ffunction-sections", "-fdata-sections", "-ffp-contract=off", *WARNINGS)


def compile_firmware(
    directory: Path, core: Core, program: str, out: Path, options: Sequence[str]
) -> Path:
    """Compile one of the bare-metal programs for a core.

    Args:
        directory: an exported folder.
        core: the target.
        program: "node" or "batch".
        out: folder for the program.
        options: further flags, such as the level of optimisation.

    Raises:
        ToolError: the compiler or the linker does not accept the folder.
    """
    root = directory.absolute()
    ports = root / "ports"
    files = [
        *sources(root),
        *(sorted((root / "selftest").glob("*_selftest.c")) if program == "batch" else ()),
        ports / "bare_metal" / f"{program}.c",
        *(ports / file for file in core.board),
    ]
    folders = (root / "src", root / "selftest", ports, ports / "bare_metal")
    target = out / f"{program}.elf"
    command = [
        *core.compile, *FLAGS, *options, *(f"-I{folder}" for folder in folders),
        *map(str, files), *(flag.format(ports=ports) for flag in core.link),
        "-Wl,--gc-sections,--fatal-warnings", "-o", str(target),
    ]  # fmt: skip
    run_compiler(command, out, f"{directory}: {core.compile[0]}")
    return target
