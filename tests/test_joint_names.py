"""No name that a joint may have meets another joint's names, or anybody else's.

What a joint's name becomes is read off exported folders: every word of the generated files that
holds the name, with another name in its place, is what another joint would bring.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_files import joint_text

from ccgen import resources
from ccgen.cost import harness
from ccgen.export.examples import EXAMPLES
from ccgen.export.package import export
from ccgen.joint import reserved
from ccgen.joint.names import ENDINGS, name_problem
from ccgen.targets.exported import open_exported

ROOT = Path(__file__).resolve().parent.parent
SAMPLE = "qzqz"
"""The exported joint's name, which no other word holds."""

KINDS = ("c", "dbc", "targets", "variables", "files")

CONTRACT = (
    "_zero", "_restore_zero", "_node_axes", "_node_estimate", "_node_unsent", "_sensors_t",
    "_sensors_init", "_sensors_pack",
)  # fmt: skip
"""Endings that the C interface keeps for itself beside those that it has."""

ELSEWHERE = ("arm_acle.h", "avr/", "simavr/")
"""Headers of other machines than this one."""

STANDARD = """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal
    stdarg stdbool stddef stdint stdio stdlib string tgmath time wchar wctype"""
POSIX = """aio cpio dirent dlfcn fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen monetary
    mqueue netdb nl_types poll pthread pwd regex sched search semaphore spawn stdatomic strings
    syslog tar termios threads uchar ulimit unistd utime utmpx wordexp"""
SYSTEMS = {
    "gcc": (["gcc", "-std=gnu17", "-D_GNU_SOURCE"], f"{STANDARD} {POSIX}"),
    "newlib": (["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb"], STANDARD.replace("tgmath", "")),
    "picolibc": (
        ["riscv64-unknown-elf-gcc", "-march=rv32imac", "-mabi=ilp32", "--specs=picolibc.specs"],
        STANDARD,
    ),
    "avr-libc": (
        ["avr-gcc", "-mmcu=atmega1284p"],
        "assert ctype errno inttypes math setjmp stdint stdio stdlib string time avr/io "
        "avr/interrupt avr/sleep avr/wdt avr/eeprom avr/pgmspace avr/power avr/boot util/atomic "
        "util/crc16 util/twi util/parity",
    ),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Exports of the two kinds of joint: 16 bits on classic CAN, 32 bits on CAN FD."""
    folder = tmp_path_factory.mktemp("names")
    for kind, options in (
        ("classic", {"precision": 16, "tables": ""}),
        ("fd", {"precision": 32, "tables": "[can]\nfd = true\n"}),
    ):
        source = folder / f"{kind}.toml"
        source.write_text(joint_text(SAMPLE, segments=4, count=2, **options))
        fd = kind == "fd"
        spoken = [name for name, own in EXAMPLES.items() if not (fd and own.classic_only)]
        export(source, folder / kind, examples=spoken)
    return [folder / "classic", folder / "fd"]


def words_of(paths):
    """Words of texts, without those of comments and strings."""
    return words_in("\n".join(path.read_text() for path in paths))


def words_in(text):
    """The same of one text."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*|\"[^\"\n]*\"", " ", text, flags=re.S)
    return set(re.findall(r"[A-Za-z_]\w*", text))


@pytest.fixture(scope="module")
def brought(folders):
    """What the sample joint brings: words of C, of the DBC and of CMake, and its files' names."""
    kinds = {"c": set(), "dbc": set(), "targets": set(), "files": set()}
    for folder in folders:
        files = [file for file in folder.rglob("*") if file.is_file()]
        # The runtime's own sources include no joint; its headers do.
        code = [
            f for f in files if f.suffix == ".h" or (f.suffix == ".c" and f.parent.name != "ccgen")
        ]
        kinds["c"] |= words_of(code)
        kinds["c"] |= words_in(harness.source(open_exported(folder)))
        kinds["dbc"] |= words_of(folder.glob("*.dbc"))
        kinds["targets"] |= words_of(f for f in files if f.name in ("CMakeLists.txt", "Kconfig"))
        kinds["files"] |= {file.name for file in files if SAMPLE in file.name}
    kinds["c"] |= {SAMPLE + ending for ending in CONTRACT}
    # What project() and find_package() of CMake make of a name.
    variables = ("SOURCE_DIR", "BINARY_DIR", "DIR", "VERSION", "VERSION_MAJOR", "FOUND", "CONFIG")
    kinds["variables"] = {f"{SAMPLE}_{end}" for end in variables}
    named = {
        kind: {word for word in words if SAMPLE in word.lower()} for kind, words in kinds.items()
    }
    assert {f"{SAMPLE}_node_init", f"{SAMPLE.upper()}_SEGMENTS", f"{SAMPLE}_t"} <= named["c"]
    assert {f"CCGEN_JOINT_{SAMPLE}_CAN_H", f"{SAMPLE}_selftest"} <= named["c"]
    assert {SAMPLE, f"{SAMPLE}_selftest", f"CCGEN_{SAMPLE.upper()}"} <= named["targets"]
    assert {f"{SAMPLE.upper()}_TIP", f"{SAMPLE.upper()}_SENSORS"} <= named["dbc"]
    assert {f"{SAMPLE}_kinematics.c", f"{SAMPLE}.dbc"} <= named["files"]
    return {
        **named,
        "others": {word for word in kinds["c"] if SAMPLE not in word.lower()},
    }


def names_of(brought, kind, name):
    """What a joint of this name brings, without regard to capitals."""
    return {word.lower().replace(SAMPLE, name.lower()) for word in brought[kind]}


def endings_of(brought):
    return {word.lower().partition(SAMPLE)[2] for word in brought["c"] | brought["targets"]}


def meeting(brought, words):
    """Names that a joint could have and that would then bring one of the words."""
    endings = {word.partition(SAMPLE)[2] for word in brought["c"] if word.startswith(SAMPLE)}
    endings |= {
        word.partition(SAMPLE.upper())[2]
        for word in brought["c"]
        if word.startswith(SAMPLE.upper())
    }
    return {word.removesuffix(end) for word in words for end in endings if word.endswith(end)} - {
        ""
    }


def legal(names):
    return sorted(name for name in names if name_problem(name) is None)


PARTS = st.sampled_from(
    ["finger", "arm", "a", "Finger", "index", "tip", "left", "x2", "u", "status", *ENDINGS]
)


@st.composite
def names(draw, brought):
    """Names like those that people give, with endings of the generated names behind them."""
    ending = st.sampled_from(["", *sorted(endings_of(brought))])
    part = PARTS | ending.map(lambda text: text.strip("_.") or "a")
    name = "_".join(draw(st.lists(part, min_size=1, max_size=3)))
    return name + draw(ending) if draw(st.booleans()) else name


def test_two_joints_of_one_program_have_no_name_in_common(brought):
    @settings(max_examples=1000, deadline=None)
    @given(st.data())
    def holds(data):
        first = data.draw(names(brought))
        second = data.draw(
            names(brought) | st.sampled_from(sorted(endings_of(brought))).map(first.__add__)
        )
        if name_problem(first) or name_problem(second) or first.lower() == second.lower():
            return
        for kind in KINDS:
            assert not names_of(brought, kind, first) & names_of(brought, kind, second)

    holds()


def test_what_lies_between_two_endings_ends_no_name(brought):
    """All pairs at once: a name that goes on with D meets where D + ending is an ending, too."""
    assert name_problem("finger") is None
    for kind in KINDS:
        ends = {word.lower().partition(SAMPLE)[2] for word in brought[kind]}
        between = {end.removesuffix(other) for end in ends for other in ends if end.endswith(other)}
        assert legal(f"finger{between_two}" for between_two in between - {""}) == []
    assert {name for name in ENDINGS if name_problem(f"finger_{name}") is None} == set()


def test_names_that_differ_in_capitals_only_are_said_when_they_meet(folders, tmp_path):
    for name in ("Finger", "finger"):
        text = (folders[0] / "src" / f"{SAMPLE}.h").read_text()
        text = text.replace(SAMPLE.upper(), "FINGER").replace(SAMPLE, name)
        (tmp_path / f"{name}.h").write_text(text)
    both = tmp_path / "both.c"
    both.write_text('#include "Finger.h"\n#include "finger.h"\n')
    command = ["gcc", "-std=c99", "-fsyntax-only", f"-I{folders[0] / 'src'}", str(both)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "another joint's name differs from finger in capitals only" in done.stderr


def test_no_name_meets_the_runtime_the_ports_the_harness_or_the_examples(brought, folders):
    places = (ROOT / "examples", folders[0] / "examples")
    example = [f for p in places for f in p.rglob("*") if f.suffix in (".c", ".cpp", ".ino")]
    own = ("shoulder", "wrist", SAMPLE)
    words = {w for w in words_of(example) if not w.lower().startswith(own)}
    words |= brought["others"]
    assert {"board_init", "ring_t", "word_t", "ccgen_node_t"} <= words
    assert legal(meeting(brought, words)) == []


def test_no_name_is_that_of_a_file_of_the_runtime_the_ports_or_an_example(folders):
    listed = subprocess.run(
        ["git", "-C", ROOT, "ls-files", "examples"], capture_output=True, text=True, check=False
    ).stdout.split()
    files = {Path(file) for file in listed}
    files |= {file.relative_to(folders[0]) for file in folders[0].rglob("*")}
    files = {file for file in files if file.suffix != ".toml"}
    parts = {part for file in files for part in (*file.parent.parts, file.stem)}
    own = {SAMPLE, f"{SAMPLE}_can", f"{SAMPLE}_kinematics", f"{SAMPLE}_selftest"}
    assert {"ring", "board", "main", "node", "batch", "posix", "bare_metal"} <= parts
    # Folders of one example each, and joints' own files.
    harmless = {path.name for path in (Path(ROOT) / "examples").iterdir() if path.is_dir()}
    harmless |= {"examples", "src", "shoulder", "wrist", "spine"}
    assert set(legal(parts - own)) <= harmless


def test_no_name_is_a_target_of_the_examples_or_of_the_folder(folders):
    made = (
        r"(?:add_executable|add_library|add_custom_target|add_test|project)\(\s*(?:NAME\s+)?(\w+)"
    )
    lists = [*(ROOT / "examples").rglob("CMakeLists.txt"), *folders[0].rglob("CMakeLists.txt")]
    targets = {name for file in lists for name in re.findall(made, file.read_text())}
    assert {"angles", "firmware", "two_joints", SAMPLE} <= targets
    assert legal(targets) == [SAMPLE]


def includes(headers):
    return "".join(f"#include <{header}>\n" for header in headers)


def preprocessed(command, headers, *flags):
    done = subprocess.run(
        [*command, "-E", *flags, "-"], input=includes(headers), capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return done.stdout


def words_declared(command, headers):
    """Words of all that the headers declare and define."""
    text = preprocessed(command, headers) + preprocessed(command, headers, "-dM")
    return set(re.findall(r"\b[A-Za-z]\w*", text))


@pytest.mark.parametrize("system", SYSTEMS)
def test_names_declared_by_the_systems_headers_stay_theirs(brought, system):
    command, headers = SYSTEMS[system]
    assert shutil.which(command[0]), f"{command[0]} is needed for this test"
    taken = meeting(brought, words_declared(command, [f"{header}.h" for header in headers.split()]))
    assert {"size", "uint8"} <= taken
    assert legal(taken) == []


def test_names_declared_by_the_headers_of_the_ports_stay_theirs(brought):
    sources = resources.firmware().rglob("*.[ch]")
    found = {h for s in sources for h in re.findall(r"#include <(.+)>", s.read_text())}
    headers = sorted(header for header in found if not header.startswith(ELSEWHERE))
    taken = meeting(brought, words_declared(["gcc", "-std=c99", "-D_GNU_SOURCE"], headers))
    assert {"speed", "u_int8", "pthread_mutex"} <= taken
    assert legal(taken) == []


def test_names_declared_by_the_library_of_cxx_stay_its_own(brought):
    words = words_declared(["g++", "-x", "c++", "-std=gnu++23"], ["bits/stdc++.h"])
    assert legal(meeting(brought, words)) == []


@pytest.mark.parametrize("system", SYSTEMS)
def test_no_header_of_the_system_is_hidden_by_the_joints_own(system):
    command, _ = SYSTEMS[system]
    listed = subprocess.run(
        [*command, "-E", "-v", "-x", "c", "/dev/null"], capture_output=True, text=True, check=True
    ).stderr
    folders = re.findall(r"^ (/\S+)$", listed.partition("#include <...>")[2], re.M)
    own = [folder for folder in folders if system != "gcc" or "/gcc/" in folder]
    headers = {file.stem for folder in own for file in Path(folder).glob("*.h")}
    if system == "gcc":  # other packages' headers lie beside the C library's
        package = subprocess.run(
            ["dpkg", "-L", "libc6-dev"], capture_output=True, text=True, check=True
        )
        files = re.findall(r"^/usr/include/([^/]+)\.h$", package.stdout, re.M)
        headers |= {*files}
    assert {"limits", "stddef"} <= headers
    assert legal(header for header in headers if not header.endswith("intrin")) == []


def test_no_name_is_a_target_or_a_package_of_cmake():
    def told(what):
        done = subprocess.run(["cmake", what], capture_output=True, text=True, check=True)
        return done.stdout

    packages = re.findall(r"^Find(\w+)$", told("--help-module-list"), re.M)
    assert {"ZLIB", "Threads"} <= set(packages)
    assert legal(packages) == []
    commands = [c for c in told("--help-command-list").split() if c.startswith(("if", "while"))]
    assert legal(commands) == []


def test_no_name_is_a_target_that_cmakes_generators_make(tmp_path):
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(p C)\nenable_testing()\ninclude(CTest)\n"
        "include(CPack)\nadd_library(l l.c)\ninstall(TARGETS l)\n"
    )
    (tmp_path / "l.c").write_text("int l(void);\nint l(void) { return 0; }\n")
    # A make above this test would have the one below say which folders it enters.
    alone = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    made = set()
    for generator in ("Unix Makefiles", "Ninja"):
        if generator == "Ninja" and not shutil.which("ninja"):
            continue
        build = tmp_path / generator
        subprocess.run(
            ["cmake", "-G", generator, "-S", tmp_path, "-B", build], check=True, capture_output=True
        )
        listed = subprocess.run(
            ["cmake", "--build", build, "--target", "help"],
            check=True,
            capture_output=True,
            text=True,
            env=alone,
        ).stdout
        made |= set(re.findall(r"^(?:\.\.\. )?([A-Za-z]\w*)\b", listed, re.M))
    assert {"edit_cache", "rebuild_cache", "depend", "list_install_components"} <= made
    assert legal(made - {"l", "The"}) == []


def test_no_name_is_a_header_or_a_library_of_arduino():
    root = Path("/usr/share/arduino/hardware/arduino/avr")
    assert root.is_dir(), "arduino-core-avr is needed for this test"
    headers = {file.stem for file in root.rglob("*.h")} | {f.name for f in root.glob("libraries/*")}
    assert {"Arduino", "Wire"} <= headers
    assert legal(headers) == []


WORDS = {
    "ring": "collides with a file or target of the exported folder",
    "board": "collides with a file or target of the exported folder",
    "edit_cache": "is a target or a word of CMake",
    "zlib": "is a package that CMake finds in its own way",
    "finger_can": "would collide with what a joint finger has: its names go on with _can",
    "finger_node": "would collide with what a joint finger has: its names go on with _node",
    "Finger_Node": "would collide with what a joint finger has: its names go on with _node",
    "finger_": "ends in an underscore, so that finger__t is reserved in C++",
    "servo": "collides with a header or library of Arduino, ESP-IDF, FreeRTOS or Zephyr",
    "gpio": "collides with drivers of chips, which have gpio_init or gpio_t",
    "m": "collides with libm.a of the compiler",
    "aux": "is a device on Windows",
    "esp_arm": "begins like the names of ESP-IDF",
    "regex": "collides with the type regex_t of the C library",
    "conditional": "collides with std::conditional_t of C++",
}


@pytest.mark.parametrize("name", WORDS)
def test_a_name_that_is_taken_is_refused_with_the_reason(name):
    assert name_problem(name) == WORDS[name]


PLAIN = """a finger thumb index arm elbow wrist shoulder spine neck trunk tail tongue leg hip knee
    ankle toe catheter endoscope gripper hand palm snake worm hose boom mast tentacle bellows
    actuator robot joint joint1 j1 segment left_arm right_arm finger1 finger_2 arm_left index_finger
    Arm fingertip finger_tip upper lower base probe leg_l_2 format Shoulder_2"""


@pytest.mark.parametrize("name", PLAIN.split())
def test_names_that_people_give_to_joints_are_free(name):
    assert name_problem(name) is None


def test_lists_hold_words_that_can_be_names():
    lists = [value for value in vars(reserved).values() if isinstance(value, frozenset)]
    assert len(lists) > 8
    for word in frozenset().union(*lists):
        assert re.fullmatch(r"[A-Za-z]\w*", word), word
        assert name_problem(word) is not None
