"""Budgets: what a folder may cost."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from typing import TYPE_CHECKING

from ccgen.targets.cores import HOST

if TYPE_CHECKING:
    from ccgen.cost.measure import Cost


@dataclass(frozen=True)
class Budget:
    """Limits in bytes, and instructions of one estimate; None where there is none."""

    flash: int | None = None
    ram: int | None = None
    stack: int | None = None
    instructions: int | None = None

    def __bool__(self) -> bool:
        """Whether there is any limit."""
        return any(limit is not None for limit in astuple(self))

    def held_by(self, target: str, named: bool) -> "Budget":
        """What of the budget holds for a target.

        Args:
            target: its name.
            named: whether the user named the targets. Then all of it holds for each, a limit of
                instructions for AVR's cycles; otherwise only for microcontrollers, and a limit
                of instructions not for cycles.
        """
        if named:
            return self
        if target == HOST:
            return Budget()
        return replace(self, instructions=None) if target == "avr" else self


def excesses(costs: "Sequence[Cost]", budget: Budget, named: bool) -> Iterator[str]:
    """What is over budget: target, what, and by how much; `named` as in `Budget.held_by`."""
    for cost in costs:
        held = budget.held_by(cost.target, named)
        for what, unit, spent, limit in (
            ("flash", "bytes", cost.flash_bytes, held.flash),
            ("RAM", "bytes", cost.ram_bytes, held.ram),
            ("stack", "bytes", cost.stack_bytes, held.stack),
            ("one estimate", cost.times.unit, cost.times.estimate, held.instructions),
        ):
            if limit is not None and spent > limit:
                yield (
                    f"{cost.target}: {what}: {spent} {unit}, {spent - limit} over the budget "
                    f"of {limit}"
                )
