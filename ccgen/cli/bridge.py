"""`ccgen bridge`: lengths to a node, its estimates back, live."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Speed
from ccgen.cli.folders import opened
from ccgen.cli.output import print_json, show_table, warn
from ccgen.errors import BusError, CheckError, InputError

if TYPE_CHECKING:
    import can

    from ccgen.can.bridge import Stream, Summary
    from ccgen.can.replay import Replay
    from ccgen.targets.exported import Exported


def bridge(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="DIR|JOINT",
            help="A folder that `ccgen export` wrote, or a joint's file to export for this once.",
        ),
    ],
    interface: Annotated[
        str, typer.Option("--interface", help="python-can's name of the bus.")
    ] = "virtual",
    channel: Annotated[
        str | None,
        typer.Option(
            "--channel",
            help="python-can's channel, such as can0. Without one, `virtual` and `slcan` run the "
            "folder's node on this machine.",
        ),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(
            "--target",
            metavar="CORE",
            help="Run the node on an emulated microcontroller, such as cortex-m4, over its UART.",
        ),
    ] = None,
    source: Annotated[
        str | None,
        typer.Option(
            "--source",
            metavar="MOTION|FILE",
            help="What moves the joint: cases, random, sweep, loads that it states, or the counts "
            "of a file, a log of the bus (.log, .asc, .blf, .csv) or a recording's CSV.  "
            "[default: loads, or cases where the joint states none]",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds", min=0.0, help="How long to stream.  [default: 10, or the whole file]"
        ),
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(
            "--rate",
            metavar="HZ",
            min=0.1,
            max=100_000.0,
            help="Snapshots a second of a motion.  [default: one a cycle]",
        ),
    ] = None,
    speed: Annotated[
        Speed | None,
        typer.Option(
            "--speed",
            help="Send a file at its own times, or as fast as answers come.  [default: 1]",
        ),
    ] = None,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log", metavar="FILE", help="Log every frame: .log (candump), .asc, .blf or .csv."
        ),
    ] = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="SENSOR=FAULT@SECONDS",
            help="From then on the sensor is `stuck`, `lost` or off by `offset:METRES`; may be "
            "given again.",
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    json_lines: Annotated[
        bool,
        typer.Option(
            "--json-lines", help="Print one JSON object a snapshot, as monitor does, and a summary."
        ),
    ] = False,
) -> None:
    """Stream sensor lengths to a node; compare its estimates with the model and the true shape.

    A log is sent again with the numbers that its snapshots had. A lost frame or an angle that
    differs from the reference model ends with status 1.

    \b
    Example:
      ccgen bridge firmware --source random --seconds 60
      ccgen bridge shoulder.toml --target cortex-m4
      ccgen bridge firmware --interface socketcan --channel can0
      ccgen bridge firmware --log run.blf
      ccgen bridge firmware --source run.blf --speed max
      ccgen bridge firmware --fault u1=offset:0.002@3 --fault v0=lost@5 --json-lines
    """
    if json and json_lines:
        raise InputError("--json-lines: ends with what --json prints; give one of them")
    if target is not None and (channel is not None or interface != "virtual"):
        raise InputError("--target: the emulated node has its own line; leave out the bus options")
    from ccgen.can import bridge as stage
    from ccgen.cli.bridge_display import display
    from ccgen.cli.bridge_lines import snapshot_lines
    from ccgen.cli.logged import open_log
    from ccgen.sensing.motion import LOADS

    with opened(path) as exported, open_log(log, source) as taken:
        moved = source or ("cases" if exported.joint.loads is None else LOADS)
        stream = _stream(exported, moved, seconds, rate, speed, fault or [])
        where = target or (f"{interface} {channel}" if channel else interface)
        lines = snapshot_lines(exported, taken) if json_lines else nullcontext(taken)
        node = _node(exported, interface, channel, target)
        with node as bus, display(stream, where) as show, lines as passing:
            summary = stage.bridge(bus, exported.codec, stream, where, show, passing)
    if json:
        print_json(summary.record())
    elif json_lines:
        print_json({"summary": summary.record()})
    else:
        _print(summary)
    if summary.gone:
        raise BusError(
            f"{where}: the bus went away, with {summary.answered} of {summary.snapshots} snapshots "
            f"answered ({summary.gone}); connect it again"
        )
    if not summary.passed:
        raise CheckError(_failure(summary))


def _stream(
    exported: "Exported",
    source: str,
    seconds: float | None,
    rate: float | None,
    speed: Speed | None,
    faults: Sequence[str],
) -> "Stream":
    """Prepare a simulated motion, or what a file holds, and what breaks on the way."""
    import numpy as np

    from ccgen.can import bridge as stage
    from ccgen.sensing.injected import read_fault
    from ccgen.sensing.motion import LOADS, SOURCES
    from ccgen.shapes import score_library

    joint, guarded, layout = exported.joint, exported.guarded, exported.layout
    injected = [read_fault(text, joint) for text in faults]
    if source == LOADS and joint.loads is None:
        raise InputError(f"--source: {joint.name} states no loads; state [loads] or give cases")
    if source in (*SOURCES, LOADS):
        if speed is not None:
            raise InputError(f"--speed: is for files; {source} takes --rate")
        rate_hz = rate or 1000.0 / joint.can.cycle_ms
        library = None if source == LOADS else score_library(joint)
        length = 10.0 if seconds is None else seconds
        stream = stage.simulated_stream(joint, guarded, library, source, length, rate_hz)
        times = np.arange(len(stream.counts)) / rate_hz
        return stage.faulty_stream(stream, times, injected, layout)
    if rate is not None:
        raise InputError("--rate: is for motions; a file takes --speed 1 or --speed max")
    if not Path(source).exists():
        raise InputError(
            f"--source: {source} is neither a file nor one of {', '.join((*SOURCES, LOADS))}"
        )
    replay = _replay(exported, Path(source)).until(seconds)
    warn(replay.notes)
    stream = stage.replayed_stream(joint, guarded, source, replay, speed is not Speed.MAX)
    return stage.faulty_stream(stream, replay.times, injected, layout)


def _replay(exported: "Exported", source: Path) -> "Replay":
    from ccgen.can.logs import LOGS
    from ccgen.can.replay import logged_counts, recorded_counts
    from ccgen.recordings.counts import read_counts
    from ccgen.recordings.log_files import is_frame_table, read_frames

    ending = source.suffix.lower()
    if ending in LOGS and (ending != ".csv" or is_frame_table(source)):
        frames = read_frames(source, exported.layout.fd)
        return logged_counts(frames, exported.codec, exported.fingerprint, source)
    times, counts = read_counts(source, exported.joint)
    return recorded_counts(times, counts, exported.layout, source)


@contextmanager
def _node(
    exported: "Exported", interface: str, channel: str | None, target: str | None
) -> Iterator["can.BusABC"]:
    """Run the folder's own node, or open the bus of one that runs elsewhere."""
    from ccgen.can.transports.interface import interface_node
    from ccgen.can.transports.library import library_node
    from ccgen.can.transports.process import process_node
    from ccgen.targets.host import compile_process, compile_shared

    if target is not None:
        from ccgen.targets.emulated import emulated_node

        with emulated_node(exported, target) as bus:
            yield bus
        return
    if channel is not None or interface not in ("virtual", "slcan"):
        bitrate = None if interface == "virtual" else exported.joint.can.bitrate
        with interface_node(exported.layout, interface, channel, bitrate) as bus:
            yield bus
        return
    with tempfile.TemporaryDirectory() as folder:
        if interface == "virtual":
            library = compile_shared(exported.directory, Path(folder))
            with library_node(library, exported.layout) as bus:
                yield bus
        else:
            with process_node(compile_process(exported.directory, Path(folder))) as bus:
                yield bus


_OF = {"u": "range", "v": "range", "h": "length"}
"""What errors of an axis are per cent of."""


def _print(summary: "Summary") -> None:
    from rich.table import Table

    table = Table(title=f"{summary.source} over {summary.transport}", show_header=False)
    table.add_row("snapshots", f"{summary.answered} of {summary.snapshots} answered")
    table.add_row("rate", f"{summary.rate_hz:.1f} a second")
    table.add_row("frames", f"{summary.lost_frames} lost, {summary.corrupted} damaged")
    held = "not compared" if summary.other_zero else f"{summary.mismatches} angles differ"
    table.add_row("reference model", held)
    if summary.left_out_before:
        table.add_row("left out before", ", ".join(summary.left_out_before))
    if summary.injected:
        table.add_row("faults put in", ", ".join(summary.injected))
    table.add_row("degraded", f"{summary.degraded_snapshots} snapshots")
    for title in ("faults", "missing", "suspected"):
        table.add_row(title, ", ".join(getattr(summary, title)) or "none")
    for axis, error in (summary.error_percent_rom or {}).items():
        table.add_row(
            f"error of {axis}", f"{error.mean:.3f} % of {_OF[axis]}, worst {error.worst:.3f}"
        )
    show_table(table)


def _failure(summary: "Summary") -> str:
    if not summary.answered:
        return (
            f"{summary.transport}: no snapshot was answered in full; "
            f"does the joint's node listen there?"
        )
    if summary.stranger:
        return (
            f"{summary.transport}: {summary.stranger}; name the folder that it was compiled from, "
            "or program it again"
        )
    if summary.other_zero:
        return (
            f"{summary.transport}: the node works with a zero that was {summary.other_zero}, which "
            "no frame tells, so that its angles cannot be compared; send it back to the zero of "
            "the model, or start it anew"
        )
    return (
        f"{summary.transport}: {summary.lost_frames} frames lost, "
        f"{summary.mismatches} angles differ from the reference model"
    )
