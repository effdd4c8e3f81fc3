"""Plans for a polynomial: how exact every operation must be, then its steps and their ending."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

from ccgen.errors import CheckError
from ccgen.polynomial.builder import COST, Builder
from ccgen.polynomial.enclosures import pieces
from ccgen.polynomial.endings import output_format, rounded, without_idle
from ccgen.polynomial.graph import Graph, Node
from ccgen.polynomial.intervals import ONE, ZERO, Interval, hull
from ccgen.polynomial.plan import Plan, Step
from ccgen.polynomial.proof import Proof, prove
from ccgen.polynomial.specification import Output, Variable

_NO_RELIEF: Mapping[int, int] = MappingProxyType({})


@dataclass(frozen=True)
class Draft:
    """A plan for a task.

    Attributes:
        plan: the plan.
        proof: what is proven of it.
        lacking: of nodes that are multiplied in long forms how many bits a shorter form lacks.
    """

    plan: Plan
    proof: Proof
    lacking: Mapping[int, int]

    @property
    def cost(self) -> int:
        """Instructions of a core without long products, roughly."""
        idle = ("input", "constant", "view")
        return sum(COST.get(step.kind, 1) for step in self.plan.steps if step.kind not in idle)

    def excess(self, outputs: Mapping[str, Output]) -> Fraction:
        """Largest proven error, in units of the one that is wanted."""
        return max(
            bound / Fraction(outputs[variable.name].error)
            for (variable, _), bound in zip(self.plan.outputs, self.proof.bounds(), strict=True)
        )


@dataclass(frozen=True)
class Task:
    """What plans are made from.

    Attributes:
        graph: the polynomial.
        inputs: its inputs.
        outputs: what is wanted of the outputs.
        most: pieces that the inputs' ranges are cut into.
        ranges: of every node's exact values.
        needs: of every node the fraction bits with which one rounding to its format alone is, in
            the worst output, as large as the error wanted there.
    """

    graph: Graph
    inputs: tuple[Variable, ...]
    outputs: Mapping[str, Output]
    most: int
    ranges: list[Interval]
    needs: list[int]

    @classmethod
    def of(
        cls, graph: Graph, inputs: list[Variable], outputs: Mapping[str, Output], most: int
    ) -> "Task":
        """Find out how exact every node must be.

        Args:
            graph: the polynomial.
            inputs: its inputs, in order.
            outputs: what is wanted of its outputs.
            most: pieces that the inputs' ranges are cut into.
        """
        found = [graph.ranges(enclosures) for _, enclosures in pieces(inputs, graph.nodes, most)]
        ranges = [hull(row) for row in zip(*found, strict=True)]
        return cls(graph, tuple(inputs), outputs, most, ranges, _needs(graph, ranges, outputs))

    def planned(self, spare: int, relief: Mapping[int, int] = _NO_RELIEF) -> Draft | None:
        """A plan with so many bits to spare; None where some value does not fit.

        Args:
            spare: bits beyond `needs`.
            relief: bits that nodes may lack, by their numbers.
        """
        build = Builder()
        lacking: dict[int, int] = {}
        places: list[int] = []
        for number, node in enumerate(self.graph.nodes):
            operands = [places[k] for k in node.operands]
            need = self.needs[number] + spare - relief.get(number, 0)
            meant = self.ranges[number]
            if node.kind == "input":
                one = self.inputs[number]
                step = Step("input", (), one.fraction_bits)
                places.append(build.put(step, meant, (one.low, one.high)))
            elif node.kind == "constant":
                places.append(build.constant(node.value, max(0, min(need, 30))))
            elif node.kind == "scale":
                places.append(build.scaled(operands[0], node.value, need, meant))
            elif node.kind == "multiply":
                places.append(build.product(operands[0], operands[1], need, meant))
            else:
                places.append(build.sum(node.kind, operands[0], operands[1], need, meant))
            if places[-1] in build.lacking:
                lacking[number] = build.lacking[places[-1]]
        try:
            return Draft(*self._finished(build, places), lacking)
        except CheckError:
            return None

    def _finished(self, build: Builder, places: list[int]) -> tuple[Plan, Proof]:
        """Bring outputs to their formats, with what rounding is off on average taken off."""
        raw = self._plan(build, [places[k] for row in self.graph.outputs.values() for k in row], 32)
        errors = iter(prove(raw, self.most).errors)
        ends = []
        for name, row in self.graph.outputs.items():
            steps = [places[k] for k in row]
            target, wanted = self._format(build, name, steps), Fraction(self.outputs[name].error)
            ends += [rounded(build, step, target, next(errors), wanted) for step in steps]
        plan = without_idle(self._plan(build, ends))
        return plan, prove(plan, self.most)

    def _format(self, build: Builder, name: str, steps: list[int]) -> int:
        """Fraction bits of an output: as wanted, or the most that its elements have and fit."""
        wanted = self.outputs[name]
        if wanted.fraction_bits is not None:
            return wanted.fraction_bits
        return output_format(build, steps, wanted.bits)

    def _plan(self, build: Builder, ends: list[int], bits: int | None = None) -> Plan:
        """The steps so far as a plan, with outputs of so many bits, or as many as are wanted."""
        names = [
            (name, element if len(row) > 1 else None)
            for name, row in self.graph.outputs.items()
            for element in range(len(row))
        ]
        outputs = []
        for (name, element), step in zip(names, ends, strict=True):
            width = bits or self.outputs[name].bits
            form = build.fraction_bits(step)
            outputs.append((Variable(name, element, width, form, *build.integers[step]), step))
        return Plan(self.inputs, tuple(build.steps), tuple(outputs))


def _needs(graph: Graph, ranges: list[Interval], outputs: Mapping[str, Output]) -> list[int]:
    """`Task.needs`: from the outputs' derivatives by every node."""
    weights = [Fraction(0)] * len(graph.nodes)
    for name, row in graph.outputs.items():
        for output in set(row):
            for number, slope in _slopes(graph, ranges, output).items():
                weight = slope.magnitude / Fraction(outputs[name].error)
                weights[number] = max(weights[number], weight)
    return [
        weight.__ceil__().bit_length() if weight >= 1 else -_halvings(weight) for weight in weights
    ]


def _halvings(weight: Fraction) -> int:
    """How often 1 is halved without falling below a number below 1; 0 for 0."""
    return weight.denominator.bit_length() - weight.numerator.bit_length() - 1 if weight else 0


def _slopes(graph: Graph, ranges: list[Interval], output: int) -> dict[int, Interval]:
    """Derivatives of an output by the nodes that it depends on."""
    slopes = {output: ONE}
    for number in range(output, -1, -1):
        node = graph.nodes[number]
        if number not in slopes:
            continue
        for operand, factor in zip(node.operands, _factors(node, ranges), strict=True):
            slopes[operand] = slopes.get(operand, ZERO) + slopes[number] * factor
    return slopes


def _factors(node: Node, ranges: list[Interval]) -> list[Interval]:
    if node.kind == "multiply":
        return [ranges[node.operands[1]], ranges[node.operands[0]]]
    if node.kind == "scale":
        return [Interval.of(node.value)]
    return [ONE, -ONE] if node.kind == "subtract" else [ONE] * len(node.operands)
