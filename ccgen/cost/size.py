"""Bytes of flash and RAM, part by part, from the linker's map."""

import re
from dataclasses import dataclass
from pathlib import Path

_ENTRY = re.compile(r"^ (\.[^\s]+)\s+0x[0-9a-f]+\s+0x([0-9a-f]+)\s+(\S.*)$", re.MULTILINE)

PARTS = ("estimator", "kinematics", "node", "library")
"""The joint's three parts, the runtime counted as the node's, and the compiler's own functions."""


@dataclass(frozen=True)
class Size:
    """Bytes of one part.

    Attributes:
        code: in flash.
        constants: in flash; on a core that reads tables from RAM also there.
        variables: in RAM, beside what the caller owns.
    """

    code: int = 0
    constants: int = 0
    variables: int = 0

    def __add__(self, other: "Size") -> "Size":
        return Size(
            self.code + other.code,
            self.constants + other.constants,
            self.variables + other.variables,
        )


def read_map(path: Path, joint: str) -> dict[str, Size]:
    """Sizes by part.

    Args:
        path: the map, of a link of objects that are named after their sources.
        joint: its name.
    """
    sizes = dict.fromkeys(PARTS, Size())
    for section, size, file in _ENTRY.findall(path.read_text(encoding="utf-8")):
        part = _part(file, joint)
        if part is not None:
            sizes[part] += _size(section, int(size, 16))
    return sizes


def _part(file: str, joint: str) -> str | None:
    """Which part a linked file belongs to; None for what only measures and for start-up code."""
    name = Path(file).name
    if name == "harness.o" or re.match(r"crt.*\.o$", name):
        return None
    parts = {f"{joint}.o": "estimator", f"{joint}_kinematics.o": "kinematics"}
    return "library" if ".a(" in file else parts.get(name, "node")


def _size(section: str, size: int) -> Size:
    if section.startswith(".text"):
        return Size(code=size)
    if section.startswith((".rodata", ".srodata", ".progmem")):
        return Size(constants=size)
    if section.startswith((".data", ".sdata", ".bss", ".sbss")):
        return Size(variables=size)
    return Size()
