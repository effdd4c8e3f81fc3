"""`ccgen cost`: flash, RAM, stack and instructions on microcontrollers."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Level, Optimise
from ccgen.cli.output import note, print_json, progress_bars, results
from ccgen.errors import ToolError

if TYPE_CHECKING:
    from ccgen.cost.measure import Cost
    from ccgen.verify.exported import Exported


def cost(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder that `ccgen export` wrote.")
    ],
    target: Annotated[
        list[str] | None,
        typer.Option(
            help="One of them; may be given several times.  [default: all with their tools]"
        ),
    ] = None,
    max_flash: Annotated[
        int | None, typer.Option(min=0, metavar="N", help="Budget: bytes of code and constants.")
    ] = None,
    max_ram: Annotated[
        int | None, typer.Option(min=0, metavar="N", help="Budget: bytes without stack.")
    ] = None,
    max_stack: Annotated[
        int | None, typer.Option(min=0, metavar="N", help="Budget: bytes, worst case.")
    ] = None,
    max_instructions: Annotated[
        int | None,
        typer.Option(
            min=0, metavar="N", help="Budget of one estimate of both axes; for a named avr: cycles."
        ),
    ] = None,
    optimise: Optimise = Level.O2,
    write: Annotated[
        bool, typer.Option("--write", help="Put the table into the folder's README.md.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Tell what a folder costs on each target: compiled for it, and counted exactly.

    Targets: host (x86-64), cortex-m0, cortex-m3, cortex-m4, cortex-m7, riscv32, avr.

    Budgets hold for the targets that are named. Without --target they hold for every
    microcontroller, that of instructions not for AVR's cycles; the host is held to none, and a
    microcontroller that is left out because its tools are missing ends with status 2. What is over
    a budget ends with status 1.

    \b
    Example:
      ccgen cost firmware/shoulder --target cortex-m4 --max-flash 16384
    """
    require_counter()
    from ccgen.cost.budget import Budget, excesses
    from ccgen.verify.exported import open_exported

    exported = open_exported(directory)
    budget = Budget(max_flash, max_ram, max_stack, max_instructions)
    present, left_out = choose_targets(target)
    costs = measure_targets(exported, present, f"-O{optimise.value}")
    if write:
        from ccgen.cost.readme import write_table

        write_table(exported, costs)
        note(f"wrote the table into {directory / 'README.md'}")
    if json:
        print_json({"targets": [one.record() for one in costs]})
    else:
        show_costs(costs)
    over = list(excesses(costs, budget, named=bool(target)))
    for line in over:
        note(f"over budget: {line}")
    if over:
        raise typer.Exit(1)
    for name, message in left_out.items():
        if budget.held_by(name, named=False):
            raise ToolError(
                f"the budget is not checked on {message}, or name the targets with --target"
            )


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
    from ccgen.cost.cores import TARGETS, missing_tools

    present, left_out = [], {}
    for target in dict.fromkeys(named or TARGETS):
        missing = " ".join(missing_tools(target))
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
    console.print(table)
    console.print(
        f"Bytes of a whole node with tip pose and the compiler's own functions, {costs[0].level}: "
        "flash is code and constants, RAM is without stack. Instructions at most; on AVR cycles.",
        soft_wrap=True,
    )
