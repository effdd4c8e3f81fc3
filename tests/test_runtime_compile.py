"""The C runtime compiles everywhere it claims to, with every warning an error."""

import subprocess
from pathlib import Path

import pytest
from runtime_c import C99, COMPILERS, CXX14, GLUE, INCLUDE, PORTS, RUNTIME, SAMPLE, WARNINGS

from ccgen.resources import firmware

LIBRARY = (*RUNTIME, *GLUE, SAMPLE / "sample.c", PORTS / "shared" / "shared.c")
PROGRAMS = (PORTS / "posix" / "main.c", PORTS / "socketcan" / "main.c")
HEADERS = tuple(sorted((firmware() / "include" / "ccgen").glob("*.h")))
STRICT = (
    "-Wlogical-op", "-Wduplicated-cond", "-Wredundant-decls", "-Wcast-qual", "-Wcast-align=strict",
    "-Wwrite-strings", "-Wformat=2", "-Wbad-function-cast", "-Wstrict-prototypes",
    "-Wold-style-definition", "-Wnull-dereference", "-Wjump-misses-init",
)  # fmt: skip
"""Warnings of gcc that projects turn on beyond those of every compiler."""
STRICT_CXX = (
    "-Wold-style-cast", "-Wuseless-cast", "-Wzero-as-null-pointer-constant", "-Wextra-semi",
    "-Wlogical-op",
)  # fmt: skip
"""What projects in C++ turn on for the headers that they include."""
INLINED = "_inline.h"
"""How headers end that only the joint's generated C includes."""


def compile_each(folder: Path, compiler: str, language: tuple[str, ...], *files: Path) -> None:
    command = [compiler, *language, *WARNINGS, *INCLUDE, "-O2", "-c", *map(str, files)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("language", [C99, CXX14], ids=["C99", "C++14"])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_every_source_compiles_without_a_warning(compiler, language, tmp_path):
    compile_each(tmp_path, compiler, language, *LIBRARY)
    for program in PROGRAMS:
        compile_each(tmp_path, compiler, language, program)


@pytest.mark.parametrize("language", [C99, CXX14], ids=["C99", "C++14"])
def test_every_header_compiles_on_its_own_and_twice(language, tmp_path):
    files = []
    for header in HEADERS:
        file = tmp_path / f"only_{header.stem}.c"
        file.write_text(f'#include "ccgen/{header.name}"\n' * 2 + "extern int nothing;\n")
        files.append(file)
    compile_each(tmp_path, COMPILERS[0], language, *files)


@pytest.mark.parametrize(
    "file", [*LIBRARY, *PROGRAMS], ids=lambda file: f"{file.parent.name}/{file.name}"
)
def test_no_source_meets_a_warning_that_only_some_projects_turn_on(file, tmp_path):
    compile_each(tmp_path, "gcc", (*C99, *STRICT), file)


@pytest.mark.parametrize("standard", ["c++11", "c++14", "c++20"])
def test_headers_are_free_of_casts_that_a_project_in_cxx_refuses(standard, tmp_path):
    file = tmp_path / "all.cpp"
    names = [header.name for header in HEADERS if not header.name.endswith(INLINED)]
    file.write_text("".join(f'#include "ccgen/{name}"\n' for name in names))
    compile_each(tmp_path, "g++", (f"-std={standard}", *STRICT_CXX), file)


def test_runtime_needs_no_library_headers():
    allowed = {"limits.h", "stdbool.h", "stddef.h", "stdint.h", "arm_acle.h", "avr/pgmspace.h"}
    used = set()
    for file in (*RUNTIME, *HEADERS):
        for line in file.read_text().splitlines():
            if line.startswith("#include <"):
                used.add(line.split("<")[1].split(">")[0])
    assert {"stdint.h", "stdbool.h", "stddef.h"} <= used <= allowed


def test_runtime_keeps_no_state_of_its_own(tmp_path):
    """No writable data section in any object of the runtime."""
    for file in RUNTIME:
        compile_each(tmp_path, COMPILERS[0], C99, file)
        listing = subprocess.run(
            ["nm", str(tmp_path / f"{file.stem}.o")], capture_output=True, text=True, check=True
        ).stdout
        writable = [line for line in listing.splitlines() if line.split()[-2] in "BbDdCSs"]
        assert not writable, f"{file.name}: {writable}"
