"""What commands print: results on stdout, everything else on stderr."""

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from ccgen.verify.plan import Progress


def print_json(result: Mapping[str, object]) -> None:
    """Print the one JSON object of a `--json` run on stdout.

    Raises:
        ValueError: a number that JSON does not know (nan, infinite).
    """
    sys.stdout.write(json.dumps(result, allow_nan=False) + "\n")


def note(message: str) -> None:
    """Print a message on stderr, on a line of its own."""
    print(f"ccgen: {message}", file=sys.stderr)


def results() -> "Console":
    """Return a console for tables on stdout."""
    from rich.console import Console

    return Console(highlight=False)


def progress() -> "Console":
    """Return a console for progress and live displays, on stderr."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


@contextmanager
def progress_bars() -> "Iterator[Progress]":
    """One bar on stderr for each thing that is being done, with its remaining time."""
    from rich import progress as bars

    columns = (
        bars.TextColumn("{task.description:<24}"),
        bars.BarColumn(),
        bars.MofNCompleteColumn(),
        bars.TimeRemainingColumn(),
    )
    tasks: dict[str, bars.TaskID] = {}
    console = progress()
    with bars.Progress(*columns, console=console, disable=not console.is_terminal) as shown:

        def report(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = shown.add_task(what)
            shown.update(tasks[what], completed=done, total=total)

        yield report
