"""Bounds in print: a few digits that still are bounds."""

from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

_NEARLY_WHOLE = Decimal("1e-12")
"""Relative distance within which a number counts as one of so few digits."""


def at_least(value: float) -> str:
    """Three digits of a positive value, rounded up; 0 for 0."""
    return f"{rounded_up(value):.3g}"


def at_most(value: float) -> str:
    """Three digits of a positive value, rounded down; 0 for 0."""
    return f"{rounded_down(value):.3g}"


def rounded_up(value: float, digits: int = 3) -> float:
    """Least decimal number of so many digits that is not below a positive value; 0 for 0.

    Computed in decimal arithmetic: no logarithm or power of a library decides a digit.
    """
    if value <= 0.0:
        return 0.0
    return _rounded(Decimal(value) * (1 - _NEARLY_WHOLE), digits, ROUND_CEILING)


def rounded_down(value: float, digits: int = 3) -> float:
    """Greatest decimal number of so many digits that is not above a positive value; 0 for 0."""
    if value <= 0.0:
        return 0.0
    return _rounded(Decimal(value) * (1 + _NEARLY_WHOLE), digits, ROUND_FLOOR)


def _rounded(value: Decimal, digits: int, rounding: str) -> float:
    step = Decimal(1).scaleb(value.adjusted() + 1 - digits)
    return float(value.quantize(step, rounding))
