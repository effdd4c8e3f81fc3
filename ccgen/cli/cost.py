"""`ccgen cost`: flash, RAM, stack and instructions on microcontrollers."""

from pathlib import Path
from typing import Annotated

import typer

from ccgen.cli.choices import Level, Optimise
from ccgen.cli.costs import note_left_out, show_costs
from ccgen.cli.output import note, print_json, progress_bars
from ccgen.errors import ToolError


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
    from ccgen.cost.budget import Budget, excesses
    from ccgen.cost.costs import cost as costed

    budget = Budget(max_flash, max_ram, max_stack, max_instructions)
    with progress_bars() as report:
        done = costed(directory, target, optimise, write, report)
    note_left_out(done.left_out)
    costs = done.targets
    if write:
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
    for name, message in done.left_out.items():
        if budget.held_by(name, named=False):
            raise ToolError(
                f"the budget is not checked on {message}, or name the targets with --target"
            )
