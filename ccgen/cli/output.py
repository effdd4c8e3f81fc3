"""What commands print: results on stdout, everything else on stderr."""

import json
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


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
