"""SocketCAN without losses of our own: python-can's bus with deeper queues and more patience.

Real interfaces queue ten frames for sending unless told otherwise. python-can gives up a frame that
finds the queue full, whatever time it was given, because the socket reports itself writable. And a
socket's default buffer holds some 280 received frames, fewer than four answers of a large joint.
"""

import errno
import fcntl
import socket
import struct
import time

import can
from can.interfaces.socketcan import SocketcanBus

_POLL = 5e-4
"""Seconds between two looks at a full queue: that of a few frames on a bus."""

_RECEIVE_BYTES = 1 << 23
"""Wanted buffer of received frames; the kernel gives at most twice its `net.core.rmem_max`."""

_SIOCGIFFLAGS = 0x8913
_SIOCGIFMTU = 0x8921
_IFF_UP = 1
_CANFD_MTU = 72


class PatientSocketcanBus(SocketcanBus):
    """A SocketCAN interface, real or virtual, that can carry the frames it is opened for.

    The kernel's error frames are left out: their identifiers are those of faults, not of senders.
    """

    def __init__(self, channel: str, fd: bool) -> None:
        """Open the interface.

        Args:
            channel: name of the network interface.
            fd: whether CAN FD frames are to be sent.

        Raises:
            OSError: it cannot be opened.
            ValueError: it is down, or takes no CAN FD frames.
        """
        super().__init__(channel, fd=fd, ignore_rx_error_frames=True)
        try:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BYTES)
            _require_usable(self.socket, channel, fd)
        except (OSError, ValueError):
            self.shutdown()
            raise

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame, waiting up to `timeout` seconds for room in the queue.

        Raises:
            can.CanOperationError: there was none in time, or the interface failed.
        """
        deadline = time.monotonic() + (timeout or 0.0)
        while True:
            try:
                super().send(msg, timeout)
            except can.CanOperationError as error:
                if error.error_code != errno.ENOBUFS or time.monotonic() >= deadline:
                    raise
                time.sleep(_POLL)
            else:
                return


def _require_usable(any_socket: socket.socket, channel: str, fd: bool) -> None:
    """Raise ValueError, with the remedy, for an interface that would swallow what is sent."""
    if not _ask(any_socket, _SIOCGIFFLAGS, channel, "=h") & _IFF_UP:
        raise ValueError(f"it is down; `ip link set {channel} up`")
    if fd and _ask(any_socket, _SIOCGIFMTU, channel, "=i") < _CANFD_MTU:
        raise ValueError(
            f"it takes no CAN FD frames; set it down, then `ip link set {channel} mtu 72 up` if it "
            f"is virtual, `ip link set {channel} up type can ... fd on` if not"
        )


def _ask(any_socket: socket.socket, request: int, channel: str, kind: str) -> int:
    """Ask the kernel for a number about a network interface; `struct ifreq` in netdevice(7)."""
    answer = fcntl.ioctl(any_socket, request, struct.pack("16s24x", channel.encode()))
    number: int = struct.unpack_from(kind, answer, 16)[0]
    return number
