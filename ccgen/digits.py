"""Bounds in print: three digits that still are bounds."""

import math

_NEARLY_WHOLE = 1e-12
"""Relative distance within which a number counts as one of three digits."""


def at_least(value: float) -> str:
    """Three digits of a positive value, rounded up; 0 for 0."""
    if value <= 0.0:
        return "0"
    step = _step(value)
    return f"{math.ceil(value / step * (1.0 - _NEARLY_WHOLE)) * step:.3g}"


def at_most(value: float) -> str:
    """Three digits of a positive value, rounded down; 0 for 0."""
    if value <= 0.0:
        return "0"
    step = _step(value)
    return f"{math.floor(value / step * (1.0 + _NEARLY_WHOLE)) * step:.3g}"


def _step(value: float) -> float:
    return float(10.0 ** (math.floor(math.log10(value)) - 2))
