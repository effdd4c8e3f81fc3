"""Polynomial functions compiled to integers: their bounds, their C, and what is refused."""

import ctypes
import subprocess
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polynomials import CASES, PART, Case, drawn, exact
from runtime_c import COMPILERS, UNDEFINED, WARNINGS, compile_c

from ccgen.errors import ArgumentError, CheckError, FormatError
from ccgen.polynomial import Compiled, Input, Output, c_files, compile_function
from ccgen.polynomial.plan import Plan
from ccgen.polynomial.proof import prove
from ccgen.resources import firmware

NAMES = sorted(CASES)


@cache
def compiled(name: str) -> Compiled:
    return CASES[name].compiled()


def errors(case: Case, found: Compiled, values: dict[str, np.ndarray]) -> dict[str, Fraction]:
    """Largest distance of every output to exact arithmetic."""
    function, worst = case.make(), {}
    results = found.evaluate(values)
    count = len(next(iter(values.values())))
    for row in range(count):
        point = [
            [Fraction(int(x)) / 2**stated.fraction_bits for x in np.atleast_1d(values[key][row])]
            for key, stated in ((k, case.inputs[k]) for k in function.name_in())
        ]
        for key, expected in zip(function.name_out(), exact(function, point), strict=True):
            unit = Fraction(1, 2 ** found.formats[key])
            got = [int(x) * unit for x in np.atleast_1d(results[key][row])]
            off = max(abs(x - y) for x, y in zip(got, expected, strict=True))
            worst[key] = max(worst.get(key, Fraction(0)), off)
    return worst


@pytest.mark.parametrize("name", NAMES)
def test_bounds_are_as_wanted_and_hold_against_exact_arithmetic(name):
    case, found = CASES[name], compiled(name)
    worst = errors(case, found, drawn(found, 400))
    for key, wanted in case.outputs.items():
        bound = max(found.bounds[key])
        assert worst[key] <= bound <= Fraction(wanted.error)


@pytest.mark.parametrize("name", NAMES)
def test_bounds_are_not_far_above_what_is_met(name):
    found = compiled(name)
    worst = errors(CASES[name], found, drawn(found, 400))
    for key, bounds in found.bounds.items():
        assert max(bounds) <= 8 * worst[key]


@pytest.mark.parametrize("name", NAMES)
def test_integers_stay_within_what_is_proven(name):
    found = compiled(name)
    found.evaluate(drawn(found, 200_000))  # raises where one does not


@cache
def library(compiler: str, flags: tuple[str, ...]) -> ctypes.CDLL:
    """All cases in C."""
    functions = [compiled(name) for name in NAMES]
    with TemporaryDirectory() as folder:
        for file, text in c_files("cases", functions).items():
            (Path(folder) / file).write_text(text)
        source = Path(folder) / "cases.c"
        return ctypes.CDLL(str(compile_c([source], ("-shared", "-fPIC", *flags), compiler)))


def run_c(function, found: Compiled, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The C of a compiled function on rows of inputs."""
    kinds = {one.name: np.dtype(f"int{one.bits}") for one in found.plan.inputs}
    scalars = {one.name for one in found.plan.inputs if one.element is None}
    arrays = {key: np.ascontiguousarray(values[key].astype(kind)) for key, kind in kinds.items()}
    count = len(next(iter(arrays.values())))
    shapes: dict[str, list[int]] = {}
    for one, _ in found.plan.outputs:
        shapes.setdefault(one.name, [0, one.bits])[0] += 1
    results = {key: np.zeros((count, n), f"int{bits}") for key, (n, bits) in shapes.items()}
    for row in range(count):
        passed = [
            int(a[row]) if key in scalars else ctypes.c_void_p(a[row].ctypes.data)
            for key, a in arrays.items()
        ]
        function(*passed, *(ctypes.c_void_p(a[row].ctypes.data) for a in results.values()))
    return results


BUILDS = [
    *((compiler, (level,)) for compiler in COMPILERS for level in ("-O0", "-O1", "-O2", "-O3")),
    (COMPILERS[0], ("-O1", "-DCCGEN_LONG_PRODUCTS=0", *UNDEFINED)),
    (COMPILERS[0], ("-O1", *UNDEFINED)),
]


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: " ".join((build[0], *build[1][:2])))
def test_c_gives_the_models_bits_for_any_input_of_its_type(build):
    random = np.random.default_rng(5)
    for name in NAMES:
        found = compiled(name)
        values = drawn(found, 100)
        for one in found.plan.inputs:  # and far outside of the ranges
            some = values[one.name][80:]
            half = 2 ** (one.bits - 1)
            some[...] = random.integers(-half, half, some.shape)
        expected = found.evaluate(values)
        for key, result in run_c(getattr(library(*build), name), found, values).items():
            np.testing.assert_array_equal(result.reshape(expected[key].shape), expected[key], name)


@pytest.mark.parametrize("level", ["-O0", "-Os", "-O2", "-O3"])
def test_a_core_without_long_products_calls_no_library(level, tmp_path):
    for file, text in c_files("cases", [compiled(name) for name in NAMES]).items():
        (tmp_path / file).write_text(text)
    core = ("arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "-std=c99", level)
    made = str(tmp_path / "cases.o")
    include = f"-I{firmware() / 'include'}"
    subprocess.run(
        [*core, *WARNINGS, include, "-c", str(tmp_path / "cases.c"), "-o", made], check=True
    )
    listed = subprocess.run(
        ["arm-none-eabi-nm", "-u", made], check=True, capture_output=True, text=True
    )
    assert listed.stdout == ""


def test_the_guide_shows_what_the_compiler_gives(tmp_path, monkeypatch, capsys):
    guide = (Path(__file__).parent.parent / "docs" / "polynomial.md").read_text(encoding="utf-8")
    code = guide.split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "docs/polynomial.md", "exec"), {})
    printed = [line.split("# ")[1] for line in code.splitlines() if line.startswith("print")]
    assert capsys.readouterr().out.splitlines() == printed
    shown = guide.split("```c\n")[1].split("```")[0]
    assert shown in (tmp_path / "curves.c").read_text()


HELPERS = """
#include "ccgen/product.h"
int32_t word(int32_t a, int32_t b);
int32_t high(int32_t a, int32_t b);
int32_t word(int32_t a, int32_t b) { return ccgen_product_word(a, b); }
int32_t high(int32_t a, int32_t b) { return ccgen_product_high(a, b); }
int32_t half(int32_t a, int32_t b);
uint32_t add(uint32_t sum, int16_t a, int16_t b);
int32_t half(int32_t a, int32_t b) { return ccgen_product_half(a, b); }
uint32_t add(uint32_t sum, int16_t a, int16_t b) { return ccgen_add_product16(sum, a, b); }
"""


@cache
def helpers(long_products: int) -> ctypes.CDLL:
    with TemporaryDirectory() as folder:
        source = Path(folder) / "helpers.c"
        source.write_text(HELPERS)
        flags = ("-shared", "-fPIC", f"-DCCGEN_LONG_PRODUCTS={long_products}", *UNDEFINED)
        return ctypes.CDLL(str(compile_c([source], flags)))


INT32 = st.integers(-(2**31), 2**31 - 1) | st.sampled_from((-(2**31), 2**31 - 1, -65536, 65535, -1))


@given(INT32, INT32)
def test_products_are_rounded_down_by_either_kind_of_core(a, b):
    b16 = (b & 0xFFFF) - 0x8000
    for kind in (0, 1):
        assert helpers(kind).high(a, b) == a * b >> 32
        assert helpers(kind).word(a, b16) == a * b16 >> 16
        assert helpers(kind).half(a >> 15 | 1, b16) == (a >> 15 | 1) * b16
        assert (helpers(kind).add(b, a >> 16, b16) - b - (a >> 16) * b16) % 2**32 == 0


def test_the_same_function_gives_the_same_c():
    first, second = (c_files("one", [CASES["rotated"].compiled()]) for _ in range(2))
    assert first == second


def changed(plan: Plan, number: int, **fields: int) -> Plan:
    """A plan with one step changed."""
    steps = list(plan.steps)
    steps[number] = replace(steps[number], **fields)
    return replace(plan, steps=tuple(steps))


def test_a_plan_whose_shift_or_format_is_off_by_one_is_not_proven():
    found = compiled("bernstein")
    for number, step in enumerate(found.plan.steps):
        if step.kind in ("left", "right"):
            with pytest.raises(CheckError):
                prove(changed(found.plan, number, shift=step.shift + 1))
        if step.kind != "input":
            with pytest.raises(CheckError):
                prove(changed(found.plan, number, fraction_bits=step.fraction_bits + 1))


def test_constant_outputs_and_inputs_that_nothing_uses_are_fine():
    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    function = casadi.Function(
        "plain", [x, y], [casadi.vertcat(x, 0, 1.5, x * 0.1 - x / 3)], ["x", "y"], ["z"]
    )
    found = compile_function(function, {"x": PART, "y": PART}, {"z": Output(1e-6)})
    result = (
        found.evaluate({"x": np.array([16384]), "y": np.array([0])})["z"]
        * 2.0 ** -found.formats["z"]
    )
    assert np.abs(result - [1, 0, 1.5, 0.1 - 1 / 3]).max() <= 1e-6


def test_functions_of_matrices_are_read_too():
    a, x = casadi.MX.sym("a", 2, 2), casadi.MX.sym("x", 2)
    function = casadi.Function("form", [a, x], [casadi.bilin(a, x, x)], ["a", "x"], ["y"])
    found = compile_function(function, {"a": PART, "x": PART}, {"y": Output(1e-3)})
    half = {"a": np.full((1, 4), 8192), "x": np.full((1, 2), 8192)}
    assert found.evaluate(half)["y"][0] == 2 ** found.formats["y"] // 2


X, Y = casadi.SX.sym("x"), casadi.SX.sym("y")


def one_output(expression) -> casadi.Function:
    return casadi.Function("energy", [X, Y], [expression], ["x", "y"], ["z"])


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        (casadi.sin(X) * Y, "uses sin, which no polynomial has; give its value as an input"),
        (casadi.sqrt(X), "uses sqrt, which"),
        (Y / X, "divides by a variable, which no polynomial does; give the quotient as an input"),
        (1 / X, "divides by a variable"),
        (casadi.if_else(X > 0, X, Y), "uses a branch (lt), which"),
        (casadi.fabs(X), "uses fabs, which"),
        (X**Y, "uses a power that is no small whole number, which"),
        (X / ((X * Y) * Y - X * (Y * Y)), "divides by"),
        (X + casadi.inf, "has the constant inf"),
    ],
)
def test_what_is_no_polynomial_is_refused_by_its_name(expression, said):
    with pytest.raises(ArgumentError) as caught:
        compile_function(one_output(expression), {"x": PART, "y": PART}, {"z": Output(0.1)})
    assert str(caught.value).startswith(f"function: {said}")


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({"x": PART}, "inputs: no range of y; give one for x, y"),
        ({"x": PART, "y": PART, "w": PART}, "inputs: w is unknown; the function has x, y"),
        ({"x": PART, "y": Input((0, 1), 15)}, "inputs: 0 to 1 of y does not fit 16 bits with 15 "),
        ({"x": PART, "y": Input((1, 0), 8)}, "inputs: the range of y is 1 to 0; a lower and an "),
        ({"x": PART, "y": Input((0, float("nan")), 8)}, "inputs: the range of y is 0 to nan; "),
        ({"x": PART, "y": Input((0.3, 0.4), 0)}, "inputs: no number of y's format lies from 0.3 "),
        ({"x": PART, "y": Input([(0, 1), (0, 1)], 8)}, "inputs: the range of y is [(0, 1), (0, 1"),
        ({"x": PART, "y": Input((0, 1), 8, 24)}, "inputs: y has 24 bits; 16 or 32"),
        ({"x": PART, "y": Input((0, 1), 800)}, "inputs: y has 800 fraction bits; at most 120 "),
    ],
)
def test_inputs_without_a_range_that_fits_are_refused(inputs, said):
    with pytest.raises(ArgumentError) as caught:
        compile_function(one_output(X * Y), inputs, {"z": Output(0.1)})
    assert str(caught.value).startswith(said)


def test_an_error_that_no_plan_meets_is_refused_with_the_best_one():
    narrow = {"x": Input((-1, 1), 30, 32), "y": Input((-1, 1), 30, 32)}
    with pytest.raises(FormatError) as caught:
        compile_function(one_output(X * Y), narrow, {"z": Output(1e-11)})
    said = str(caught.value)
    assert said.startswith("energy: no plan of 32 bits meets the error; the best is proven to ")
    best = float(said.split("proven to ")[1].split(" of z")[0])
    found = compile_function(one_output(X * Y), narrow, {"z": Output(best)})
    assert 1e-11 < max(found.bounds["z"]) <= best


@pytest.mark.parametrize(
    ("output", "said"),
    [
        (Output(0.0), "outputs: the error of z is 0; above 0"),
        (Output(0.1, bits=8), "outputs: z has 8 bits; 16 or 32"),
        (None, "outputs: no error of z; give one for z"),
    ],
)
def test_outputs_that_ask_for_nothing_sensible_are_refused(output, said):
    with pytest.raises(ArgumentError, match=said):
        compile_function(
            one_output(X * Y), {"x": PART, "y": PART}, {} if output is None else {"z": output}
        )


def test_values_that_do_not_fit_their_output_are_refused():
    with pytest.raises(FormatError, match="energy: no plan of 32 bits holds its values"):
        compile_function(one_output(X + Y), {"x": PART, "y": PART}, {"z": Output(0.1, 15, 16)})


@pytest.mark.parametrize("name", ["for", "t3", "x_1", "9a"])
def test_names_that_c_cannot_have_are_refused(name):
    with pytest.raises(ArgumentError, match=f"functions: {name} cannot be a name in C; rename it"):
        c_files(name, [compiled("hermite")])


def test_a_name_of_both_an_input_and_an_output_is_refused():
    function = casadi.Function(
        "step", [X], [X * X], ["x"], ["x"], {"allow_duplicate_io_names": True}
    )
    found = compile_function(function, {"x": PART}, {"x": Output(0.1)})
    with pytest.raises(ArgumentError, match="functions: x is an input and an output; rename one"):
        c_files("steps", [found])


def test_two_functions_of_one_name_are_refused():
    with pytest.raises(ArgumentError, match="functions: hermite is the name of 2 functions"):
        c_files("bases", [compiled("hermite"), compiled("hermite")])


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"t": np.array([0.5])}, "values: t is not of integers"),
        ({"x": np.array([1])}, "values: has x; give t"),
    ],
)
def test_values_of_another_kind_are_refused(values, said):
    with pytest.raises(ArgumentError, match=said):
        compiled("hermite").evaluate(values)
