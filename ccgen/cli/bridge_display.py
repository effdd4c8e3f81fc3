"""What `ccgen bridge` shows while it runs: a table in place, or a line a second."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from rich.console import Group
from rich.live import Live
from rich.table import Table

from ccgen.can.bridge import Floats, Stream
from ccgen.can.exchange import Answer
from ccgen.cli.output import note, progress

Show = Callable[[Answer], None]

_REDRAW_SECONDS = 0.1
_REPORT_SECONDS = 1.0
_BARS = "▁▂▃▄▅▆▇█"


@contextmanager
def display(stream: Stream, where: str) -> Iterator[Show]:
    """Give what shows an answer: as a live table on a terminal, in plain lines elsewhere."""
    if not sys.stderr.isatty():
        yield _every(_REPORT_SECONDS, lambda answer, _: note(_line(stream, answer)))
        return
    with Live(console=progress(), auto_refresh=False, transient=True) as live:
        yield _every(
            _REDRAW_SECONDS,
            lambda answer, seconds: live.update(
                _table(stream, where, answer, seconds), refresh=True
            ),
        )


def _every(interval: float, show: Callable[[Answer, float], None]) -> Show:
    """Pass on an answer once an interval, with the seconds since the start."""
    begin = last = time.monotonic()

    def show_sometimes(answer: Answer) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= interval:
            last = now
            show(answer, now - begin)

    return show_sometimes


def _line(stream: Stream, answer: Answer) -> str:
    errors = stream.error_percent_rom(answer)
    said = ", ".join(f"{axis} {error:.3f}" for axis, error in errors.items())
    error = f"error {said} % of range, " if said else ""
    return (
        f"snapshot {answer.index + 1} of {len(stream.counts)}: {error}"
        f"{answer.lost_frames} frames lost"
    )


def _table(stream: Stream, where: str, answer: Answer, seconds: float) -> Group:
    table = Table(title=f"{stream.joint.name} on {where}: {stream.source}")
    for column in ("axis", "counts", "estimate"):
        table.add_column(column)
    if stream.shapes is not None:
        table.add_column("true shape")
        table.add_column("error, % of range", justify="right")
    errors = stream.error_percent_rom(answer)
    estimated, true = stream.estimated_values(answer.angles), stream.true_values(answer.index)
    counts, told = stream.counts[answer.index], set()
    for axis, model in stream.model.axes.items():
        # Axes that share their sensors tell the counts once.
        own = [] if model.first in told else counts[model.part]
        told.add(model.first)
        known = []
        if true:
            error = f"{errors[axis]:.3f}" if axis in errors else ""
            known = [_drawn(stream, axis, true[axis]), error]
        table.add_row(
            axis,
            " ".join(f"{count:6d}" for count in own),
            _drawn(stream, axis, estimated[axis]),
            *known,
        )
    return Group(table, _footer(stream, answer, seconds))


def _drawn(stream: Stream, axis: str, values: Floats) -> str:
    """Bends as bars; elongations in per cent."""
    if np.isnan(values).any():
        return "no reading"
    if axis == "h":
        return " ".join(f"{100.0 * share:.2f} %" for share in values)
    return _bars(values, stream.joint.geometry.range_of_motion)


def _bars(angles: Floats, largest: float) -> str:
    """One bar a segment, from -largest to largest, and the bend of the whole joint."""
    steps = np.clip((angles / largest + 1) / 2 * len(_BARS), 0, len(_BARS) - 1).astype(int)
    return "".join(_BARS[k] for k in steps) + f" {np.degrees(angles.sum()):7.2f}°"


def _footer(stream: Stream, answer: Answer, seconds: float) -> str:
    scale = 1000.0 * 2.0**-stream.tip_fraction_bits
    tip = " ".join(f"{scale * value:7.1f}" for value in answer.tip)
    missing = answer.status.missing_sensors if answer.status else 0
    return (
        f"tip {tip} mm\n"
        f"snapshot {answer.index + 1} of {len(stream.counts)}, "
        f"{(answer.index + 1) / seconds:.0f} a second, {answer.lost_frames} frames lost, "
        f"{missing.bit_count()} sensors missing"
    )
