"""Where snapshots go beside the screen: datagrams of JSON, one a snapshot, as PlotJuggler reads."""

import json
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ccgen.errors import ArgumentError

Outlet = Callable[[dict[str, Any]], None]
"""Takes a snapshot's plain values."""

LOOPBACK = "127.0.0.1"


def udp_address(text: str) -> tuple[str, int]:
    """Read "HOST:PORT", ":PORT" or "PORT"; without a host this machine alone hears it.

    Raises:
        ArgumentError: another form.
    """
    host, _, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (port.isascii() and port.isdigit()) or not 0 < int(port) < 2**16:
        raise ArgumentError(f"{text} is no HOST:PORT, such as {LOOPBACK}:9870", "udp")
    return host or LOOPBACK, int(port)


@contextmanager
def udp_outlet(text: str) -> Iterator[Outlet]:
    """Send each snapshot as one datagram; what nobody receives is lost.

    Raises:
        ArgumentError: no address, or a host that is not known.
    """
    host, port = udp_address(text)
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[
            0
        ]
        outlet = socket.socket(family, kind, protocol)
    except (OSError, UnicodeError) as error:
        reason = str(getattr(error, "strerror", None) or error).lower()
        raise ArgumentError(f"{text} is not known ({reason})", "udp") from error
    with outlet:

        def send(record: dict[str, Any]) -> None:
            data = json.dumps(record, allow_nan=False, separators=(",", ":")).encode("ascii")
            try:
                outlet.sendto(data, address)
            except ConnectionRefusedError:
                return  # the one before was not received; nobody has to listen
            except OSError as error:
                reason = (error.strerror or str(error)).lower()
                raise ArgumentError(f"{text} cannot be sent to ({reason})", "udp") from error

        yield send
