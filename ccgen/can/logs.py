"""Logs of the bus as they come: candump's text, ASC, BLF or CSV, through python-can's writers."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import can

from ccgen.errors import ArgumentError

LOGS = (".log", ".asc", ".blf", ".csv")
"""Endings of files that frames are written to: candump, Vector's text and binary, python-can."""

Log = Callable[[can.Message], None]
"""Takes a frame down, after those before it."""


def check_log_name(path: Path) -> None:
    """Refuse a name whose ending no writer knows.

    Raises:
        ArgumentError: naming the endings.
    """
    if path.suffix.lower() not in LOGS:
        raise ArgumentError(
            f"{path}: no log ends so; end it in .log (candump), .asc, .blf or .csv", "log"
        )


@contextmanager
def frame_log(path: Path) -> Iterator[Log]:
    """Open a log, replacing an older one; it is closed properly however the block ends.

    Frames have a time, which never runs back.

    Raises:
        ArgumentError: as of `check_log_name`.
        OSError: the file cannot be written; it names the file.
    """
    check_log_name(path)
    with _named(path):
        writer = can.Logger(path)
    try:
        yield _Taken(writer, path).take
    finally:
        with _named(path):
            writer.stop()


def stamped(message: can.Message) -> can.Message:
    """The frame, with the machine's time."""
    message.timestamp = time.time()
    return message


class _Taken:
    def __init__(self, writer: Any, path: Path) -> None:
        self._writer, self._path = writer, path
        self._latest = 0.0

    def take(self, message: can.Message) -> None:
        self._latest = max(self._latest, message.timestamp)
        message.timestamp = self._latest
        message.channel = None  # there is one; a device's path would break candump's lines
        with _named(self._path):
            self._writer.on_message_received(message)


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Say which file the system did not write."""
    try:
        yield
    except OSError as error:
        code = error.errno or 0
        raise OSError(code, error.strerror or os.strerror(code), str(path)) from error
