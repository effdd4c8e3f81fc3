"""What the settings of the methods have in common."""

from collections.abc import Callable

from ccgen.errors import ArgumentError

Report = Callable[[int, int], None]
"""Called with how much of a method's work is done, and how much there is."""


def silent(done: int, total: int) -> None:
    """Ignore progress."""


def require_least(least: int, argument: str, value: int) -> None:
    """Refuse a value of an argument that is too small.

    Raises:
        ArgumentError: naming the argument.
    """
    if value < least:
        raise ArgumentError(f"{value} is too small; give at least {least}", argument)
