"""The program `ccgen`: its global options, and one line for each command."""

import sys
from collections.abc import Sequence
from typing import Annotated, Any, cast

import typer

from ccgen import __version__
from ccgen.cli.bridge import bridge
from ccgen.cli.calibrate import calibrate
from ccgen.cli.check import check
from ccgen.cli.cost import cost
from ccgen.cli.export import export
from ccgen.cli.failures import Debug, in_one_line, say, unforeseen
from ccgen.cli.fit import fit
from ccgen.cli.init import init
from ccgen.cli.monitor import monitor
from ccgen.cli.output import note
from ccgen.cli.place import place
from ccgen.cli.report import report
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
app.command()(in_one_line(calibrate))
app.command()(in_one_line(export))
app.command()(in_one_line(check))
app.command()(in_one_line(verify))
app.command()(in_one_line(cost))
app.command()(in_one_line(bridge))
app.command()(in_one_line(monitor))
app.command()(in_one_line(report))
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


_INTERRUPTED = 130
"""Typer's status after Ctrl-C, of which it says nothing."""

_UsageError = cast(type[Exception], typer.BadParameter.__base__)
"""What every wrong word on the command line raises; Typer has no public name for it."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program and exit; `--debug` counts wherever it stands.

    Wrong words on the command line are one line on stderr, like every other error, and so is what
    nobody foresaw.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if "--debug" in words:
        words = ["--debug", *(word for word in words if word != "--debug")]
    try:
        status = app(words or ["--help"], prog_name="ccgen", standalone_mode=False)
    except _UsageError as error:
        status = _explain(error)
    except OSError as error:
        status = say(error)
    except Exception as error:
        status = unforeseen(error)
    if status == _INTERRUPTED:
        note("interrupted")
    sys.exit(status)


def _explain(error: Any) -> int:
    """Say what is wrong with the command line, and return the program's status."""
    command = error.ctx.command_path if error.ctx else "ccgen"
    message = error.format_message().replace("Value error, ", "").rstrip(".")
    note(f"error: {command}: {message[0].lower()}{message[1:]}; `{command} --help` tells more")
    return int(error.exit_code)


if __name__ == "__main__":
    main()
