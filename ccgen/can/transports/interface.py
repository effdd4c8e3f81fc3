"""A node on any bus that python-can knows: a user's board, a vcan, an emulated target."""

import logging
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import can

from ccgen.can.layout import FrameLayout
from ccgen.can.transports.slcan import BlockSlcanBus
from ccgen.errors import ArgumentError

_CHANNELS = {"slcan": "a serial device", "socketcan": "a network interface, such as can0,"}
"""The interfaces with a bus class of our own, and what their channel is."""


@contextmanager
def interface_node(
    layout: FrameLayout,
    interface: str,
    channel: str | None = None,
    bitrate: int | None = None,
    listen_only: bool = False,
) -> Iterator[can.BusABC]:
    """Open the bus that a running node is on.

    SLCAN devices are read in blocks, SocketCAN waits for room in its queue, everything else is
    python-can's own. Frames far from the joint's identifiers are filtered out.

    Args:
        layout: of the joint.
        interface: a name that python-can knows, such as "socketcan" or "slcan".
        channel: the interface's name for the bus, such as "can0" or "/dev/ttyACM0".
        bitrate: bits per second; None leaves the interface as it is set up, as SocketCAN always is.
        listen_only: whether an adapter that can is told to send nothing, no acknowledgement either.

    Raises:
        ArgumentError: python-can does not know the interface or cannot open it.
    """
    with _drivers_words() as said:
        try:
            bus = _open(layout, interface, channel, bitrate, listen_only)
        except Exception as error:  # whatever a driver's binding raises where the driver is missing
            where = f"{interface} {channel or ''}".strip()
            reason = _reason(error, said)
            raise ArgumentError(f"{where} cannot be opened: {reason}", "interface") from error
    with bus:
        bus.set_filters([_neighbourhood(layout)])
        yield bus


@contextmanager
def _drivers_words() -> Iterator[list[str]]:
    """Gather what drivers' bindings say on python-can's log, to tell it in our line."""
    said: list[str] = []

    class Gather(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            said.append(record.getMessage())

    log, handler = logging.getLogger("can"), Gather(logging.WARNING)
    log.addHandler(handler)
    try:
        yield said
    finally:
        log.removeHandler(handler)


def _reason(error: Exception, said: list[str]) -> str:
    """Why a bus cannot be opened, on one line."""
    text = " ".join(str(error).split())
    missing = re.search(r"missing \d+ required positional arguments?: (.+)", text)
    if isinstance(error, TypeError) and missing:
        options = re.findall(r"'(\w+)'", missing[1])
        if options == ["channel"]:
            return "it needs a channel"
        return f"it needs {', '.join(options)}; write them into python-can's configuration file"
    if isinstance(error, can.CanError | OSError | ValueError | TypeError | ImportError):
        return text
    known = said[0] if said else "its driver does not work here"
    return f"{' '.join(known.split()).rstrip('.')} ({type(error).__name__}: {text})"


def _open(
    layout: FrameLayout,
    interface: str,
    channel: str | None,
    bitrate: int | None,
    listen_only: bool,
) -> can.BusABC:
    options: dict[str, Any] = {} if bitrate is None else {"bitrate": bitrate}
    if interface == "slcan" and bitrate not in (None, *BlockSlcanBus.bitrates()):
        raise ValueError(
            f"SLCAN has no {bitrate} bit/s, the can.bitrate of joint.toml; write one of "
            f"{', '.join(map(str, BlockSlcanBus.bitrates()))} there"
        )
    if interface not in _CHANNELS or (interface == "slcan" and os.name == "nt"):
        if layout.fd:
            options["fd"] = True
        return can.Bus(interface=interface, channel=channel, **options)
    if channel is None:
        raise ValueError(f"name {_CHANNELS[interface]} as channel")
    if interface == "slcan":
        return BlockSlcanBus(channel, listen_only=listen_only, **options)
    # Imported here: it exists on Linux alone.
    from ccgen.can.transports.socketcan import PatientSocketcanBus

    return PatientSocketcanBus(channel, layout.fd)


def _neighbourhood(layout: FrameLayout) -> can.typechecking.CanFilter:
    """The smallest aligned block of identifiers around the joint's."""
    identifier_bits = 29 if layout.extended else 11
    differing = (layout.base_id ^ layout.last_id).bit_length()
    mask = (1 << identifier_bits) - (1 << differing)
    return {"can_id": layout.base_id & mask, "can_mask": mask, "extended": layout.extended}
