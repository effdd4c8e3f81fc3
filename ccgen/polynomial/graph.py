"""A polynomial as a graph of exact operations, read from a CasADi function.

Constants are the rationals that equal CasADi's doubles; a division by a constant multiplies by its
exact reciprocal. Operations on constants alone are carried out, equal operations are one, and signs
move into sums.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ccgen.errors import ArgumentError
from ccgen.polynomial.enclosures import Enclosure
from ccgen.polynomial.intervals import Interval


@dataclass(frozen=True)
class Node:
    """One operation.

    Attributes:
        kind: "input", "constant", "add", "subtract", "multiply" or "scale" (by a constant).
        operands: numbers of nodes before it.
        value: of a constant or a scale's factor.
    """

    kind: str
    operands: tuple[int, ...] = ()
    value: Fraction = Fraction(0)


@dataclass(frozen=True)
class Graph:
    """Nodes in order of use; the first are the inputs.

    Attributes:
        nodes: operations.
        outputs: the node of each element of each output, by the output's name.
    """

    nodes: tuple[Node, ...]
    outputs: dict[str, tuple[int, ...]]

    def ranges(self, inputs: Sequence[Enclosure]) -> list[Interval]:
        """Intervals that hold every node's exact values, from what holds those of the inputs."""
        found = list(inputs)
        for node in self.nodes[len(inputs) :]:
            found.append(_enclosed(node, found))
        return [one.value for one in found]


def _enclosed(node: Node, known: list[Enclosure]) -> Enclosure:
    operands = [known[k] for k in node.operands]
    if node.kind == "constant":
        return known[0].constant(Interval.of(node.value))
    if node.kind == "add":
        return operands[0] + operands[1]
    if node.kind == "subtract":
        return operands[0] - operands[1]
    if node.kind == "scale":
        return operands[0].times(Interval.of(node.value))
    same = node.operands[0] == node.operands[1]
    return operands[0].squared() if same else operands[0] * operands[1]


@dataclass
class _Builder:
    """Adds operations, simplified, each once."""

    nodes: list[Node] = field(default_factory=list)
    known: dict[Node, int] = field(default_factory=dict)

    def put(self, node: Node) -> int:
        if node not in self.known:
            self.known[node] = len(self.nodes)
            self.nodes.append(node)
        return self.known[node]

    def input(self) -> int:
        self.nodes.append(Node("input"))
        return len(self.nodes) - 1

    def constant(self, value: Fraction) -> int:
        return self.put(Node("constant", (), value))

    def is_constant(self, k: int) -> bool:
        return self.nodes[k].kind == "constant"

    def scale(self, a: int, factor: Fraction) -> int:
        node = self.nodes[a]
        if node.kind == "constant":
            return self.constant(node.value * factor)
        if node.kind == "scale":
            return self.scale(node.operands[0], node.value * factor)
        if node.kind == "subtract" and factor == -1:
            return self.subtract(node.operands[1], node.operands[0])
        if factor == 0:
            return self.constant(Fraction(0))
        return a if factor == 1 else self.put(Node("scale", (a,), factor))

    def add(self, a: int, b: int) -> int:
        first, second = self.nodes[a], self.nodes[b]
        if self.is_constant(a) and self.is_constant(b):
            return self.constant(first.value + second.value)
        if self.is_constant(a) or self._negative(a):
            a, b, second = b, a, first
        if self.is_constant(b) and second.value == 0:
            return a
        if self._negative(b):
            return self.subtract(a, self.scale(b, Fraction(-1)))
        return self.scale(a, Fraction(2)) if a == b else self.put(Node("add", (a, b)))

    def subtract(self, a: int, b: int) -> int:
        if self.is_constant(b):
            return self.add(a, self.constant(-self.nodes[b].value))
        if a == b:
            return self.constant(Fraction(0))
        if self._negative(b):
            return self.add(a, self.scale(b, Fraction(-1)))
        if self.is_constant(a) and self.nodes[a].value == 0:
            return self.scale(b, Fraction(-1))
        return self.put(Node("subtract", (a, b)))

    def multiply(self, a: int, b: int) -> int:
        if self.is_constant(a):
            return self.scale(b, self.nodes[a].value)
        if self.is_constant(b):
            return self.scale(a, self.nodes[b].value)
        for one, other in ((a, b), (b, a)):
            free = self._free_factor(one)
            if free != 1:
                return self.scale(self.multiply(self.scale(one, 1 / free), other), free)
        return self.put(Node("multiply", (min(a, b), max(a, b))))

    def divide(self, a: int, b: int) -> int:
        divisor = self.nodes[b]
        if divisor.kind != "constant":
            raise ArgumentError(
                "divides by a variable, which no polynomial does; give the quotient as an input",
                "function",
            )
        if divisor.value == 0:
            raise ArgumentError("divides by 0", "function")
        return self.scale(a, 1 / divisor.value)

    def _free_factor(self, k: int) -> Fraction:
        """What costs nothing behind a product instead of before it: a sign, a power of two."""
        node = self.nodes[k]
        if node.kind != "scale":
            return Fraction(1)
        size = abs(node.value)
        whole = (size.numerator & (size.numerator - 1)) + (
            size.denominator & (size.denominator - 1)
        )
        return node.value if whole == 0 else Fraction(-1 if node.value < 0 else 1)

    def _negative(self, k: int) -> bool:
        node = self.nodes[k]
        return node.kind == "scale" and node.value < 0


def read_graph(function: Any) -> Graph:
    """The polynomial that a `casadi.Function` computes; inputs element by element, by columns.

    Raises:
        ArgumentError: the function has an operation that no polynomial has.
    """
    scalar = _expanded(function)
    build = _Builder()
    inputs = [
        [build.input() for _ in range(scalar.size1_in(i) * scalar.size2_in(i))]
        for i in range(scalar.n_in())
    ]
    zero = build.constant(Fraction(0))
    outputs = [[zero] * (scalar.size1_out(i) * scalar.size2_out(i)) for i in range(scalar.n_out())]
    places_in = [_places(scalar.sparsity_in(i)) for i in range(scalar.n_in())]
    places_out = [_places(scalar.sparsity_out(i)) for i in range(scalar.n_out())]
    work: dict[int, int] = {}
    apply = _operations(build)
    for k in range(scalar.n_instructions()):
        name = _operation(scalar.instruction_id(k))
        reads, writes = scalar.instruction_input(k), scalar.instruction_output(k)
        if name == "INPUT":
            work[writes[0]] = inputs[reads[0]][places_in[reads[0]][reads[1]]]
        elif name == "OUTPUT":
            outputs[writes[0]][places_out[writes[0]][writes[1]]] = work[reads[0]]
        elif name == "CONST":
            work[writes[0]] = build.constant(_rational(scalar.instruction_constant(k)))
        elif name in apply:
            work[writes[0]] = apply[name](*(work[place] for place in reads))
        else:
            raise ArgumentError(
                f"uses {_said(name)}, which no polynomial has; give its value as an input",
                "function",
            )
    named = {scalar.name_out(i): tuple(row) for i, row in enumerate(outputs)}
    return _used(build.nodes, named, sum(len(row) for row in inputs))


def _expanded(function: Any) -> Any:
    try:
        return function if function.is_a("SXFunction") else function.expand()
    except RuntimeError as error:
        raise ArgumentError(
            "does more than scalar arithmetic; write it in casadi.SX", "function"
        ) from error


def _places(sparsity: Any) -> list[int]:
    rows, columns = sparsity.get_triplet()
    return [row + column * sparsity.size1() for row, column in zip(rows, columns, strict=True)]


def _operations(build: _Builder) -> dict[str, Callable[..., int]]:
    return {
        "ADD": build.add,
        "SUB": build.subtract,
        "MUL": build.multiply,
        "DIV": build.divide,
        "NEG": lambda a: build.scale(a, Fraction(-1)),
        "SQ": lambda a: build.multiply(a, a),
        "TWICE": lambda a: build.scale(a, Fraction(2)),
        "ASSIGN": lambda a: a,
        "INV": lambda a: build.divide(build.constant(Fraction(1)), a),
    }


def _operation(number: int) -> str:
    import casadi

    names = (name for name in dir(casadi) if name.startswith("OP_"))
    return next(name for name in names if getattr(casadi, name) == number).removeprefix("OP_")


def _said(operation: str) -> str:
    branches = ("LT", "LE", "EQ", "NE", "NOT", "AND", "OR", "IF_ELSE_ZERO")
    powers = ("POW", "CONSTPOW")
    said = "a power that is no small whole number" if operation in powers else operation.lower()
    return f"a branch ({said})" if operation in branches else said


def _rational(value: float) -> Fraction:
    try:
        return Fraction(value)
    except (ValueError, OverflowError):
        raise ArgumentError(f"has the constant {value}", "function") from None


def _used(nodes: list[Node], outputs: dict[str, tuple[int, ...]], inputs: int) -> Graph:
    """The inputs and what outputs depend on."""
    needed = set(range(inputs)) | {k for row in outputs.values() for k in row}
    for k in reversed(range(len(nodes))):
        if k in needed:
            needed.update(nodes[k].operands)
    places = {old: new for new, old in enumerate(sorted(needed))}
    kept = tuple(
        Node(nodes[k].kind, tuple(places[x] for x in nodes[k].operands), nodes[k].value)
        for k in sorted(needed)
    )
    return Graph(kept, {name: tuple(places[k] for k in row) for name, row in outputs.items()})
