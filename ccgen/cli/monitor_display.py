"""What `ccgen monitor` shows: a table in place on a terminal, a line a second elsewhere."""

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Group
from rich.live import Live
from rich.table import Table

from ccgen.can.layout import AXIS_STATES, ZERO_STATES
from ccgen.can.monitor import Monitor
from ccgen.can.seen import Seen, plain
from ccgen.cli.output import note, progress, show_table

if TYPE_CHECKING:
    from ccgen.targets.exported import Exported

_REPORT_SECONDS = 1.0
_BARS = "▁▂▃▄▅▆▇█"
_WORDS = {
    "good": "good", "repeated": "repeated", "some_lost": "lost some", "bad_crc": "bad checksum",
    "bad_format": "bad format", "reordered": "reordered", "late": "late", "stale": "stale",
    "missing": "sensor missing", "suspected": "sensor suspected", "never_seen": "never seen",
}  # fmt: skip


@contextmanager
def display(
    watch: Monitor, exported: "Exported", where: str, hidden: bool
) -> Iterator[Callable[[], None]]:
    """Give what shows the present state of the watch; call it as often as you like."""
    if hidden:
        yield lambda: None
        return
    if sys.stderr.isatty():
        with Live(console=progress(), auto_refresh=False, transient=True) as live:
            yield lambda: live.update(table(watch, exported, where), refresh=True)
        return
    last = time.monotonic()

    def report() -> None:
        nonlocal last
        if time.monotonic() - last >= _REPORT_SECONDS:
            last = time.monotonic()
            note(line(watch))

    yield report


def line(watch: Monitor) -> str:
    """The watch in one line."""
    faults = ", ".join(f"{count} {_WORDS[name]}" for name, count in watch.faults.items())
    return f"{watch.told} snapshots, {watch.rate_hz:.0f} a second: {faults or 'none yet'}"


def table(watch: Monitor, exported: "Exported", where: str) -> Group:
    """The latest snapshot and the state of every frame."""
    return Group(
        _snapshot(watch, exported, where), _frames(watch, "now", watch.states()), _footer(watch)
    )


def show_summary(watch: Monitor, where: str) -> None:
    """Print what the whole watch came to on stdout."""
    totals = Table(title=where, show_header=False)
    totals.add_row("snapshots", f"{watch.told}, {watch.rate_hz:.1f} a second")
    for name, count in watch.faults.items():
        totals.add_row(_WORDS[name], str(count))
    totals.add_row("the node told", ", ".join(sorted(watch.node_faults)) or "no faults")
    totals.add_row(
        "reference model", f"{watch.mismatches} values of {watch.compared} snapshots differ"
    )
    show_table(totals)
    show_table(_frames(watch, "last", {f.name: f.state for f in watch.frames.values()}))


def _snapshot(watch: Monitor, exported: "Exported", where: str) -> Table:
    shown = Table(title=f"{exported.joint.name} on {where}")
    for column in ("axis", "counts", "estimate"):
        shown.add_column(column)
    seen = watch.latest
    if seen is None:
        shown.add_row("", "", "no snapshot yet")
        return shown
    record, told = plain(seen, exported.model, exported.layout), set()
    for axis, model in exported.model.axes.items():
        own = seen.counts[model.part] if seen.counts and model.first not in told else ()
        told.add(model.first)
        counts = " ".join(f"{'–' if count is None else count:>6}" for count in own)
        values = record["elongation"] if axis == "h" else record["angles_deg"][axis]
        shown.add_row(axis, counts, _drawn(exported, axis, values))
    tip = " ".join("–" if x is None else f"{1000.0 * x:7.1f}" for x in record["tip_m"])
    shown.add_row("tip", "", f"{tip} mm")
    shown.add_row("faults", "", _said(seen))
    return shown


def _said(seen: Seen) -> str:
    words = ", ".join(_WORDS[name] for name in seen.faults)
    sensors = [f"{name} missing" for name in seen.missing]
    sensors += [f"{name} suspected" for name in seen.suspected]
    return ": ".join(filter(None, (words, ", ".join(sensors))))


def _drawn(exported: "Exported", axis: str, values: list[float | None]) -> str:
    """Bends as bars, and the bend of the whole joint; elongations in per cent."""
    there = [value for value in values if value is not None]
    if len(there) < len(values):
        return "no estimate"
    if axis == "h":
        return " ".join(f"{100.0 * share:.2f} %" for share in there)
    largest = exported.joint.geometry.range_of_motion * 57.29577951308232
    steps = [int((value / largest + 1) / 2 * len(_BARS)) for value in there]
    bars = "".join(_BARS[min(max(step, 0), len(_BARS) - 1)] for step in steps)
    return f"{bars} {sum(there):7.2f}°"


def _frames(watch: Monitor, title: str, states: Mapping[str, str]) -> Table:
    shown = Table()
    for column in ("frame", title):
        shown.add_column(column)
    shown.add_column("frames", justify="right")
    shown.add_column("not good")
    for frame in watch.frames.values():
        others = [f"{n} {_WORDS[s]}" for s, n in frame.counts.items() if s != "good"]
        good = f"{frame.counts['good']:,}"
        shown.add_row(frame.name, _WORDS[states[frame.name]], good, ", ".join(others))
    return shown


def _footer(watch: Monitor) -> str:
    health = watch.health
    parts = [f"{watch.told} snapshots, {watch.rate_hz:.0f} a second"]
    if watch.compared:
        parts.append(f"{watch.mismatches} values differ from the model")
    if health is not None:
        states = zip("uvh", (health.axis_u, health.axis_v, health.axis_h), strict=True)
        parts += [f"{axis} {AXIS_STATES[state]}" for axis, state in states if state < 3]
        parts.append(f"zero {ZERO_STATES[min(health.zero, len(ZERO_STATES) - 1)]}")
    return ", ".join(parts)
