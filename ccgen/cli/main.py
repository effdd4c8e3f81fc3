"""The program `ccgen`: its global options, and one line for each command."""

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from ccgen import __version__
from ccgen.cli.bridge import bridge
from ccgen.cli.cost import cost
from ccgen.cli.export import export
from ccgen.cli.failures import Debug, in_one_line
from ccgen.cli.fit import fit
from ccgen.cli.init import init
from ccgen.cli.place import place
from ccgen.cli.reproduce import reproduce
from ccgen.cli.simulate import simulate
from ccgen.cli.verify import verify

app = typer.Typer(
    name="ccgen",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help takes half the time
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

app.command()(in_one_line(init))
app.command()(in_one_line(simulate))
app.command()(in_one_line(fit))
app.command()(in_one_line(export))
app.command()(in_one_line(verify))
app.command()(in_one_line(cost))
app.command()(in_one_line(bridge))
app.command()(in_one_line(place))
app.command()(in_one_line(reproduce))


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"ccgen {__version__}")
        raise typer.Exit


@app.callback()
def ccgen(
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Estimate the shape of continuum joints, from a joint's description to proven C.

    \b
    Example:
      ccgen init shoulder
      ccgen fit shoulder.toml
      ccgen export shoulder.toml -o firmware
    """
    Debug.on = debug


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program; `--debug` counts wherever it stands."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if "--debug" in words:
        words = ["--debug", *(word for word in words if word != "--debug")]
    app(words, prog_name="ccgen")


if __name__ == "__main__":
    main()
