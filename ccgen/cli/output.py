"""What commands print: results on stdout, everything else on stderr."""

import json
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich import progress as bars
    from rich.console import Console
    from rich.table import Table

    from ccgen.verify.plan import Progress


_KEPT = frozenset(map(chr, (*range(0xDC80, 0xDD00), 0xA0)))
"""What a message keeps though it cannot be printed: bytes of file names that are no text."""

_ANY_WIDTH = 10_000
"""Columns, more than any table has."""

_LEAST_WIDTH = 20
"""Columns that are used however narrow the terminal is."""


def print_json(result: Mapping[str, object]) -> None:
    """Print the one JSON object of a `--json` run on stdout.

    Raises:
        ValueError: a number that JSON does not know (nan, infinite).
    """
    sys.stdout.write(json.dumps(result, allow_nan=False) + "\n")


def note(message: str) -> None:
    """Print a message on stderr, on a line of its own, whatever characters it holds."""
    line = "".join(c if c.isprintable() or c in _KEPT else repr(c)[1:-1] for c in message)
    print(f"ccgen: {line}", file=sys.stderr)


def warn(warnings: Iterable[str]) -> None:
    """Print warnings on stderr, each on a line of its own."""
    for warning in warnings:
        note(f"warning: {warning}")


def results() -> "Console":
    """Return a console for tables on stdout."""
    from rich.console import Console

    return Console(highlight=False, markup=False, emoji=False)


def show_table(table: "Table") -> None:
    """Print a table on stdout, whole: on a narrow terminal row by row, each value beneath its row.

    A column that may wrap does so first, at spaces. Elsewhere than on a terminal a table is as wide
    as it is, unless COLUMNS says how wide it may be.
    """
    from rich.console import Console

    console = results()
    needed = console.measure(table, options=console.options.update(max_width=_ANY_WIDTH)).maximum
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console = Console(highlight=False, markup=False, emoji=False, width=max(80, needed))
    if needed > console.width and not _narrowed(table, needed - console.width):
        for line in _row_by_row(table, max(console.width, _LEAST_WIDTH)):
            console.print(line, soft_wrap=True)
        return
    console.print(table)


def _narrowed(table: "Table", excess: int) -> bool:
    """Take the excess off the one column that may wrap, if its words stay whole."""
    wrapping = [column for column in table.columns if not column.no_wrap]
    if len(wrapping) != 1:
        return False
    cells = [str(cell) for cell in (wrapping[0].header, *wrapping[0].cells)]
    wanted = max(map(len, cells)) - excess
    if wanted < max((len(word) for cell in cells for word in cell.split()), default=1):
        return False
    wrapping[0].width = wanted
    return True


def _row_by_row(table: "Table", width: int) -> Iterator[str]:
    """Lines of a table that is too wide: a row's first cell, then a line for each other cell."""
    if table.title:
        yield str(table.title)
    first, *others = table.columns
    titles = [" ".join(str(column.header).split()) for column in others]
    longest = max(map(len, titles), default=0)
    for name, *values in zip(first.cells, *(column.cells for column in others), strict=True):
        yield f"{first.header} {str(name).strip()}".strip()
        for title, value in zip(titles, values, strict=True):
            yield from _wrapped(f"  {title:<{longest}}  ", str(value).strip(), width)
    if table.caption:
        yield from _wrapped("", str(table.caption), width)


def _wrapped(title: str, value: str, width: int) -> list[str]:
    """A title and its value, wrapped at spaces; on a line of its own where little room is left."""
    import textwrap

    behind = len(title) + len(value) <= width or width - len(title) >= _LEAST_WIDTH
    indent = " " * (len(title) if behind else 4)
    lines = textwrap.wrap(
        value, width - len(indent), break_long_words=False, break_on_hyphens=False
    ) or [""]
    if behind:
        return [title + lines[0], *(indent + line for line in lines[1:])]
    return [title.rstrip(), *(indent + line for line in lines)]


def progress() -> "Console":
    """Return a console for progress and live displays, on stderr."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, markup=False, emoji=False)


_SILENCE = 5.0
"""Seconds between lines of progress."""


@contextmanager
def progress_bars(lines: bool = False) -> "Iterator[Progress]":
    """One bar on stderr for each thing that is being done, with its remaining time.

    Nothing is imported or shown before something is told.

    Args:
        lines: whether to say now and then how far things are where no terminal shows bars.
    """
    if lines and not sys.stderr.isatty():
        yield _progress_lines()
        return
    shown = _Bars()
    try:
        yield shown.report
    finally:
        shown.stop()


def _progress_lines() -> "Progress":
    said = time.monotonic()

    def report(what: str, done: int, total: int) -> None:
        nonlocal said
        if time.monotonic() >= said + _SILENCE:
            note(f"{what}: {done} of {total}")
            said = time.monotonic()

    return report


class _Bars:
    """Bars that appear with the first report."""

    def __init__(self) -> None:
        self._progress: bars.Progress | None = None
        self._tasks: dict[str, bars.TaskID] = {}

    def report(self, what: str, done: int, total: int) -> None:
        progress = self._progress or self._started()
        if what not in self._tasks:
            self._tasks[what] = progress.add_task(what)
        progress.update(self._tasks[what], completed=done, total=total)

    def stop(self) -> None:
        if self._progress is not None:
            self._progress.stop()

    def _started(self) -> "bars.Progress":
        from rich import progress as bars

        console = progress()
        self._progress = bars.Progress(
            bars.TextColumn("{task.description:<24}"),
            bars.BarColumn(),
            bars.MofNCompleteColumn(),
            bars.TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._progress.start()
        return self._progress
