"""The table of costs in the exported folder's README.

A plain export does not measure: its bytes would depend on the compilers of the machine. What
`ccgen cost --write` and `ccgen export --cost` put into the README stands between two markers,
replaces what stood there, and counts as exported.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.export.manifest import replace_file

if TYPE_CHECKING:
    from ccgen.cost.measure import Cost
    from ccgen.targets.exported import Exported

BEGIN, END = "<!-- ccgen cost: begin -->", "<!-- ccgen cost: end -->"

_SECTION = re.compile(f"{re.escape(BEGIN)}.*?{re.escape(END)}\n", re.DOTALL)

TITLES = (
    "target", "code", "constants", "RAM", "stack", "estimate", "tip pose", "frame", "snapshot",
)  # fmt: skip


def has_table(directory: Path) -> bool:
    """Whether the README.md of a folder holds a measured table."""
    path = directory / "README.md"
    text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
    section = _SECTION.search(text)
    return section is not None and "\n|---|" in section[0]


def write_table(exported: "Exported", costs: "Sequence[Cost]") -> None:
    """Put the table into the folder's README.md and its fingerprint into the manifest.

    Raises:
        InputError: the folder cannot be written.
    """
    path = exported.directory / "README.md"
    text = path.read_text(encoding="utf-8")
    section = f"{BEGIN}\n{markdown(costs)}{END}\n"
    if _SECTION.search(text):
        text = _SECTION.sub(lambda _: section, text)
    else:
        text = f"{text.rstrip()}\n\n{section}"
    replace_file(exported.directory, "README.md", text.encode("utf-8"))


def markdown(costs: "Sequence[Cost]") -> str:
    """A section with one row a target."""
    lines = [
        "## What it costs", "",
        f"Of a whole node with tip pose, compiled with `{costs[0].level}`: bytes of code and "
        "constants with the compiler's own functions and without what only other calls link "
        "(SLCAN, Jacobian), RAM without stack, worst-case stack; the most instructions "
        "(AVR: cycles) that one estimate of both axes, one tip pose, one received frame and one "
        "whole snapshot, from its frames in to its answers out, took. Measured by `ccgen cost`.",
        "", f"| {' | '.join(TITLES)} |", f"|---{'|---:' * (len(TITLES) - 1)}|",
    ]  # fmt: skip
    lines += [f"| {' | '.join(row)} |" for row in map(row_of, costs)]
    return "\n".join(lines) + "\n"


def row_of(cost: "Cost") -> tuple[str, ...]:
    """Cells of one target."""
    numbers = (
        cost.code_bytes, cost.constant_bytes, cost.ram_bytes, cost.stack_bytes,
        cost.times.estimate, cost.times.tip_pose, cost.times.frame, cost.times.snapshot,
    )  # fmt: skip
    return (cost.target, *(f"{number:,}" for number in numbers))
