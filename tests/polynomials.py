"""Polynomial functions of many kinds, and CasADi's graphs in exact rational arithmetic."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import casadi
import numpy as np

from ccgen.polynomial import Compiled, Input, Output, compile_function


@dataclass(frozen=True)
class Case:
    """A function with what is asked of it."""

    make: Callable[[], casadi.Function]
    inputs: dict[str, Input]
    outputs: dict[str, Output]

    def compiled(self) -> Compiled:
        return compile_function(self.make(), self.inputs, self.outputs)


def _function(name, inputs, outputs):
    return casadi.Function(
        name, list(inputs.values()), list(outputs.values()), list(inputs), list(outputs)
    )


def sym(*sizes):
    return [casadi.SX.sym(f"x{k}", *np.atleast_1d(size)) for k, size in enumerate(sizes)]


def hermite():
    (t,) = sym(1)
    basis = [2 * t**3 - 3 * t**2 + 1, t**3 - 2 * t**2 + t, 3 * t**2 - 2 * t**3, t**3 - t**2]
    return _function("hermite", {"t": t}, {"basis": casadi.vertcat(*basis)})


def bernstein():
    (t,) = sym(1)
    choose = (1, 5, 10, 10, 5, 1)
    basis = [c * t**k * (1 - t) ** (5 - k) for k, c in enumerate(choose)]
    return _function("bernstein", {"t": t}, {"basis": casadi.vertcat(*basis)})


def quaternion_product():
    p, q = sym(4, 4)
    w = p[0] * q[0] - casadi.dot(p[1:], q[1:])
    v = p[0] * q[1:] + q[0] * p[1:] + casadi.cross(p[1:], q[1:])
    return _function("quaternion_product", {"p": p, "q": q}, {"r": casadi.vertcat(w, v)})


def three_links():
    c, s = sym(3, 3)
    length = (0.3, 0.25, 0.1)
    cosine, sine, x, y = 1, 0, 0, 0
    for k in range(3):
        cosine, sine = cosine * c[k] - sine * s[k], sine * c[k] + cosine * s[k]
        x, y = x + length[k] * cosine, y + length[k] * sine
    return _function("three_links", {"c": c, "s": s}, {"x": x, "y": y})


def filter_step():
    x, state = sym(1, 2)
    b, a = (0.0675, 0.1349, 0.0675), (-1.1430, 0.4128)
    y = b[0] * x + state[0]
    after = casadi.vertcat(b[1] * x - a[0] * y + state[1], b[2] * x - a[1] * y)
    return _function("filter_step", {"x": x, "state": state}, {"y": y, "after": after})


def legendre():
    (x,) = sym(1)
    row = [casadi.SX(1), x]
    for n in range(1, 6):
        row.append(((2 * n + 1) * x * row[n] - n * row[n - 1]) / (n + 1))
    return _function("legendre", {"x": x}, {"basis": casadi.vertcat(*row)})


def rotated():
    q, v = sym(4, 3)
    t = 2 * casadi.cross(q[1:], v)
    return _function("rotated", {"q": q, "v": v}, {"w": v + q[0] * t + casadi.cross(q[1:], t)})


def determinant():
    (matrix,) = sym((3, 3))
    return _function("determinant", {"matrix": matrix}, {"det": casadi.det(matrix)})


def prey_and_predator():
    x, y = sym(1, 1)
    h = 0.01
    after = [x + h * (1.1 * x - 0.4 * x * y), y + h * (0.1 * x * y - 0.4 * y)]
    return _function("prey_and_predator", {"x": x, "y": y}, {"after": casadi.vertcat(*after)})


def catmull_rom():
    t, p = sym(1, 4)
    inner = (-p[0] + 3 * p[1] - 3 * p[2] + p[3]) * t + 2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]
    return _function(
        "catmull_rom", {"t": t, "p": p}, {"value": p[1] + 0.5 * t * (p[2] - p[0] + t * inner)}
    )


def thermistor():
    (x,) = sym(1)
    value = 25.02 + x * (-41.37 + x * (12.46 + x * (-7.013 + x * 3.377)))
    return _function("thermistor", {"x": x}, {"celsius": value})


def bilinear():
    s, t, corner = sym(1, 1, (2, 2))
    low = corner[0, 0] + s * (corner[1, 0] - corner[0, 0])
    high = corner[0, 1] + s * (corner[1, 1] - corner[0, 1])
    return _function(
        "bilinear", {"s": s, "t": t, "corner": corner}, {"value": low + t * (high - low)}
    )


UNIT = Input((-1, 1), 14)
PART = Input((0, 1), 14)

CASES = {
    "hermite": Case(hermite, {"t": PART}, {"basis": Output(1e-6)}),
    "bernstein": Case(bernstein, {"t": PART}, {"basis": Output(1e-5)}),
    "quaternion_product": Case(
        quaternion_product, {"p": UNIT, "q": UNIT}, {"r": Output(1e-3, 12, 16)}
    ),
    "three_links": Case(
        three_links, {"c": UNIT, "s": UNIT}, {"x": Output(5e-5, bits=16), "y": Output(1e-6)}
    ),
    "filter_step": Case(
        filter_step,
        {"x": Input((-1, 1), 15 - 1), "state": Input((-2, 2), 28, 32)},
        {"y": Output(1e-7), "after": Output(1e-7, 28)},
    ),
    "legendre": Case(legendre, {"x": UNIT}, {"basis": Output(1e-6)}),
    "rotated": Case(rotated, {"q": UNIT, "v": Input((-10, 10), 11)}, {"w": Output(1e-3)}),
    "determinant": Case(determinant, {"matrix": Input((-3, 3), 12)}, {"det": Output(0.02)}),
    "prey_and_predator": Case(
        prey_and_predator,
        {"x": Input((0, 50), 24, 32), "y": Input((0, 30), 24, 32)},
        {"after": Output(1e-5, 24)},
    ),
    "catmull_rom": Case(
        catmull_rom, {"t": PART, "p": Input((-100, 100), 8)}, {"value": Output(0.02, bits=16)}
    ),
    "thermistor": Case(thermistor, {"x": Input((-0.9, 0.95), 15)}, {"celsius": Output(0.001)}),
    "bilinear": Case(
        bilinear,
        {"s": PART, "t": PART, "corner": Input([(0, 1), (0, 1), (0, 2), (-1, 1)], 13)},
        {"value": Output(1e-4)},
    ),
}  # fmt: skip


def exact(function: casadi.Function, values: list[list[Fraction]]) -> list[list[Fraction]]:
    """A function's outputs in rationals, operation by operation as CasADi lists them."""
    work: dict[int, Fraction] = {}
    outputs = [[Fraction(0)] * function.numel_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        kind = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if kind == casadi.OP_INPUT:
            work[writes[0]] = values[reads[0]][reads[1]]
        elif kind == casadi.OP_OUTPUT:
            outputs[writes[0]][writes[1]] = work[reads[0]]
        elif kind == casadi.OP_CONST:
            work[writes[0]] = Fraction(function.instruction_constant(k))
        else:
            work[writes[0]] = _OPERATIONS[kind](*(work[place] for place in reads))
    return outputs


_OPERATIONS = {
    casadi.OP_ADD: lambda a, b: a + b,
    casadi.OP_SUB: lambda a, b: a - b,
    casadi.OP_MUL: lambda a, b: a * b,
    casadi.OP_DIV: lambda a, b: a / b,
    casadi.OP_NEG: lambda a: -a,
    casadi.OP_SQ: lambda a: a * a,
    casadi.OP_TWICE: lambda a: 2 * a,
}


def drawn(compiled: Compiled, count: int, seed: int = 3) -> dict[str, np.ndarray]:
    """Integers of every input: corners of the ranges, then anything within, shape (count, …)."""
    random = np.random.default_rng(seed)
    columns: dict[str, list[np.ndarray]] = {}
    for one in compiled.plan.inputs:
        values = random.integers(one.low, one.high + 1, count)
        corners = random.integers(0, 3, count)
        values[: count // 3] = np.select([corners == 0, corners == 1], [one.low, one.high], values)[
            : count // 3
        ]
        columns.setdefault(one.name, []).append(values)
    scalars = {one.name for one in compiled.plan.inputs if one.element is None}
    return {
        name: rows[0] if name in scalars else np.stack(rows, axis=-1)
        for name, rows in columns.items()
    }
