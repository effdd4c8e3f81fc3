"""How far something is that takes long."""

from collections.abc import Callable

Report = Callable[[str, int, int], None]
"""Told what is being done, how many steps of it are done, and how many there are."""


def in_silence(what: str, done: int, total: int) -> None:
    """Tell nobody of progress."""
