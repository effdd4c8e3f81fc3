"""What the settings of the methods have in common."""

from collections.abc import Callable

Report = Callable[[int, int], None]
"""Called with how much of a method's work is done, and how much there is."""


def silent(done: int, total: int) -> None:
    """Ignore progress."""
