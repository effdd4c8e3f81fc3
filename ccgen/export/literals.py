"""Numbers as C writes them."""

import numpy as np


def float_literal(value: float) -> str:
    """Shortest C literal of single precision that reads back as the float nearest to `value`."""
    text = str(np.float32(value))
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"
