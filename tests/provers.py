"""Plans as questions to Gappa: the integers' own arithmetic beside the same without rounding."""

import subprocess
from collections.abc import Sequence
from fractions import Fraction

from ccgen.polynomial import Compiled
from ccgen.polynomial.plan import PRODUCTS, Plan

INT32 = (-(2**31), 2**31 - 1)


def definitions(plan: Plan) -> list[str]:
    """Gappa's definitions: r7 is what step 7's integer stands for, m7 what it should.

    What an operation does to the bits is told by the operation alone, so that a step whose format
    is not what its shift gives stands for something else than it should.
    """
    lines = []
    for k, step in enumerate(plan.steps):
        moved = sum(plan.steps[x].fraction_bits for x in step.operands) - step.fraction_bits
        r, m = ([f"{side}{x}" for x in step.operands] for side in "rm")
        floor = f"fixed<{-step.fraction_bits},dn>"
        if step.kind == "input":
            lines += [f"r{k} = {floor}(given{k});", f"m{k} = r{k};"]
        elif step.kind == "constant":
            lines.append(f"r{k} = {power(step.value, -step.fraction_bits)};")
            lines.append(f"m{k} = {number(step.exact)};")
        elif step.kind in PRODUCTS:
            scale = power(1, moved - PRODUCTS[step.kind])
            lines += [f"r{k} = {floor}({r[0]} * {r[1]}{times(scale)});", f"m{k} = {m[0]} * {m[1]};"]
        elif step.kind in ("add", "subtract"):
            sign = "+" if step.kind == "add" else "-"
            lines += [f"r{k} = {side[0]} {sign} {side[1]};" for side in (r,)]
            lines.append(f"m{k} = {m[0]} {sign} {m[1]};")
        elif step.kind == "negate":
            lines += [f"r{k} = -{r[0]};", f"m{k} = -{m[0]};"]
        elif step.kind == "view":
            scale = times(power(1, moved))
            lines += [f"r{k} = {r[0]}{scale};", f"m{k} = {m[0]}{times(power(1, step.shift))};"]
        elif step.kind == "left":
            lines += [f"r{k} = {r[0]}{times(power(1, moved + step.shift))};", f"m{k} = {m[0]};"]
        else:
            added = power(step.value, -step.fraction_bits - step.shift)
            moving = f"{r[0]}{times(power(1, moved - step.shift))}"
            lines.append(f"i{k} = {moving}{f' + {added}' if step.value else ''};")
            lines += [f"r{k} = {floor}(i{k});", f"m{k} = {m[0]};"]
    return lines


def number(value: Fraction) -> str:
    """A rational as Gappa writes it."""
    digits = value.denominator.bit_length() - 1
    if value.denominator == 1 << digits:
        return power(value.numerator, -digits)
    return f"{value.numerator} / {value.denominator}"


def power(value: int, exponent: int) -> str:
    """A dyadic number as Gappa writes it."""
    return f"{value}b{exponent}" if exponent else str(value)


def times(scale: str) -> str:
    return "" if scale == "1" else f" * {scale}"


def hints(plan: Plan) -> list[str]:
    """Which number approximates which, and how an error splits where a constant was added."""
    lines = []
    for k, step in enumerate(plan.steps):
        if step.kind == "right" and step.value:
            added = power(step.value, -step.fraction_bits - step.shift)
            (a,) = step.operands
            lines.append(f"r{k} - m{k} -> (r{k} - i{k}) + {added} + (r{a} - m{a});")
        elif step.kind not in ("input", "view", "left"):
            lines.append(f"r{k} ~ m{k};")
    return lines


def script(found: Compiled, claims: Sequence[str]) -> str:
    """Asks Gappa for claims over all inputs in range."""
    given = [
        f"r{k} in [{power(one.low, -one.fraction_bits)}, {power(one.high, -one.fraction_bits)}]"
        for k, one in enumerate(found.plan.inputs)
    ]
    body = "\n  /\\ ".join(claims)
    where = " /\\ ".join(given)
    return "\n".join([*definitions(found.plan), f"{{ {where} ->\n  {body} }}", *hints(found.plan)])


def widths(plan: Plan) -> list[str]:
    """That no integer leaves 32 bits."""
    return [
        f"r{k} in [{power(INT32[0], -step.fraction_bits)}, {power(INT32[1], -step.fraction_bits)}]"
        for k, step in enumerate(plan.steps)
        if step.kind not in ("input", "constant")
    ]


def errors(plan: Plan, bounds: Sequence[Fraction]) -> list[str]:
    """That outputs are within bounds, which are rounded up to 100 binary digits."""
    return [
        f"|r{step} - m{step}| <= {power(-(-(bound * 2**100) // 1), -100)}"
        for (_, step), bound in zip(plan.outputs, bounds, strict=True)
    ]


def proven(text: str) -> bool:
    """Whether Gappa proves everything."""
    done = subprocess.run(
        ["gappa"], input=text, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0 or "properties were not satisfied" in done.stderr, done.stderr
    return done.returncode == 0
