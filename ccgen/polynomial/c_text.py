"""C of compiled functions: statements for the templates polynomial.c.j2 and polynomial.h.j2."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from ccgen import __version__, resources
from ccgen.digits import at_least, at_most, rounded_up
from ccgen.errors import ArgumentError
from ccgen.polynomial.compiler import Compiled
from ccgen.polynomial.enclosures import Ends
from ccgen.polynomial.intervals import power_of_two
from ccgen.polynomial.plan import Step
from ccgen.polynomial.specification import Variable

_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while bool true false NULL asm class new delete this template private public protected
virtual operator namespace using try catch throw friend
"""
_INT16 = range(-(2**15), 2**15)
_HELPERS = {"word": "ccgen_product_word", "high": "ccgen_product_high"}
_SIGNS = {"add": "+", "subtract": "-"}


def c_files(name: str, functions: Sequence[Compiled]) -> dict[str, str]:
    """A C file and its header with functions; they need the runtime's `ccgen/product.h`.

    Args:
        name: of both files, without ending.
        functions: compiled functions of different names.

    Returns:
        Contents by file name; the same input gives the same text.

    Raises:
        ArgumentError: a name that C cannot have, or that two functions have.
    """
    require_names(name, functions)
    values = {
        "name": name,
        "version": __version__,
        "functions": [c_context(function) for function in functions],
    }
    return {
        f"{name}.{ending}": resources.template(f"polynomial.{ending}.j2").render(values)
        for ending in ("h", "c")
    }


def require_names(name: str, functions: Sequence[Compiled]) -> None:
    """Refuse names that C cannot have, or that two functions have.

    Raises:
        ArgumentError: naming it.
    """
    names = [name] + [function.name for function in functions]
    for function in functions:
        variables = [one for one, _ in function.plan.outputs] + list(function.plan.inputs)
        own = list(dict.fromkeys((one.name, function.plan.inputs.count(one)) for one in variables))
        twice = [x for x, count in Counter(x for x, _ in own).items() if count > 1]
        if twice:
            raise ArgumentError(f"{twice[0]} is an input and an output; rename one", "functions")
        names += [x for x, _ in own]
    for one in names:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", one) or one in _WORDS.split() or _local(one):
            raise ArgumentError(f"{one} cannot be a name in C; rename it", "functions")
    for one, count in Counter(function.name for function in functions).items():
        if count > 1:
            raise ArgumentError(f"{one} is the name of {count} functions", "functions")


def _local(name: str) -> bool:
    """Whether a name is like those of local constants."""
    return re.fullmatch(r"t\d+|.*_\d+", name) is not None


def c_context(function: Compiled) -> dict[str, Any]:
    """What the templates know of a compiled function."""
    writer = _Writer(function)
    writer.write()
    integers = function.proof.integers
    outputs = [
        replace(variable, low=integers[step][0], high=integers[step][1])
        for variable, step in function.plan.outputs
    ]
    bounds = function.bounds
    return {
        "name": function.name,
        "parameters": ", ".join(
            [_parameter(row, "const ") for row in _grouped(function.plan.inputs)]
            + [_parameter(row, "") for row in _grouped(outputs)]
        ),
        "inputs": [_said(row) for row in _grouped(function.plan.inputs)],
        "outputs": [
            f"{_said(row)}; at most {rounded_up(float(max(bounds[row[0].name])), 2):.2g} "
            "from the exact value"
            for row in _grouped(outputs)
        ],
        "operations": len(writer.statements),
        "loads": writer.loads,
        "statements": writer.statements,
        "stores": writer.stores,
    }


def _left_out(_: Variable) -> str:
    """What stands for an input that nothing reads."""
    return ""


def _grouped(variables: Sequence[Variable]) -> list[list[Variable]]:
    return [list(row) for _, row in groupby(variables, key=lambda one: one.name)]


def _parameter(row: Sequence[Variable], qualifier: str) -> str:
    kind = f"int{row[0].bits}_t"
    if row[0].element is not None:
        return f"{qualifier}{kind} {row[0].name}[{len(row)}]"
    return f"{kind} {row[0].name}" if qualifier else f"{kind} *{row[0].name}"


def _said(row: Sequence[Variable]) -> str:
    low, high = min(one.low for one in row), max(one.high for one in row)
    held = ", kept by the caller" if row[0].held else ""
    return (
        f"{row[0].name}: Q{row[0].fraction_bits}, {_ends((low, high), row[0].fraction_bits)}{held}"
    )


def _ends(ends: Ends, fraction_bits: int) -> str:
    """Both ends of a range, three digits that hold it."""
    low, high = (float(end * power_of_two(-fraction_bits)) for end in ends)
    least = f"-{at_least(-low)}" if low < 0 else at_most(low)
    greatest = at_least(high) if high > 0 else f"-{at_most(-high)}" if high < 0 else "0"
    return f"{least} to {greatest}"


@dataclass
class _Writer:
    """Writes a plan's steps as C, one product or sum a line."""

    function: Compiled

    def __post_init__(self) -> None:
        self.loads: list[str] = []
        self.statements: list[str] = []
        self.stores: list[str] = []
        self._texts: list[str] = []
        plan = self.function.plan
        self._uses = Counter(k for step in plan.steps for k in step.operands)
        self._uses.update(number for _, number in plan.outputs)

    def write(self) -> None:
        """Write everything."""
        plan = self.function.plan
        used = {one.name for number, one in enumerate(plan.inputs) if self._uses[number]}
        self.loads += [
            f"(void){row[0].name};" for row in _grouped(plan.inputs) if row[0].name not in used
        ]
        for number, step in enumerate(plan.steps):
            if step.kind == "input":
                load = self._load if self._uses[number] else _left_out
                self._texts.append(load(plan.inputs[number]))
            else:
                self._texts.append(self._text(number, step))
        for variable, number in plan.outputs:
            place = "" if variable.element is None else f"[{variable.element}]"
            target = f"{variable.name}{place}" if place else f"*{variable.name}"
            text = _bare(self._texts[number])
            cast = f"(int16_t)({text})" if " " in text else f"(int16_t){text}"
            self.stores.append(f"{target} = {cast if variable.bits == 16 else text};")

    def _load(self, variable: Variable) -> str:
        name, source = variable.name, variable.name
        if variable.element is not None:
            name, source = f"{name}_{variable.element}", f"{name}[{variable.element}]"
        else:
            name = f"{name}_0"
        limit = 1 << (variable.bits - 1)
        if not variable.held and (variable.low, variable.high) != (-limit, limit - 1):
            low, high = (_bare(_literal(end)) for end in (variable.low, variable.high))
            source = f"ccgen_limit32({source}, {low}, {high})"
        self.loads.append(f"const int32_t {name} = {source};")
        return name

    def _text(self, number: int, step: Step) -> str:
        """What stands for a step where it is used; a statement is added where it needs one."""
        operands = [self._texts[k] for k in step.operands]
        if step.kind == "constant":
            return _literal(step.value)
        if step.kind == "view":
            return operands[0]
        text = self._operation(step, operands)
        shifts = step.kind in ("left", "right")
        if shifts and self._uses[number] <= 1:
            return text
        ends = self.function.proof.integers[number]
        name = f"t{len(self.statements)}"
        comment = f"Q{step.fraction_bits}, {_ends(ends, step.fraction_bits)}"
        self.statements.append(f"const int32_t {name} = {_bare(text)}; /* {comment} */")
        return name

    def _operation(self, step: Step, operands: list[str]) -> str:
        if step.kind in _SIGNS:
            return f"{operands[0]} {_SIGNS[step.kind]} {operands[1]}"
        if step.kind == "negate":
            return f"-{operands[0]}"
        if step.kind == "left":
            return f"({operands[0]} * {_literal(1 << step.shift)})"
        if step.kind == "right":
            return _right(step, operands[0])
        if step.kind == "low":
            return self._low_product(step, operands)
        return f"{_HELPERS[step.kind]}({_bare(operands[0])}, {_bare(operands[1])})"

    def _low_product(self, step: Step, operands: list[str]) -> str:
        """A product whose lower word is all of it, by how many of its operands are short."""
        short = [
            all(end in _INT16 for end in self.function.proof.integers[k]) for k in step.operands
        ]
        texts = [_bare(text) for text in operands]
        if all(short):
            return f"ccgen_product16({texts[0]}, {texts[1]})"
        if any(short):
            long, half = texts if short[1] else reversed(texts)
            return f"ccgen_product_half({long}, {half})"
        return f"{operands[0]} * {operands[1]}"


def _right(step: Step, operand: str) -> str:
    sign = "-" if step.value < 0 else "+"
    added = f"{operand} {sign} {_literal(abs(step.value))}" if step.value else operand
    return f"ccgen_right({_bare(added)}, {step.shift})" if step.shift else f"({added})"


def _bare(text: str) -> str:
    """Text without brackets around the whole of it."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for place, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return text[1:-1] if place == len(text) - 1 else text
    return text


def _literal(value: int) -> str:
    """An integer of 32 bits as C writes it, whatever the size of int."""
    if value in _INT16 and value != -(2**15):
        return str(value) if value >= 0 else f"({value})"
    if value == -(2**31):
        return "(-INT32_C(2147483647) - 1)"
    return f"INT32_C({value})" if value >= 0 else f"(-INT32_C({-value}))"
