"""How much a verification sends, and how it says how far it is."""

import math
from collections.abc import Callable
from dataclasses import dataclass

LEAST_SNAPSHOTS = 20_000
LEAST_VALUES = 1_000_000

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


@dataclass(frozen=True)
class Plan:
    """Extent of a verification.

    Attributes:
        snapshots: over each bus; None for as many as give a million angles, 20,000 at least.
        values: angles compared in batches, besides.
        seed: of the random counts.
    """

    snapshots: int | None = None
    values: int = LEAST_VALUES
    seed: int = 0

    def bus_snapshots(self, values: int) -> int:
        """Snapshots over each bus, each of which yields so many values."""
        if self.snapshots is not None:
            return self.snapshots
        return max(LEAST_SNAPSHOTS, math.ceil(LEAST_VALUES / values))

    def batch_snapshots(self, values: int) -> int:
        """Snapshots in batches, each of which yields so many values."""
        return math.ceil(self.values / values)


def silent(what: str, done: int, total: int) -> None:
    """Ignore progress."""
