"""What the settings of the methods have in common."""

from collections.abc import Callable

from ccgen.errors import InputError

Report = Callable[[int, int], None]
"""Called with how much of a method's work is done, and how much there is."""


def silent(done: int, total: int) -> None:
    """Ignore progress."""


def at_least(least: int, option: str, value: int) -> None:
    """Refuse a value of an option that is too small.

    Raises:
        InputError: naming the option.
    """
    if value < least:
        raise InputError(f"--{option}: {value} is too small; give at least {least}")
