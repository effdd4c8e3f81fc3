"""How much the frames of a joint hold, and how many it takes; `ccgen.can.layout` has the form."""

SINGLE_FRAMES = 4
"""Tip, status, health and command, of which a joint has one each."""


FD_LENGTHS = (12, 16, 20, 24, 32, 48, 64)
"""Lengths of CAN FD frames that are used."""


def frame_bytes(fd: bool) -> int:
    """Longest frame, of CAN FD or of classic CAN."""
    return FD_LENGTHS[-1] if fd else 8


def frame_length(fd: bool, payload_bytes: int) -> int:
    """Length of a frame with so many bytes behind its header: 8, on CAN FD the shortest."""
    needed = header_bytes(fd) + payload_bytes
    return next(length for length in FD_LENGTHS if length >= needed) if fd else frame_bytes(fd)


def header_bytes(fd: bool) -> int:
    """Bytes of the end-to-end header: 2 for P01, 3 for P05."""
    return 3 if fd else 2


def values_per_frame(fd: bool, size: int) -> int:
    """How many values of so many bytes fit a frame."""
    return (frame_bytes(fd) - header_bytes(fd)) // size


def frames_for(values: int, fd: bool, size: int) -> int:
    """How many frames hold so many values of so many bytes."""
    return -(-values // values_per_frame(fd, size))
