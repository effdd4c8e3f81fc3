"""What an exported folder costs: flash, RAM, stack, instructions.

The room itself can be called: `ccgen.cost(DIR, target="cortex-m4")`.
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ccgen.cost.costs import Costs


class _Cost(ModuleType):
    def __call__(
        self,
        directory: str | Path,
        target: str | Sequence[str] | None = None,
        optimise: str = "2",
        write: bool = False,
        report: Callable[[str, int, int], None] | None = None,
    ) -> "Costs":
        """As `ccgen.cost.costs.cost`."""
        from ccgen.cost.costs import cost

        return cost(directory, target, optimise, write, report)


sys.modules[__name__].__class__ = _Cost
