"""Compiles an exported folder for the host: as a shared library and as a process."""

from collections.abc import Sequence
from pathlib import Path

from ccgen.targets.compiler import LEVEL, WARNINGS, compiler, run_compiler, sources

FLAGS = ("-std=c99", "-ffp-contract=off", *WARNINGS)


def compile_shared(directory: Path, out: Path, level: str = LEVEL) -> Path:
    """Compile the joint and ports/shared into a shared library in the folder `out`."""
    root = directory.absolute()
    selftest = sorted((root / "selftest").glob("*_selftest.c"))
    files = [*sources(root), *selftest, root / "ports" / "shared" / "shared.c"]
    return _compile(directory, files, out / "libjoint.so", [level, "-shared", "-fPIC"])


def compile_process(directory: Path, out: Path, level: str = LEVEL) -> Path:
    """Compile the joint and ports/posix into a program in the folder `out`."""
    files = [*sources(directory), directory.absolute() / "ports" / "posix" / "main.c"]
    return _compile(directory, files, out / "node", [level])


def _compile(directory: Path, files: Sequence[Path], target: Path, flags: list[str]) -> Path:
    root = directory.absolute()
    include = [f"-I{root / folder}" for folder in ("src", "ports", "selftest")]
    command = [*compiler(), *FLAGS, *flags, *include, *map(str, files), "-o", str(target)]
    run_compiler(command, target.parent, f"{directory}: {command[0]} does not compile the folder")
    return target
