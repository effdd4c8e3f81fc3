"""Compiles a CasADi function into a plan of integer operations with a proven error."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ccgen.digits import at_least
from ccgen.errors import FormatError
from ccgen.polynomial.cheapening import cheapened
from ccgen.polynomial.enclosures import PIECES, pieces
from ccgen.polynomial.graph import read_graph
from ccgen.polynomial.intervals import hull
from ccgen.polynomial.model import evaluate
from ccgen.polynomial.plan import Plan
from ccgen.polynomial.planner import Draft, Task
from ccgen.polynomial.proof import Proof, prove
from ccgen.polynomial.specification import Input, Output, check_outputs, input_variables

_SPARE = range(1, 36)
"""Bits beyond those that would make each rounding alone as large as the wanted error."""

_PATIENCE = 4
"""Plans in a row that are hardly better until more bits are given up,"""
_CLEARLY = 0.9
"""and what a clearly better one has of the error."""


@dataclass(frozen=True, eq=False)
class Compiled:
    """A polynomial in integers.

    Attributes:
        name: of the function.
        plan: its operations.
        proof: what is proven of them.
    """

    name: str
    plan: Plan
    proof: Proof

    @property
    def bounds(self) -> dict[str, list[Fraction]]:
        """Of every output element the proven largest distance to the exact polynomial."""
        found: dict[str, list[Fraction]] = {}
        for (variable, _), bound in zip(self.plan.outputs, self.proof.bounds(), strict=True):
            found.setdefault(variable.name, []).append(bound)
        return found

    @property
    def formats(self) -> dict[str, int]:
        """Fraction bits of every output."""
        return {variable.name: variable.fraction_bits for variable, _ in self.plan.outputs}

    def evaluate(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The integer reference model: `ccgen.polynomial.model.evaluate`."""
        return evaluate(self.plan, self.proof.integers, values)


def compile_function(
    function: Any, inputs: Mapping[str, Input], outputs: Mapping[str, Output]
) -> Compiled:
    """Compile a polynomial `casadi.Function` to integer arithmetic of 32 bits.

    Args:
        function: sums, products, constants, negation, squares and divisions by constants.
        inputs: by name; every one needs its range and Q format.
        outputs: by name; every one needs the largest error that is wanted.

    Raises:
        ArgumentError: the function is no polynomial, or an input has no range.
        FormatError: no plan meets a wanted error; says the best one.
    """
    variables = input_variables(function, inputs)
    check_outputs(function, outputs)
    graph = read_graph(function)
    best: Draft | None = None
    least = math.inf
    for most in (1, PIECES):  # most functions need no more than one, which is much quicker
        task, worse = Task.of(graph, variables, outputs, most), 0
        for spare in _SPARE:
            found = task.planned(spare)
            if found and found.excess(outputs) <= 1:
                plan = cheapened(task, spare, found).plan
                return Compiled(function.name(), plan, prove(plan))
            excess = float(found.excess(outputs)) if found else math.inf
            worse = 0 if excess < _CLEARLY * least else worse + 1
            if excess < least:
                best, least = found, excess
            if worse > _PATIENCE:
                break
    closest = Compiled(function.name(), best.plan, best.proof) if best else None
    raise FormatError(_refusal(function.name(), outputs, closest))


def _refusal(name: str, outputs: Mapping[str, Output], best: Compiled | None) -> str:
    if best is None:
        return f"{name}: no plan of 32 bits holds its values; use narrower ranges or wider outputs"
    said = ", ".join(
        f"{at_least(float(bound))} of {output}"
        for output, bound in ((one, max(row)) for one, row in best.bounds.items())
        if bound > Fraction(outputs[output].error)
    )
    return (
        f"{name}: no plan of 32 bits meets the error; the best is proven to {said}: ask for no "
        "less, or use narrower ranges or wider outputs"
    )


def output_ranges(function: Any, inputs: Mapping[str, Input]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value that intervals give each output, over all of its elements.

    Args:
        function, inputs: as of `compile_function`.

    Raises:
        ArgumentError: the function is no polynomial, or an input has no range.
    """
    graph = read_graph(function)
    (_, enclosures), *_ = pieces(input_variables(function, inputs), graph.nodes, 1)
    found = graph.ranges(enclosures)
    whole = {name: hull(found[k] for k in row) for name, row in graph.outputs.items()}
    return {name: (float(one.ends[0]), float(one.ends[1])) for name, one in whole.items()}
