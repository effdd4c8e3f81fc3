"""Which names a joint may have: they become C identifiers, file names and a CMake target."""

import re
from collections.abc import Callable

from ccgen.joint import reserved

LONGEST_NAME = 20
"""Longest name: the DBC allows 32 characters, and `_LENGTHS_15` and the like must follow."""

_OURS = ("ccgen", "can_", "port_", "pthread_")
"""Beginnings of names of the runtime, of the ports, and of POSIX threads."""

ENDINGS = (
    "angle", "angles", "binary", "can", "capture", "check", "count", "counts", "functions",
    "integer", "jacobian", "kinematics", "node", "pose", "restore", "selftest", "sensor",
    "sensors", "source",
)  # fmt: skip
"""Last words that a name may not have: `finger_node` and `finger` would both have
`finger_node_init`."""


def name_problem(name: str) -> str | None:
    """Return why `name` cannot be a joint's name, or None where it can."""
    return _form_problem(name) or _owner_problem(name)


def sensor_name_problem(name: str) -> str | None:
    """Return why `name` cannot be a sensor's name, or None where it can.

    Sensors appear behind the joint's name or behind a word, in C, in the DBC and in recordings.
    """
    problem = _form_problem(name)
    if problem is None and name in reserved.KEYWORDS:
        return "is a keyword of C or C++"
    return problem


def _form_problem(name: str) -> str | None:
    if not name:
        return "is empty"
    if len(name) > LONGEST_NAME:
        return f"has {len(name)} characters, {LONGEST_NAME} at most fit the DBC"
    if re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) is None:
        return "is not a C identifier"
    if name.startswith("_") or "__" in name:
        return "is reserved in C and C++ (leading or double underscore)"
    if name.endswith("_"):
        return f"ends in an underscore, so that {name}_t is reserved in C++"
    return None


def _owner_problem(name: str) -> str | None:
    """Return whose name it is already, in whole or in part."""
    lowered = name.lower()  # files meet on file systems that ignore case
    if name in reserved.KEYWORDS:
        return "is a keyword of C or C++"
    if lowered.startswith(_OURS):
        return "collides with the names of the runtime, its ports or POSIX threads"
    for words, problem in _TAKEN:
        if lowered in words:
            return problem(lowered)
    for prefix, whose in reserved.PREFIXES.items():
        if lowered.startswith(prefix):
            return f"begins like the names of {whose}"
    first, _, last = lowered.rpartition("_")
    if first and last in ENDINGS:
        return f"would collide with what a joint {first} has: its names go on with _{last}"
    return None


_TAKEN: tuple[tuple[frozenset[str], Callable[[str], str]], ...] = (
    (reserved.TYPES, "collides with the type {}_t of the C library".format),
    (reserved.HEADERS, "collides with the header {}.h of the C library".format),
    (reserved.FOLDER, lambda name: "collides with a file or target of the exported folder"),
    (reserved.CMAKE, lambda name: "is a target or a word of CMake"),
    (reserved.CMAKE_PACKAGES, lambda name: "is a package that CMake finds in its own way"),
    (reserved.CXX_TYPES, "collides with std::{}_t of C++".format),
    (
        reserved.FRAMEWORKS,
        lambda name: "collides with a header or library of Arduino, ESP-IDF, FreeRTOS or Zephyr",
    ),
    (reserved.DRIVERS, "collides with drivers of chips, which have {0}_init or {0}_t".format),
    (reserved.LIBRARIES, "collides with lib{}.a of the compiler".format),
    (reserved.DEVICES, lambda name: "is a device on Windows"),
)
"""Names that are taken, in the order in which they are said to be."""
