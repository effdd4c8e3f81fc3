"""`ccgen report`: a joint's page for the design review."""

from pathlib import Path
from typing import Annotated

import typer

from ccgen.cli.output import note


def report(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="JOINT|DIR", help="A joint's file, or a folder that `ccgen export` wrote."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The page to write.")
    ] = Path("report.html"),
    cost: Annotated[
        bool,
        typer.Option(
            "--cost", help="Measure flash, RAM, stack and instructions on each core, too."
        ),
    ] = False,
) -> None:
    """Write one self-contained page about a joint: sensors, weights, errors, budgets.

    It needs no network and nothing beside it, and reads on paper, a phone and in the dark.

    \b
    Example:
      ccgen report shoulder.toml -o shoulder.html
    """
    from ccgen.report.page import report as written

    note(f"wrote {written(path, output, cost)}")
