"""The end of a command that runs until it is told to stop."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def asked_to_end() -> Iterator[Callable[[], bool]]:
    """Give what tells whether Ctrl-C or SIGTERM has come in the block; the second one ends it."""
    arrived: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.getsignal(number) for number in numbers}

    def note(number: int, _: object) -> None:
        arrived.append(number)
        signal.signal(number, before[signal.Signals(number)] or signal.SIG_DFL)

    for number in numbers:
        signal.signal(number, note)
    try:
        yield lambda: bool(arrived)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler or signal.SIG_DFL)
