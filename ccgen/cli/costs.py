"""What `ccgen cost` and `ccgen export --cost` share: what is said, and the table."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ccgen.cli.output import note, results, show_table

if TYPE_CHECKING:
    from rich.table import Table

    from ccgen.cost.measure import Cost


def note_left_out(left_out: Mapping[str, str]) -> None:
    """Say which targets are not measured, and what each would need."""
    for message in left_out.values():
        note(f"left out: {message}")


def show_costs(costs: "Sequence[Cost]") -> None:
    """Print the table on stdout."""
    from ccgen.cost.readme import examination, functions_table, main_table

    console = results()
    show_table(_table(*main_table(costs)))
    console.print(
        f"Bytes of a whole node with tip pose and the compiler's own functions, {costs[0].level}: "
        "flash is code and constants, RAM is without stack. Instructions at most, on AVR cycles, "
        "of the parts of a snapshot and of all of it, without HEALTH. "
        f"{examination(costs)}".rstrip(),
        soft_wrap=True,
    )
    if costs[0].times.functions:
        show_table(_table(*functions_table(costs)))
        console.print("Your own functions: a call of each, and the flash of all.")


def _table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> "Table":
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for title in titles:
        table.add_column(title, justify="left" if title == titles[0] else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table
