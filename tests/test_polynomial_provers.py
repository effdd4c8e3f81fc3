"""Independent provers confirm what is proven of integer plans, and refuse plans that are wrong."""

from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest
import z3
from joint_files import joint_text
from polynomials import CASES
from provers import errors, proven, script, widths

import ccgen
from ccgen.fixedpoint import AxisModel
from ccgen.polynomial import Compiled

LOOSER = {"filter_step": Fraction(3, 2), "legendre": Fraction(3, 2)}
"""Functions whose errors cancel in part, which Gappa does not see."""


@cache
def compiled(name: str) -> Compiled:
    return CASES[name].compiled()


@pytest.mark.parametrize("name", sorted(CASES))
def test_gappa_confirms_bounds_and_widths(name):
    found = compiled(name)
    looser = LOOSER.get(name, Fraction(1001, 1000))
    bounds = [bound * looser for bound in found.proof.bounds()]
    cut = "\n$ r0 in 16;" if name == "thermistor" else ""
    assert proven(script(found, [*widths(found.plan), *errors(found.plan, bounds)]) + cut)


@pytest.mark.parametrize("name", ["bernstein", "thermistor"])
def test_gappa_refuses_a_plan_with_a_shift_that_is_wrong_by_one_bit(name):
    found = compiled(name)
    wanted = [2 * bound for bound in found.proof.bounds()]
    shifts = [k for k, step in enumerate(found.plan.steps) if step.kind in ("left", "right")]
    for k, by in ((shifts[0], 1), (shifts[-1], -1)):
        steps = list(found.plan.steps)
        steps[k] = replace(steps[k], shift=steps[k].shift + by)
        wrong = replace(found, plan=replace(found.plan, steps=tuple(steps)))
        assert not proven(script(wrong, errors(wrong.plan, wanted)))


def wide(value: z3.BitVecRef, bits: int) -> z3.BitVecRef:
    """A signed number in more bits."""
    return z3.SignExt(bits - value.size(), value)


def counterexample(*conditions: z3.BoolRef) -> bool:
    """Whether z3 finds values for which all hold; it must not give up."""
    solver = z3.Solver()
    solver.set("timeout", 120_000)
    solver.add(*conditions)
    found = solver.check()
    assert found != z3.unknown
    return bool(found == z3.sat)


def may_overflow(model: AxisModel, row: int) -> bool:
    """Whether a sum of the joint's C leaves its accumulator for some differences in range."""
    bits, more = 2 * model.precision, 2 * model.precision + 8
    spans = [int(span) for span in model.span]
    given = [z3.BitVec(f"d{j}", model.precision + 1) for j in range(model.sensors)]
    inside = [z3.And(d >= -span, d <= span) for d, span in zip(given, spans, strict=True)]
    start = int(model.bias[row])
    short, long = z3.BitVecVal(start, bits), z3.BitVecVal(start, more)
    wrong = []
    for d, weight in zip(given, model.weights[row].tolist(), strict=True):
        short = short + z3.BitVecVal(weight, bits) * wide(d, bits)
        long = long + z3.BitVecVal(weight, more) * wide(d, more)
        wrong.append(wide(short, more) != long)
    return counterexample(*inside, z3.Or(wrong))


@cache
def joint_model() -> AxisModel:
    return ccgen.fit(ccgen.parse(joint_text())).model.axis("u")


def test_z3_confirms_that_no_accumulator_of_a_joint_overflows():
    model = joint_model()
    assert not any(may_overflow(model, row) for row in range(model.segments))


def test_z3_refuses_weights_that_are_shifted_one_bit_further_than_fits():
    model = joint_model()
    by = model.headroom_bits + 1
    wrong = replace(model, weights=model.weights << by, bias=model.bias << by)
    assert any(may_overflow(wrong, row) for row in range(model.segments))


def test_z3_confirms_products_of_16_bits_and_the_halves_of_longer_ones():
    """32-bit sums of products of halves, as `ccgen_product_word` forms them, do not overflow."""
    low, high, b = z3.Ints("low high b")
    halves = [low >= 0, low <= 65535, high >= -32768, high <= 32767, b >= -32768, b <= 32767]
    first, second = low * b, high * b
    fits = [z3.And(x >= -(2**31), x < 2**31) for x in (first, second, second + first / 65536)]
    for one in fits:
        solver = z3.Solver()
        solver.add(*halves, z3.Not(one))
        assert solver.check() == z3.unsat
