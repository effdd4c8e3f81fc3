"""Numbers as C writes them."""

from collections.abc import Sequence
from typing import Any

import numpy as np


def rows_context(rows: Sequence[Sequence[int]]) -> list[dict[str, Any]]:
    """Rows of weights, alone and in pairs; an odd number is padded with a weight of 0."""
    return [{"weights": row, "pairs": _pairs(row)} for row in rows]


def _pairs(row: Sequence[int]) -> list[tuple[int, int]]:
    padded = [*row, *[0] * (len(row) % 2)]
    return list(zip(padded[0::2], padded[1::2], strict=True))


def float_literal(value: float) -> str:
    """Shortest C literal of single precision that reads back as the float nearest to `value`."""
    text = str(np.float32(value))
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"
