"""Compiled functions as JSON records: what the integer model needs, and what a proof would.

A step is a line of words: its kind, its operands with commas between, fraction bits, shift, value,
what a constant stands for, and the least and the greatest integer that are proven of it.
"""

from dataclasses import astuple
from fractions import Fraction
from typing import Any

from ccgen.polynomial.compiler import Compiled
from ccgen.polynomial.enclosures import Ends
from ccgen.polynomial.intervals import Interval
from ccgen.polynomial.plan import PRODUCTS, Plan, Step
from ccgen.polynomial.proof import Proof, check_formats, check_widths
from ccgen.polynomial.specification import Variable

_OPERANDS = {"input": 0, "constant": 0, "add": 2, "subtract": 2} | dict.fromkeys(PRODUCTS, 2)
_KINDS = {*_OPERANDS, "negate", "view", "left", "right"}


def compiled_record(compiled: Compiled) -> dict[str, Any]:
    """A compiled function as what JSON can say."""
    plan, proof = compiled.plan, compiled.proof
    return {
        "name": compiled.name,
        "inputs": [_variable_record(one) for one in plan.inputs],
        "steps": [
            _step_line(step, ends) for step, ends in zip(plan.steps, proof.integers, strict=True)
        ],
        "outputs": [
            _variable_record(variable) | {"step": step, "error": [error.low, error.high]}
            for (variable, step), error in zip(plan.outputs, proof.errors, strict=True)
        ],
    }


def compiled_function(record: dict[str, Any]) -> Compiled:
    """The function that a record holds, its formats and widths checked again.

    Raises:
        KeyError, TypeError, ValueError, CheckError: no record of a function.
    """
    lines = [line.split(" ") for line in record["steps"]]
    steps = tuple(_step(number, words) for number, words in enumerate(lines))
    integers: list[Ends] = [(int(words[-2]), int(words[-1])) for words in lines]
    inputs = tuple(_variable(one) for one in record["inputs"])
    if [step.kind for step in steps].count("input") != len(inputs):
        raise ValueError("a plan whose inputs are not its first steps")
    outputs = tuple((_variable(one), int(one["step"])) for one in record["outputs"])
    if any(not 0 <= step < len(steps) for _, step in outputs):
        raise ValueError("an output of no step")
    plan = Plan(inputs, steps, outputs)
    check_formats(steps)
    check_widths(plan, integers)
    errors = [Interval(*(int(end) for end in one["error"])) for one in record["outputs"]]
    return Compiled(str(record["name"]), plan, Proof(tuple(integers), tuple(errors)))


def _step_line(step: Step, ends: Ends) -> str:
    kind, operands, *numbers = astuple(step)
    words = [kind, ",".join(map(str, operands)) or "-", *numbers, *ends]
    return " ".join(map(str, words))


def _step(number: int, words: list[str]) -> Step:
    kind, named, fraction_bits, shift, value, exact, _, _ = words
    operands = () if named == "-" else tuple(int(word) for word in named.split(","))
    fits = kind in _KINDS and len(operands) == _OPERANDS.get(kind, 1)
    if not fits or any(not 0 <= operand < number for operand in operands):
        raise ValueError(f"step {number} of a plan: {' '.join(words)}")
    return Step(kind, operands, int(fraction_bits), int(shift), int(value), Fraction(exact))


def _variable_record(variable: Variable) -> dict[str, Any]:
    return {
        "name": variable.name,
        "element": variable.element,
        "format": [variable.bits, variable.fraction_bits],
        "range": [variable.low, variable.high],
        "held": variable.held,
    }


def _variable(record: dict[str, Any]) -> Variable:
    element = record["element"]
    bits, fraction_bits = (int(one) for one in record["format"])
    low, high = (int(one) for one in record["range"])
    place = None if element is None else int(element)
    return Variable(
        str(record["name"]), place, bits, fraction_bits, low, high, bool(record["held"])
    )
