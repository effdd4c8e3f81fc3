"""How much the frames of a joint hold, and how many it takes; `ccgen.can.layout` has the form."""

SINGLE_FRAMES = 4
"""Tip, status, health and command, of which a joint has one each."""


def frame_bytes(fd: bool) -> int:
    """Length of every frame, of CAN FD or of classic CAN."""
    return 64 if fd else 8


def header_bytes(fd: bool) -> int:
    """Bytes of the end-to-end header: 2 for P01, 3 for P05."""
    return 3 if fd else 2


def values_per_frame(fd: bool, size: int) -> int:
    """How many values of so many bytes fit a frame."""
    return (frame_bytes(fd) - header_bytes(fd)) // size


def frames_for(values: int, fd: bool, size: int) -> int:
    """How many frames hold so many values of so many bytes."""
    return -(-values // values_per_frame(fd, size))
