"""Frames from logs of the bus: BLF, ASC, candump's text or python-can's CSV, read by python-can.

A reader of four formats skips what it does not understand. A file that was cut off is told apart
here: BLF states its size, and text ends with the end of a line.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.errors import InputError

if TYPE_CHECKING:
    import can

FRAME_TABLE = b"timestamp,arbitration_id,"
"""What the header of python-can's CSV begins with."""

_BLF = (b"LOGG", ".blf")
_BLF_SIZE = struct.Struct("<16xQ")
"""Behind signature, header's size and versions: how long the file was when it was closed."""

_CLASSIC_BYTES = 8


def is_frame_table(path: Path) -> bool:
    """Return whether a file is a CSV of frames, as python-can writes it, and no recording."""
    try:
        with path.open("rb") as file:
            return file.read(len(FRAME_TABLE)) == FRAME_TABLE
    except OSError:
        return False


def read_frames(path: Path, fd: bool = False) -> "Iterator[can.Message]":
    """Give the frames of a log one by one, as they lie in it.

    Args:
        path: the log.
        fd: whether short frames are of CAN FD where the log does not say, as python-can's CSV.

    Raises:
        InputError: it is missing, of a kind that python-can does not know, damaged or cut off;
            the last two when reading has come so far.
    """
    import can

    _check_there(path)
    try:
        with can.LogReader(path) as log:
            for message in log:
                if path.suffix.lower() == ".csv":
                    message.is_fd = fd or len(message.data) > _CLASSIC_BYTES
                yield message
    except Exception as error:  # readers of four formats raise whatever a damaged file leads to
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"{path}: cannot be read as a CAN log ({reason}); record it again"
        ) from None
    if _cut_off(path):
        raise InputError(f"{path}: the log is cut off; copy it again, whole, or record it again")


def _check_there(path: Path) -> None:
    try:
        with path.open("rb"):
            return
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; name a log of the bus") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a directory; name a file in it") from None


def _cut_off(path: Path) -> bool:
    signature, suffix = _BLF
    with path.open("rb") as file:
        head = file.read(_BLF_SIZE.size)
        size = file.seek(0, 2)
        if head.startswith(signature):
            stated: int = _BLF_SIZE.unpack_from(head)[0]
            return size < stated
        if path.suffix.lower() == suffix or not size:
            return False
        file.seek(-1, 2)
        return file.read(1) != b"\n"
