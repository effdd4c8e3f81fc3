"""The arithmetic of a CasADi function as plain single-precision C statements.

CasADi's generated C brings a calling convention, sparsity tables and <math.h> that a firmware has
no use for, and literals in double precision. Only the function's arithmetic is kept: every line
must be one of the shapes below, anything else is an error rather than a guess.

CasADi's versions differ in where they write constants and in which work variable holds what. So
only the values are taken over: constants and inputs stand where they are used, and variables are
given out here, in order of use, each again as soon as its value was used for the last time.
"""

import heapq
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from ccgen.errors import ToolError
from ccgen.export.literals import float_literal

_NUMBER = r"\d+\.\d*(?:e[+-]\d+)?"
_OPERAND = rf"(?:a\d+|{_NUMBER})"
_FUNCTION = re.compile(
    r"/\* (?P<signature>[^\n]*) \*/\n"
    r"static int casadi_f0\(const casadi_real\*\* arg, casadi_real\*\* res, "
    r"casadi_int\* iw, casadi_real\* w, int mem\) \{\n"
    r"(?P<body>.*?)\n  return 0;\n\}\n",
    re.DOTALL,
)
_DECLARATION = re.compile(r"casadi_real (a\d+(?:, a\d+)*);")
_LOAD = re.compile(r"(?P<to>a\d+)=arg\[(?P<i>\d+)\]\? arg\[(?P=i)\]\[(?P<j>\d+)\] : 0;")
_STORE = re.compile(r"if \(res\[(?P<i>\d+)\]!=0\) res\[(?P=i)\]\[(?P<j>\d+)\]=(?P<from>a\d+);")
_CONSTANT = re.compile(rf"(?P<to>a\d+)=(?P<value>-?{_NUMBER});")
_NEGATION = re.compile(rf"(?P<to>a\d+)=\(-\s?(?P<x>{_OPERAND})\);")
_SQUARE = re.compile(r"(?P<to>a\d+)=casadi_sq\((?P<x>a\d+)\);")
_BINARY = re.compile(rf"(?P<to>a\d+)=\((?P<x>{_OPERAND})(?P<operator>[-+*])(?P<y>{_OPERAND})\);")


@dataclass(frozen=True)
class Arithmetic:
    """One function's arithmetic; the caller's C names stand for its inputs and outputs."""

    signature: str  # CasADi's own comment: name:(inputs)->(outputs)
    variables: tuple[str, ...]  # work variables, to be declared as float
    inputs: tuple[tuple[str, str], ...]  # (local constant, C expression that it is read from)
    statements: tuple[str, ...]

    @property
    def operations(self) -> int:
        """Number of additions, subtractions and multiplications."""
        return sum(bool(re.search(r" = \S+ [-+*] ", line)) for line in self.statements)


def arithmetic(
    function: Any, inputs: Sequence[Sequence[str]], outputs: Sequence[Sequence[str]]
) -> Arithmetic:
    """Extract a CasADi function's arithmetic.

    All inputs are read before the first output is written, so both may name the same objects.

    Args:
        function: `casadi.Function` of SX graphs with dense inputs and outputs.
        inputs: C expressions of every input's elements, column-major as CasADi counts them. A
            plain identifier is used as it stands, anything else is read into a local constant.
        outputs: C lvalues of every output's elements, likewise.

    Raises:
        ToolError: CasADi's C has a form that this module does not know.
    """
    signature, body = _split(_generate(function))
    reader = _Reader(inputs, outputs)
    for line in body:
        reader.read(line.strip())
    reader.finish()
    variables, statements = _written(reader.steps)
    return Arithmetic(
        signature=signature,
        variables=tuple(variables),
        inputs=tuple(reader.loads),
        statements=tuple(statements),
    )


def _generate(function: Any) -> str:
    import casadi

    generator = casadi.CodeGenerator("f.c", {"casadi_real": "float"})
    generator.add(function)
    return str(generator.dump())


def _split(source: str) -> tuple[str, list[str]]:
    match = _FUNCTION.search(source)
    if match is None or "casadi_f1" in source:
        raise _unknown("no single function casadi_f0")
    return match["signature"], match["body"].splitlines()


@dataclass(frozen=True)
class _Step:
    """One statement: values that were computed are numbers, anything else is C text."""

    to: int | str
    form: str  # with a place for each operand
    operands: tuple[int | str, ...]


class _Reader:
    """Takes over CasADi's lines one by one."""

    def __init__(self, inputs: Sequence[Sequence[str]], outputs: Sequence[Sequence[str]]) -> None:
        self.loads: list[tuple[str, str]] = []
        self.steps: list[_Step] = []
        self._held: dict[str, int | str] = {}  # what CasADi's work variables hold
        self._inputs = inputs
        self._outputs = outputs
        self._stored: set[tuple[int, int]] = set()

    def read(self, line: str) -> None:
        """Take over one line of the function's body."""
        if _DECLARATION.fullmatch(line):
            return
        if match := _LOAD.fullmatch(line):
            self._held[match["to"]] = self._load(int(match["i"]), int(match["j"]))
        elif match := _STORE.fullmatch(line):
            self._store(int(match["i"]), int(match["j"]), match["from"])
        elif match := _CONSTANT.fullmatch(line):
            self._held[match["to"]] = float_literal(float(match["value"]))
        elif match := _NEGATION.fullmatch(line):
            self._compute(match["to"], "-{}", match["x"])
        elif match := _SQUARE.fullmatch(line):
            self._compute(match["to"], "{} * {}", match["x"], match["x"])
        elif match := _BINARY.fullmatch(line):
            self._compute(match["to"], f"{{}} {match['operator']} {{}}", match["x"], match["y"])
        else:
            raise _unknown(f"the line {line!r}")

    def finish(self) -> None:
        """Check that every output was written."""
        expected = {(i, j) for i, names in enumerate(self._outputs) for j in range(len(names))}
        if self._stored != expected:
            raise _unknown(f"no value for outputs {sorted(expected - self._stored)}")

    def _compute(self, name: str, form: str, *operands: str) -> None:
        number = len(self.steps)
        self.steps.append(_Step(number, form, tuple(self._operand(x) for x in operands)))
        self._held[name] = number

    def _operand(self, text: str) -> int | str:
        if not text.startswith("a"):
            return float_literal(float(text))
        if text not in self._held:
            raise _unknown(f"the variable {text} before it has a value")
        return self._held[text]

    def _load(self, i: int, j: int) -> str:
        try:
            expression = self._inputs[i][j]
        except IndexError:
            raise _unknown(f"input {i} has no element {j}") from None
        if expression.isidentifier():
            return expression
        name = re.sub(r"\W+", "_", expression).strip("_")
        if (name, expression) not in self.loads:
            self.loads.append((name, expression))
        return name

    def _store(self, i: int, j: int, name: str) -> None:
        if i >= len(self._outputs) or j >= len(self._outputs[i]) or (i, j) in self._stored:
            raise _unknown(f"output {i}, element {j}, is not expected (again)")
        self._stored.add((i, j))
        self.steps.append(_Step(self._outputs[i][j], "{}", (self._operand(name),)))


def _written(steps: Sequence[_Step]) -> tuple[list[str], list[str]]:
    """Variables, each free again after its value's last use, and the steps as C statements."""
    last = {x: k for k, step in enumerate(steps) for x in step.operands}
    free: list[int] = []
    places: dict[int | str, int] = {}
    count = 0
    for k, step in enumerate(steps):
        for operand in dict.fromkeys(step.operands):
            if operand in places and last[operand] == k:
                heapq.heappush(free, places[operand])
        if isinstance(step.to, int):
            if not free:
                free.append(count)
                count += 1
            places[step.to] = heapq.heappop(free)
    names = [f"a{number:0{len(str(count - 1))}}" for number in range(count)]

    def name(value: int | str) -> str:
        return names[places[value]] if isinstance(value, int) else value

    statements = [
        f"{name(step.to)} = {step.form.format(*(name(x) for x in step.operands))};"
        for step in steps
    ]
    return names, statements


def _unknown(what: str) -> ToolError:
    return ToolError(
        f"casadi {version('casadi')} writes C that ccgen cannot read: {what};"
        " it is made for casadi 3.6 to 3.8"
    )
