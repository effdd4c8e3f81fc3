"""Compiles the runtime for tests as `runtime_c.compile_c` does, object by object.

What is the same after its includes is compiled once: a mutant of the runtime differs from the next
in one file, and of a library of ten, nine objects are those of others.
"""

import hashlib
import os
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import runtime_c


def compile_objects(
    store: Path,
    files: Sequence[Path],
    flags: Sequence[str] = (),
    compiler: str = runtime_c.COMPILERS[0],
    target: Path | None = None,
) -> Path:
    """Compile what `store` does not hold yet, and link; otherwise as `runtime_c.compile_c`."""
    out = target or runtime_c.next_build()
    options = [*runtime_c.C99, *runtime_c.WARNINGS, *flags]
    command = (compiler, *options)
    objects = [f if f.suffix == ".o" else _object(store, f, command) for f in files]
    _run([compiler, *flags, *map(str, objects), "-o", str(out)])
    return out


def _object(store: Path, file: Path, command: tuple[str, ...]) -> Path:
    folders = (option for option in (*command, *runtime_c.INCLUDE) if option.startswith("-I"))
    content = f"{command}{file.name}".encode() + file.read_bytes() + _included(tuple(folders))
    kept = store / f"{file.stem}-{hashlib.sha256(content).hexdigest()[:16]}.o"
    if not kept.exists():
        made = kept.with_suffix(f".{os.getpid()}.o")
        _run([*command, *runtime_c.INCLUDE, "-c", str(file), "-o", str(made)])
        made.replace(kept)
    return kept


@cache
def _included(folders: tuple[str, ...]) -> bytes:
    """All that a file may include from folders, given as the compiler's options."""
    paths = (Path(option.removeprefix("-I")) for option in folders)
    found = (path for folder in paths for path in sorted(folder.rglob("*.[ch]")))
    return b"".join(path.read_bytes() for path in found)


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stderr}"
