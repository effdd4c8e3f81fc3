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
    "target", "flash", "RAM", "stack", "receive", "estimate", "pose", "transmit", "snapshot",
)  # fmt: skip
_CHECK = "check"
_BEFORE = TITLES.index("pose")
"""The column that is before its own, where sensors are checked."""


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
    section = f"{BEGIN}\n{markdown(costs, exported.joint.float_kinematics)}{END}\n"
    if _SECTION.search(text):
        text = _SECTION.sub(lambda _: section, text)
    else:
        text = f"{text.rstrip()}\n\n{section}"
    replace_file(exported.directory, "README.md", text.encode("utf-8"))


def markdown(costs: "Sequence[Cost]", has_float: bool = True) -> str:
    """A section with one row a target.

    Args:
        costs: of the folder on each target.
        has_float: whether the folder has kinematics in floating point.
    """
    unlinked = "SLCAN, kinematics in floating point" if has_float else "SLCAN"
    titles, rows = main_table(costs)
    lines = [
        "## What it costs", "",
        f"Of a whole node with its tip pose, compiled with `{costs[0].level}`: bytes of flash, "
        "code and constants with the compiler's own functions and without what only other calls "
        f"link ({unlinked}), RAM without stack, worst-case stack; the "
        "most instructions (AVR: cycles) that the parts of a snapshot took, its frames received, "
        "the estimate, the tip pose and its answer transmitted, and all of it. HEALTH, which "
        f"belongs to no snapshot, takes {_span([cost.times.health for cost in costs])} a frame. "
        f"{examination(costs)}Measured by `ccgen cost`.",
        "", *_markdown_table(titles, rows),
    ]  # fmt: skip
    if any(cost.times.functions for cost in costs):
        lines += ["", *_functions_table(costs)]
    return "\n".join(lines) + "\n"


def _functions_table(costs: "Sequence[Cost]") -> list[str]:
    titles, rows = functions_table(costs)
    return [
        "The functions of your own module, beside the node: the most instructions (AVR: cycles) of "
        "a call, and bytes of flash of all.",
        "", *_markdown_table(titles, rows),
    ]  # fmt: skip


def _markdown_table(titles: "Sequence[str]", rows: "Sequence[Sequence[str]]") -> list[str]:
    """Lines of a table whose first column is words and whose others are numbers."""
    head = [f"| {' | '.join(titles)} |", f"|---{'|---:' * (len(titles) - 1)}|"]
    return [*head, *(f"| {' | '.join(row)} |" for row in rows)]


def functions_table(costs: "Sequence[Cost]") -> tuple[list[str], list[list[str]]]:
    """Titles and rows, one a target, of what the user's own functions cost."""
    rows = [
        [
            cost.target,
            *(f"{taken:,}" for taken in cost.times.functions.values()),
            f"{cost.functions.code + cost.functions.constants:,}",
        ]
        for cost in costs
    ]
    return ["target", *costs[0].times.functions, "flash"], rows


def _span(numbers: "Sequence[int]") -> str:
    low, high = min(numbers), max(numbers)
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def main_table(costs: "Sequence[Cost]") -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Titles and rows, one a target, of what a node costs."""
    if costs[0].times.checks is None:
        return TITLES, [_row_of(cost) for cost in costs]
    return (*TITLES[:_BEFORE], _CHECK, *TITLES[_BEFORE:]), [_row_of(cost) for cost in costs]


def examination(costs: "Sequence[Cost]") -> str:
    """Sentences on what the checks take; empty where no sensors are checked."""
    examined = [
        f"{cost.times.checks.examined:,} ({cost.target})"
        for cost in costs
        if cost.times.checks is not None
    ]
    if not examined:
        return ""
    return (
        "The check is that of sensors that agree, in the snapshot too; where the sensors of every "
        f"group contradict each other it takes up to {', '.join(examined)} instead. "
    )


def _row_of(cost: "Cost") -> tuple[str, ...]:
    times = cost.times
    numbers = (
        cost.flash_bytes, cost.ram_bytes, cost.stack_bytes, times.receive, times.estimate,
        *(() if times.checks is None else (times.checks.quiet,)),
        times.tip_pose, times.transmit, times.snapshot,
    )  # fmt: skip
    return (cost.target, *(f"{number:,}" for number in numbers))
