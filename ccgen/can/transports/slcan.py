"""SLCAN in blocks: python-can's bus with as many bytes a system call as there are.

python-can's own bus reads byte by byte and drains the line after every frame; at 6,000 frames a
second that costs a processor core. It also lets a malformed line end the program.
"""

import os
import select
import time
from collections import deque
from collections.abc import Sequence
from typing import Any

import can
from can.exceptions import error_check
from can.interfaces.slcan import slcanBus

_BLOCK = 1 << 16
_ACKNOWLEDGEMENTS = (b"z", b"Z", b"")
_REFUSAL = b"\a"
_LINE_FEED = b"\n"
_PARTING = 0.2
"""Seconds that the other end has to take the command to close."""


class BlockSlcanBus(slcanBus):
    """An SLCAN bus over a serial device, a pseudo-terminal or `socket://HOST:PORT` (POSIX).

    Attributes:
        malformed_lines: lines from the other end that were no frame and no answer.
        refused_lines: lines of ours that the other end refused.
    """

    def __init__(self, channel: str, sleep_after_open: float = 0.0, **kwargs: Any) -> None:
        """Open the device; arguments as those of python-can's `slcanBus`.

        Raises:
            can.CanInitializationError: the device cannot be opened.
        """
        self.malformed_lines = 0
        self.refused_lines = 0
        self._lines: deque[str] = deque()
        self._rest = b""
        self._outgoing = bytearray()
        self._holding = False
        super().__init__(channel, sleep_after_open=sleep_after_open, **kwargs)

    @classmethod
    def bitrates(cls) -> list[int]:
        """Bit rates that SLCAN has a command for, bits per second."""
        return sorted(cls._BITRATES)

    def set_bitrate(self, bitrate: int, data_bitrate: int | None = None) -> None:
        """Set the bit rate; without one for data, python-can 4.6.0 wants a 0.

        Raises:
            ValueError: SLCAN has no command for it.
        """
        super().set_bitrate(bitrate, data_bitrate or 0)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame.

        Raises:
            can.CanOperationError: the other end is gone, or did not take it in time.
        """
        try:
            super().send(msg, timeout)
        except OSError as error:  # python-can lets it pass where a new time-out is set
            raise can.CanOperationError("Could not write to serial device") from error

    def send_all(self, messages: Sequence[can.Message], timeout: float | None = None) -> None:
        """Send several frames with one write, so that they arrive together.

        Raises:
            can.CanOperationError: the other end is gone, or did not take them in time.
        """
        self._holding = True
        try:
            for message in messages:
                self.send(message, timeout)
        finally:
            self._holding = False
        self._flush_outgoing()

    def shutdown(self) -> None:
        """Close the other end's channel, if it still listens, and the device."""
        try:
            self.serialPortOrig.write_timeout = _PARTING
            super().shutdown()
        except (can.CanOperationError, OSError):
            self.serialPortOrig.close()

    def _write(self, string: str) -> None:
        self._outgoing += string.encode() + self.LINE_TERMINATOR
        if not self._holding:
            self._flush_outgoing()

    def _flush_outgoing(self) -> None:
        data, self._outgoing = self._outgoing, bytearray()
        with error_check("Could not write to serial device"):
            self.serialPortOrig.write(data)

    def _read(self, timeout: float | None) -> str | None:
        deadline = None if timeout is None else time.monotonic() + timeout
        while not self._lines:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            with error_check("Could not read from serial device"):
                if not select.select([self.fileno()], [], [], left)[0]:
                    return None
                data = os.read(self.fileno(), _BLOCK)
            if not data:
                raise can.CanOperationError("the other end has closed the line")
            self._take(data)
        return self._lines.popleft()

    def _take(self, data: bytes) -> None:
        if _REFUSAL in data:
            self.refused_lines += data.count(_REFUSAL)
            data = data.replace(_REFUSAL, self.LINE_TERMINATOR)
        # Lines end in CR or CR LF; what a line feed leaves is an empty line.
        data = data.replace(_LINE_FEED, self.LINE_TERMINATOR)
        *lines, self._rest = (self._rest + data).split(self.LINE_TERMINATOR)
        self._lines.extend(
            line.decode("latin-1") + "\r" for line in lines if line not in _ACKNOWLEDGEMENTS
        )

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            return super()._recv_internal(timeout)
        except (ValueError, IndexError):
            self.malformed_lines += 1
            return None, False
