"""What `ccgen cost` and `ccgen export --cost` share: which targets, measuring them, the table."""

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from ccgen.cli.output import note, progress_bars, results, show_table
from ccgen.errors import ToolError

if TYPE_CHECKING:
    from ccgen.cost.measure import Cost
    from ccgen.targets.exported import Exported


def require_counter() -> None:
    """Make sure that what counts is installed.

    Raises:
        ToolError: it is not.
    """
    for module in ("unicorn", "elftools"):
        try:
            import_module(module)
        except ImportError as error:
            raise ToolError(
                f"counting needs {module}; install it with `pip install 'ccgen[cost]'`"
            ) from error


def choose_targets(named: list[str] | None) -> tuple[list[str], dict[str, str]]:
    """Targets to measure, and what each of the others needs, which is said on stderr.

    Raises:
        InputError: unknown target.
        ToolError: a tool of a named target is missing, or no target has its tools.
    """
    from ccgen.targets.cores import COUNTED, core_named, missing_tools

    present, left_out = [], {}
    for target in dict.fromkeys(named or COUNTED):
        missing = " ".join(missing_tools(core_named(target, COUNTED), to_run=False))
        if not missing:
            present.append(target)
            continue
        message = f"{target}: needs {missing}; install with `apt-get install {missing}`"
        if named:
            raise ToolError(message)
        note(f"left out: {message}")
        left_out[target] = message
    if not present:
        raise ToolError("no target is left to measure")
    return present, left_out


def measure_targets(exported: "Exported", targets: Sequence[str], level: str) -> "list[Cost]":
    """Costs of the targets, with a bar while they are measured."""
    from ccgen.cost.measure import measure

    costs: list[Cost] = []
    with progress_bars() as report:
        for target in targets:
            report("targets", len(costs), len(targets))
            costs.append(measure(exported, target, level))
    return costs


def show_costs(costs: "Sequence[Cost]") -> None:
    """Print the table on stdout."""
    from rich.table import Table

    from ccgen.cost.readme import TITLES, row_of

    table = Table(box=None, pad_edge=False)
    for title in TITLES:
        table.add_column(title, justify="left" if title == TITLES[0] else "right", no_wrap=True)
    for one in costs:
        table.add_row(*row_of(one))
    console = results()
    show_table(table)
    console.print(
        f"Bytes of a whole node with tip pose and the compiler's own functions, {costs[0].level}: "
        "flash is code and constants, RAM is without stack. Instructions at most; on AVR cycles.",
        soft_wrap=True,
    )
