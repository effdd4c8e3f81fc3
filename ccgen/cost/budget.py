"""Budgets: what a folder may cost."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ccgen.cost.measure import Cost


@dataclass(frozen=True)
class Budget:
    """Limits in bytes, and instructions of one estimate; None where there is none."""

    flash: int | None = None
    ram: int | None = None
    stack: int | None = None
    instructions: int | None = None


def excesses(costs: Sequence[Cost], budget: Budget) -> Iterator[str]:
    """What is over budget: target, what, and by how much.

    A limit of instructions is one of cycles where cycles are counted.
    """
    for cost in costs:
        for what, unit, spent, limit in (
            ("flash", "bytes", cost.flash_bytes, budget.flash),
            ("RAM", "bytes", cost.ram_bytes, budget.ram),
            ("stack", "bytes", cost.stack_bytes, budget.stack),
            ("one estimate", cost.times.unit, cost.times.estimate, budget.instructions),
        ):
            if limit is not None and spent > limit:
                yield (
                    f"{cost.target}: {what}: {spent} {unit}, {spent - limit} over the budget "
                    f"of {limit}"
                )
