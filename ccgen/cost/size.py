"""Bytes of flash and RAM, part by part, from the linker's map."""

import re
from dataclasses import dataclass
from pathlib import Path

from ccgen.errors import ToolError

_LINKED = "\nLinker script and memory map\n"
"""Before this heading the map lists what the linker discarded, in the same form."""

_ENTRY = re.compile(
    r"(?:^ \*fill\*\s+0x[0-9a-f]+\s+0x(?P<padding>[0-9a-f]+).*\n)?"
    r"^ (?P<section>\.\S+|COMMON)\s+0x[0-9a-f]+\s+0x(?P<size>[0-9a-f]+)\s+(?P<file>\S.*)$",
    re.MULTILINE,
)
"""A section of a file, with the padding that its alignment needs before it."""

HARNESS = "ccgen_harness"
"""Name of what only measures; no joint's name begins like this."""

FUNCTIONS = "functions"
"""The user's own, which no node needs."""

JACOBIAN = "jacobian"
"""The tip Jacobian in integers, likewise."""

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
    """Sizes by part of what was linked.

    Args:
        path: the map, of a link of objects that are named as `ccgen.cost.program` names them.
        joint: its name.

    Raises:
        ToolError: the linker writes its map in another form.
    """
    _, heading, linked = path.read_text(encoding="utf-8").partition(_LINKED)
    if not heading:
        raise ToolError(f"{path.name}: no linker's map of GNU binutils")
    sizes = dict.fromkeys((*PARTS, FUNCTIONS, JACOBIAN), Size())
    for entry in _ENTRY.finditer(linked):
        part = _part(entry["file"], joint)
        if part is not None:
            size = int(entry["size"], 16) + int(entry["padding"] or "0", 16)
            sizes[part] += _size(entry["section"], size)
    return sizes


def _part(file: str, joint: str) -> str | None:
    """Which part a linked file belongs to; None for what only measures and for start-up code."""
    name = Path(file).name
    parts = {
        f"{joint}.o": "estimator", f"{joint}_pose.o": "kinematics", f"{joint}_can.o": "node",
        f"{joint}_functions.o": FUNCTIONS, f"{joint}_jacobian.o": JACOBIAN,
    }  # fmt: skip
    if name in parts:
        return parts[name]
    if name == f"{HARNESS}.o" or re.match(r"crt.*\.o$", name):
        return None
    return "library" if ".a(" in file else "node"


def _size(section: str, size: int) -> Size:
    if section.startswith(".text"):
        return Size(code=size)
    if section.startswith(".progmem"):  # of AVR: not copied to RAM, as constants are
        return Size(code=size)
    if section.startswith((".rodata", ".srodata")):
        return Size(constants=size)
    if section.startswith((".data", ".sdata", ".bss", ".sbss", "COMMON")):
        return Size(variables=size)
    return Size()
