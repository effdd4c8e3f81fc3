"""Functions of a joint's angles in integers: their reference model."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ccgen.fixedpoint.model import FixedPointModel, Integers
from ccgen.polynomial import Compiled
from ccgen.polynomial.specification import Variable


@dataclass(frozen=True, eq=False)
class JointFunctions:
    """A user's functions of the angles and elongations that a joint's model has.

    Attributes:
        compiled: the functions; their inputs are named after the model's axes.
        source: name of the module's file.
        sha256: of the file.
    """

    compiled: tuple[Compiled, ...] = ()
    source: str = ""
    sha256: str = ""

    def __bool__(self) -> bool:
        """Whether there is any."""
        return bool(self.compiled)

    @property
    def words(self) -> int:
        """Number of all functions' results."""
        return sum(len(function.plan.outputs) for function in self.compiled)

    def evaluate(self, model: FixedPointModel, values: Integers) -> Integers:
        """The integer reference model: all results, function by function, output by output.

        Args:
            model: the joint's.
            values: integers of all axes, shape (N, rows).

        Returns:
            Shape (N, `words`).
        """
        parts = model.split(np.asarray(values, dtype=np.int64))
        columns = [np.zeros((len(values), 0), dtype=np.int64)]
        for function in self.compiled:
            columns += _results(function, parts, len(values))
        return np.concatenate(columns, axis=1)


def _results(function: Compiled, parts: dict[str, Integers], rows: int) -> Iterator[Integers]:
    scalars = {one.name for one in function.plan.inputs if one.element is None}
    inputs = {
        name: parts[name][:, 0] if name in scalars else parts[name]
        for name in dict.fromkeys(one.name for one in function.plan.inputs)
    }
    for result in function.evaluate(inputs).values():
        yield result.reshape(rows, -1)


def outputs_of(function: Compiled) -> dict[str, list[Variable]]:
    """Elements of every output, by its name."""
    found: dict[str, list[Variable]] = {}
    for variable, _ in function.plan.outputs:
        found.setdefault(variable.name, []).append(variable)
    return found
