"""No name that a joint may have meets a name in the headers that the exported folder includes."""

import re
import subprocess
from pathlib import Path

import pytest

from ccgen import resources
from ccgen.export.package import export
from ccgen.joint.names import name_problem

ROOT = Path(__file__).resolve().parent.parent
ELSEWHERE = ("arm_acle.h", "avr/", "simavr/")
"""Headers of other machines than this one."""


def headers():
    sources = resources.firmware().rglob("*.[ch]")
    found = {h for s in sources for h in re.findall(r"#include <(.+)>", s.read_text())}
    return sorted(header for header in found if not header.startswith(ELSEWHERE))


def preprocessed(*flags):
    text = "".join(f"#include <{header}>\n" for header in headers())
    command = ["gcc", "-std=c99", "-D_GNU_SOURCE", "-E", *flags, "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="module")
def endings(tmp_path_factory):
    """What follows the joint's name in the names that its folder declares."""
    folder = tmp_path_factory.mktemp("names") / "out"
    export(ROOT / "examples" / "shoulder.toml", folder)
    files = [
        *folder.glob("src/shoulder*"),
        *folder.glob("selftest/*"),
        folder / "ports/port_joint.h",
    ]
    return set(re.findall(r"\bshoulder(_\w+)", "".join(file.read_text() for file in files)))


def test_names_declared_by_the_systems_headers_stay_theirs(endings):
    assert {"_t", "_init", "_estimate", "_node_t", "_tip_pose"} <= endings
    known = set(re.findall(r"\b[A-Za-z]\w*", preprocessed() + preprocessed("-dM")))
    taken = {word.removesuffix(end) for word in known for end in endings if word.endswith(end)}
    assert {"size", "speed", "u_int8", "pthread_mutex"} <= taken
    assert [name for name in sorted(taken - {""}) if name_problem(name) is None] == []


def test_no_header_of_the_system_is_hidden_by_the_joints_own():
    included = re.findall(
        r'^# \d+ "/usr/include/(?:[a-z0-9_]+-linux-gnu/)?(\w+)\.h"', preprocessed(), re.M
    )
    assert {"features", "stdio"} <= set(included)
    assert [name for name in sorted(set(included)) if name_problem(name) is None] == []
