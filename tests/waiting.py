"""Waiting for what is bound to happen, however slow or busy the machine is."""

import os
import select
import time
from collections.abc import Callable

PATIENCE = 60.0
"""Seconds after which it will not happen any more; only a test that fails takes so long."""

_TAKEN = 512
"""Bytes that a terminal takes at once where it takes any."""


def becomes(holds: Callable[[], object]) -> bool:
    """Whether something holds, now or before patience ends."""
    deadline = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


def read_until(fd: int, enough: Callable[[bytes], object]) -> bytes:
    """What comes until it is enough; fails with what came where patience ends before."""
    data, deadline = b"", time.monotonic() + PATIENCE
    while not enough(data):
        left = deadline - time.monotonic()
        assert left > 0, f"only {data!r} came"
        if select.select([fd], [], [], left)[0]:
            data += os.read(fd, 1 << 16)
    return data


def write_all(fd: int, data: bytes) -> None:
    """Write where somebody may be slow to read; fails where nobody does."""
    deadline = time.monotonic() + PATIENCE
    while data:
        left = deadline - time.monotonic()
        assert left > 0, f"{len(data)} bytes are not taken"
        if select.select([], [fd], [], left)[1]:
            data = data[os.write(fd, data[:_TAKEN]) :]
