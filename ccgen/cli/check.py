"""`ccgen check`: whether the joints of one bus go together."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.output import note, print_json, results, show_table
from ccgen.errors import InputError

if TYPE_CHECKING:
    from ccgen.check.report import Checked


def check(
    paths: Annotated[
        list[Path],
        typer.Argument(metavar="PATH...", help="Joint files and exported folders of one bus."),
    ],
    junit: Annotated[
        Path | None,
        typer.Option("--junit", metavar="FILE", help="Write the report as JUnit XML, too."),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check that joint files and exported folders of one bus go together.

    Identifiers that overlap, data IDs of the end-to-end protection that coincide, different bit
    rates, more than 70 % of the bus, names that meet in one program, folders that are older than
    their joint file or were edited: each is a problem, and ends with status 1.

    \b
    Example:
      ccgen check shoulder.toml wrist.toml
      ccgen check joints/*.toml firmware/* --junit check.xml
    """
    from ccgen.check.report import check as checked
    from ccgen.check.report import junit as as_xml
    from ccgen.outputs import write_file

    if junit is not None and junit.suffix.lower() != ".xml":
        raise InputError(f"--junit: {junit}: is not named as XML; give a name that ends in .xml")
    found = checked(paths)
    if junit is not None:
        write_file(junit, as_xml(found))
        note(f"wrote {junit}")
    if json:
        print_json(found.record())
    else:
        _show(found)
    if found.problems:
        raise typer.Exit(1)


def _show(found: "Checked") -> None:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for title in ("joint", "of", "identifiers"):
        table.add_column(title, no_wrap=True)
    table.add_column("bus at most", justify="right", no_wrap=True)
    for joint in found.joints:
        ids = f"{joint.layout.base_id:#x} to {joint.layout.last_id:#x}"
        table.add_row(joint.name, str(joint.path), ids, f"{100.0 * joint.load:.0f} %")
    if len(found.joints) > 1:
        table.add_row("all", "", "", f"{100.0 * found.bus_load:.0f} %")
    console = results()
    show_table(table)
    for problem in found.problems:
        console.print(f"FAILED: {problem.file}: {problem.text}", soft_wrap=True)
    if not found.problems:
        console.print("No problem found.")
