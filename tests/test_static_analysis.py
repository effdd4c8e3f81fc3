"""What analysers find in exported folders, read by strangers: nothing but what is listed here.

Cppcheck and MISRA C are in test_misra_record.py.
"""

import shutil
import subprocess
from pathlib import Path

import pytest
from runtime_c import HERE, WARNINGS
from test_export_examples import JOINTS

from ccgen.export.package import export
from ccgen.joint.file import parse_joint

NAMES = ("shoulder", "spine", "bellows")
"""16 bits on classic CAN; 32 bits on CAN FD; coupled axes with elongation and commands."""
VERSIONS = {"node": "0x050500", "legacy": "0x050402"}
"""ESP-IDF with the node API of TWAI, and before it."""
CONTROLLERS = (
    "can/can_timing.c", "bxcan/can_bxcan.c", "fdcan/can_fdcan.c", "mcp2515/can_mcp2515.c",
)  # fmt: skip
PROGRAMS = (
    "posix/main.c", "socketcan/main.c", "shared/shared.c", "bare_metal/node.c",
    "bare_metal/batch.c",
)  # fmt: skip

# What is left out, and why.
TIDY = (
    "-*", "bugprone-*", "cert-*", "clang-analyzer-*",
    # Matrices beside vectors, registers beside memory: in C one type has many meanings.
    "-bugprone-easily-swappable-parameters",
    # bugprone-reserved-identifier again, without its list of what is allowed.
    "-cert-dcl37-c", "-cert-dcl51-cpp",
)  # fmt: skip
ALLOWED = "_GNU_SOURCE;_POSIX_C_SOURCE"
"""Reserved names that a program has to define, as the C library says (feature_test_macros(7))."""
EVERYTHING = (
    "-Weverything", "-Wno-unknown-warning-option",
    "-Wno-declaration-after-statement",  # C99
    "-Wno-padded",  # what is padded depends on the core; nothing is sent as it lies in memory
    "-Wno-covered-switch-default",  # MISRA C 16.4 asks for a default
    "-Wno-disabled-macro-expansion",  # `sa_handler` of the C library is such a macro
    "-Wno-unsafe-buffer-usage",  # a pointer is how C takes an array
)  # fmt: skip
NO_WORDS = "empty paragraph passed to '\\param' command"
"""Of -Wdocumentation: a parameter whose name says it all has none."""
CASTS = ("-Wcast-qual", "-Wcast-align=strict", "-Wconversion", "-Wsign-conversion")
CXX_CASTS = (*CASTS, "-Wold-style-cast", "-Wuseless-cast")
"""For headers. A source in C casts as C does, and also to the type that a value has where `int`
has 32 bits and has not where it has 16."""
STANDARDS = ("c++11", "c++14", "c++17", "c++20", "c++23")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("analysed")
    for name in NAMES:
        export(parse_joint(JOINTS[name], f"{name}.toml"), folder / name)
    return folder


def include(folder: Path) -> list[str]:
    """Options that let every source find its headers."""
    places = ("src", "selftest", "ports", "ports/can", "ports/bare_metal")
    return ["-std=c99", *(f"-I{folder / place}" for place in places)]


def own(folder: Path) -> list[Path]:
    """What is generated for the joint."""
    return sorted([*folder.glob("src/*.c"), *folder.glob("selftest/*.c")])


def programs(folder: Path) -> list[Path]:
    """What every joint has alike, and compiles for itself."""
    return [folder / "ports" / program for program in PROGRAMS]


def shared(folder: Path) -> list[Path]:
    """What every joint has and compiles alike."""
    core = sorted(folder.glob("src/ccgen/*.c"))
    return [*core, *(folder / "ports" / port for port in CONTROLLERS)]


def idf(folder: Path, driver: str) -> list[str]:
    """Options and source of the port for ESP-IDF, with headers that stand in for it."""
    version = f"-DESP_IDF_VERSION={VERSIONS[driver]}"
    source = folder / "ports" / "twai" / "can_twai.c"
    return [version, "-isystem", str(HERE / "esp_idf"), str(source)]


def findings(command: list[object], **options: object) -> list[str]:
    """Lines with which a compiler or analyser warns."""
    program = str(command[0])
    assert shutil.which(program), f"needs {program}"
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False, **options
    )  # fmt: skip
    lines = (done.stdout + done.stderr).splitlines()
    found = [line for line in lines if "warning: " in line or "error: " in line]
    assert found or done.returncode == 0, done.stderr
    return [line for line in found if NO_WORDS not in line]


def tidy(files: list[Path], options: list[str]) -> list[str]:
    settings = f"{{key: bugprone-reserved-identifier.AllowedIdentifiers, value: '{ALLOWED}'}}"
    config = f"{{Checks: '{','.join(TIDY)}', CheckOptions: [{settings}]}}"
    return findings(["clang-tidy", "--quiet", f"--config={config}", *files, "--", *options])


def everything(*arguments: object) -> list[str]:
    return findings(["clang", *EVERYTHING, "-fsyntax-only", *arguments])


def analysed(folder: Path, *arguments: object) -> list[str]:
    return findings(["gcc", "-fanalyzer", "-O1", "-c", *arguments], cwd=folder)


@pytest.mark.parametrize("name", NAMES)
def test_clang_tidy_finds_nothing(folders, name):
    folder = folders / name
    files = own(folder)
    if name == NAMES[0]:
        files += programs(folder) + shared(folder)
    assert tidy(files, include(folder)) == []


@pytest.mark.parametrize("driver", VERSIONS)
def test_nothing_finds_anything_in_the_port_for_esp_idf(folders, tmp_path, driver):
    folder = folders / NAMES[0]
    *options, source = idf(folder, driver)
    options = [*include(folder), *options]
    assert tidy([source], options) == []
    assert everything(*options, source) == []
    assert analysed(tmp_path, *options, source) == []


@pytest.mark.parametrize("name", NAMES)
def test_gcc_and_clang_with_everything_turned_on_find_nothing(folders, tmp_path, name):
    folder = folders / name
    files = own(folder) + programs(folder) + (shared(folder) if name == NAMES[0] else [])
    assert everything(*include(folder), *files) == []
    for file in files:  # one by one: several are called main.c
        assert analysed(tmp_path, *include(folder), file) == []


@pytest.mark.parametrize("standard", STANDARDS)
@pytest.mark.parametrize("name", NAMES)
def test_headers_bring_no_cast_into_cxx_and_sources_convert_nothing_unsaid(
    folders, tmp_path, name, standard
):
    folder = folders / name
    options = [*include(folder)[1:], f"-std={standard}", "-fsyntax-only", *WARNINGS]
    headers = [path.name for path in folder.glob("src/*.h")]
    headers += [f"{port}/can_{port}.h" for port in ("bxcan", "fdcan", "mcp2515")]
    program = tmp_path / "all.cpp"
    program.write_text("".join(f'#include "{header}"\n' for header in headers))
    assert findings(["g++", *options, *CXX_CASTS, program]) == []
    # The controllers' ports clear a volatile queue as C alone can: they are compiled as C.
    files = own(folder) + programs(folder) + sorted(folder.glob("src/ccgen/*.c"))
    assert findings(["g++", *options, *CASTS, "-x", "c++", *files]) == []


PLANTED = """
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
uint8_t *planted(uint32_t wide);
uint8_t *planted(uint32_t wide) {
    uint8_t *const place = (uint8_t *)malloc(4u);
    *place = wide;
    return place;
}
void bare(uint8_t list[4]);
void bare(uint8_t list[4]) {
    memset(list, 0, sizeof(sizeof(uint32_t)));
}
"""


def test_each_tool_finds_what_is_planted(tmp_path):
    source = tmp_path / "planted.c"
    source.write_text(PLANTED)
    told = {
        "bugprone-sizeof-expression": tidy([source], ["-std=c99"]),
        "-Wimplicit-int-conversion": everything("-std=c99", source),
        "-Wanalyzer-possible-null-dereference": analysed(tmp_path, "-std=c99", source),
        "-Wconversion": findings(["g++", *CASTS, "-fsyntax-only", "-x", "c++", source]),
        "-Wold-style-cast": findings(["g++", *CXX_CASTS, "-fsyntax-only", "-x", "c++", source]),
    }
    for name, lines in told.items():
        assert any(name in line for line in lines), name
    undocumented = tmp_path / "undocumented.c"
    undocumented.write_text("/** \\param[in] other  of nothing */\nvoid f(int one);\n")
    assert any("-Wdocumentation" in line for line in everything(undocumented))
