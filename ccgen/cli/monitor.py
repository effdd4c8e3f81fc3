"""`ccgen monitor`: what passes on a joint's bus, live or from a log."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Speed
from ccgen.cli.ending import asked_to_end
from ccgen.cli.folders import opened
from ccgen.cli.logged import open_log
from ccgen.cli.output import note, print_json
from ccgen.cli.terminal import nobody_listens
from ccgen.cli.viewing import (
    NoBrowser,
    View,
    ViewPort,
    check_view,
    stay,
    viewed,
    wait_for_somebody,
)
from ccgen.errors import BusError, CheckError, InputError

if TYPE_CHECKING:
    import can

    from ccgen.can.monitor import Monitor
    from ccgen.can.outlets import Outlet
    from ccgen.can.seen import Seen
    from ccgen.targets.exported import Exported
    from ccgen.view.page import Page

_GLANCE = 0.05
"""Seconds after which a silent bus is left for a moment, to look at the clock and at signals."""

_FLUSH_SECONDS = 0.1

_TRUTH = "what the reference model makes of the lengths"

Frames = Iterator["can.Message | None"]
"""Frames in order of time; None now and then while none comes."""


def monitor(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="DIR|JOINT",
            help="A folder that `ccgen export` wrote, or a joint's file to export for this once.",
        ),
    ],
    interface: Annotated[
        str | None, typer.Option("--interface", help="python-can's name of the bus to listen to.")
    ] = None,
    channel: Annotated[
        str | None, typer.Option("--channel", help="python-can's channel, such as can0.")
    ] = None,
    source: Annotated[
        Path | None,
        typer.Option(
            "--source",
            metavar="FILE",
            help="Read a log (.log, .asc, .blf, .csv) instead of a bus.",
        ),
    ] = None,
    speed: Annotated[
        Speed | None,
        typer.Option(
            "--speed",
            help="Read a log at its own times, or as fast as it goes.  "
            "[default: max; with --view 1]",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option("--seconds", min=0.0, help="How long to listen.  [default: until Ctrl-C]"),
    ] = None,
    window_ms: Annotated[
        float | None,
        typer.Option(
            "--window-ms",
            min=0.001,
            help="Time in which a snapshot's frames must come, as the node has it.  "
            "[default: one cycle]",
        ),
    ] = None,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log", metavar="FILE", help="Log every frame: .log (candump), .asc, .blf or .csv."
        ),
    ] = None,
    udp: Annotated[
        str | None,
        typer.Option(
            "--udp",
            metavar="HOST:PORT",
            help="Send each snapshot as JSON, for PlotJuggler; without HOST to this machine.",
        ),
    ] = None,
    mcap: Annotated[
        Path | None,
        typer.Option(
            "--mcap",
            metavar="FILE",
            help="Write snapshots as MCAP, for Foxglove and PlotJuggler; needs ccgen[view].",
        ),
    ] = None,
    view: View = False,
    view_port: ViewPort = None,
    no_browser: NoBrowser = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object a snapshot, and a last summary.")
    ] = False,
) -> None:
    """Listen to a joint's bus, sending nothing: angles, tip, faults, and the state of every frame.

    Where lengths are on the bus too, angles are held against the reference model; one that differs
    ends with status 1. Ctrl-C ends the watch with its summary.

    --view shows the joint in a browser: estimate, sensors coloured by their reading, and where
    lengths are on the bus what the reference model makes of them. A log begins when the page is
    open, and ends when it is closed.

    \b
    Example:
      ccgen monitor firmware --interface socketcan --channel can0
      ccgen monitor firmware --interface slcan --channel /dev/ttyACM0 --log run.blf
      ccgen monitor firmware --source run.blf --json
      ccgen monitor firmware --source run.blf --mcap run.mcap
      ccgen monitor firmware --source run.blf --view
    """
    if (interface is None) == (source is None):
        raise InputError(
            "--interface: name the bus to listen to, such as --interface socketcan --channel can0, "
            "or a log with --source; one of them"
        )
    if speed is not None and source is None:
        raise InputError("--speed: is for logs; a bus has its own")
    check_view(view, view_port, no_browser)
    from ccgen.can.monitor import Monitor
    from ccgen.cli.monitor_display import display, show_summary

    where = str(source) if source else f"{interface} {channel or ''}".strip()
    window = None if window_ms is None else 1e-3 * window_ms
    with ExitStack() as stack:
        exported = stack.enter_context(opened(path))
        watch = Monitor(exported.guarded, exported.codec, exported.fingerprint, window)
        taken = stack.enter_context(open_log(log, None if source is None else str(source)))
        outlets = [*_outlets(stack, exported, udp, mcap), *([print_json] if json else [])]
        ended = stack.enter_context(asked_to_end())
        in_time = speed is Speed.LIKE or (view and speed is None)
        frames = stack.enter_context(
            _frames(exported, interface, channel, source, in_time, seconds, ended)
        )
        if view:
            page = stack.enter_context(viewed(exported.joint, _TRUTH, view_port, no_browser))
            outlets.append(_page_outlet(page, exported, watch))
            frames = _shown(frames, page, ended, whole=source is not None)
        show = stack.enter_context(display(watch, exported, where, hidden=json))
        _follow(watch, frames, exported, outlets, taken, show, where)
    if source is not None and not watch.heard:
        name = exported.joint.name
        raise InputError(f"{where}: holds no frame of {name}; name a log of this joint")
    if json:
        print_json({"summary": watch.summary()})
    else:
        show_summary(watch, where)
    _judge(watch, exported.joint.name, where)


def _follow(
    watch: "Monitor",
    frames: Frames,
    exported: "Exported",
    outlets: "list[Outlet]",
    log: "Callable[[can.Message], None] | None",
    show: Callable[[], None],
    where: str,
) -> None:
    """Take all frames and pass on the snapshots that they make."""
    from ccgen.can.seen import plain

    def pass_on(seen: "Seen") -> None:
        record = plain(seen, exported.model, exported.layout)
        for outlet in outlets:
            outlet(record)

    flushed = time.monotonic()
    try:
        for message in frames:
            if message is not None:
                if log is not None:
                    log(message)
                for seen in watch.take(message):
                    pass_on(seen)
            now = time.monotonic()
            if message is None or now - flushed > _FLUSH_SECONDS:
                flushed = now
                sys.stdout.flush()
                if nobody_listens():
                    return
                show()
    except InputError as error:
        said = str(error)
        raise InputError(said if said.startswith(where) else f"{where}: {said}") from error
    for seen in watch.finish():
        pass_on(seen)


def _outlets(
    stack: ExitStack, exported: "Exported", udp: str | None, mcap: Path | None
) -> "Iterator[Outlet]":
    """Open what snapshots go to beside the screen."""
    if mcap is not None:
        from ccgen.can.mcap_file import mcap_outlet

        axes = tuple(exported.model.axes)
        yield stack.enter_context(mcap_outlet(mcap, exported.layout, axes))
    if udp is not None:
        from ccgen.can.outlets import udp_outlet

        yield stack.enter_context(udp_outlet(udp))


def _page_outlet(page: "Page", exported: "Exported", watch: "Monitor") -> "Outlet":
    """Draw a snapshot wherever the page is due for one."""
    from ccgen.view.on_bus import BusSights

    sights = BusSights(exported.joint, exported.guarded)

    def draw(record: dict[str, Any]) -> None:
        if page.due:
            page.show(sights.sight(record, watch.zero_is_the_models))

    return draw


def _shown(frames: Frames, page: "Page", ended: Callable[[], bool], whole: bool) -> Frames:
    """Frames for somebody who looks: all of a log from when the page is open until it is closed."""
    if whole:
        wait_for_somebody(page, ended)
    told = False
    for message in frames:
        if page.closed and not told:
            told = True
            note(f"the page was closed; the watch goes on, {page.url} shows it again")
        yield message
    if whole:
        yield from stay(page, ended)


@contextmanager
def _frames(
    exported: "Exported",
    interface: str | None,
    channel: str | None,
    source: Path | None,
    in_time: bool,
    seconds: float | None,
    ended: Callable[[], bool],
) -> Iterator[Frames]:
    if source is not None:
        from ccgen.recordings.log_files import read_frames

        yield _logged(read_frames(source, exported.layout.fd), in_time, seconds, ended)
        return
    from ccgen.can.transports.interface import interface_node

    assert interface is not None
    bitrate = None if interface == "virtual" else exported.joint.can.bitrate
    bus = interface_node(exported.layout, interface, channel, bitrate, listen_only=True)
    with bus as opened_bus:
        yield _heard(opened_bus, f"{interface} {channel or ''}".strip(), seconds, ended)


def _heard(
    bus: "can.BusABC", where: str, seconds: float | None, ended: Callable[[], bool]
) -> Frames:
    import can

    from ccgen.can.transports import gone_because

    end = None if seconds is None else time.monotonic() + seconds
    while not ended() and (end is None or time.monotonic() < end):
        try:
            message = bus.recv(_GLANCE)
        except (can.CanError, OSError) as error:
            raise BusError(
                f"{where}: the bus went away ({gone_because(error)}); connect it again"
            ) from error
        if message is not None and not message.timestamp:
            message.timestamp = time.time()
        yield message


def _logged(
    frames: "Iterator[can.Message]",
    in_time: bool,
    seconds: float | None,
    ended: Callable[[], bool],
) -> Frames:
    begin, first = time.monotonic(), None
    for message in frames:
        first = message.timestamp if first is None else first
        if ended() or (seconds is not None and message.timestamp - first > seconds):
            return
        while in_time and not ended():
            left = begin + message.timestamp - first - time.monotonic()
            if left <= 0:
                break
            yield None
            time.sleep(min(left, _GLANCE))
        yield message


def _judge(watch: "Monitor", joint: str, where: str) -> None:
    """End with the status that the watch deserves."""
    if not watch.heard:
        raise CheckError(f"{where}: no frame of {joint} was heard; is it on this bus?")
    if watch.mismatches:
        raise CheckError(
            f"{where}: {watch.mismatches} values of {watch.compared} snapshots differ from the "
            "reference model"
        )
