"""Compiled polynomials on emulated cores: the bits of the integer model."""

import subprocess

import numpy as np
import pytest
from polynomials import CASES, drawn

from ccgen import resources
from ccgen.cost.emulator import CORES, Program
from ccgen.cost.link import link
from ccgen.polynomial import Compiled, c_files
from ccgen.targets.compiler import WARNINGS
from ccgen.targets.cores import core_named, require_tools

ROWS = 60
BUFFERS = f"""
#include "cases.h"
int32_t given[{ROWS * 16}], taken[{ROWS * 16}];
"""
LOOP = """
int run_{name}(int rows);
int run_{name}(int rows) {{
    for (int row = 0; row < rows; ++row) {{
        const int32_t *from = given + row * {inputs};
        int32_t *to = taken + row * {outputs};
        {declared}
        {name}({passed});
        {stored}
    }}
    return 0;
}}
"""


def loop(found: Compiled) -> str:
    """A C function that runs a compiled one on rows of `given`, in words, into `taken`."""
    declared, passed, stored, place = [], [], [], 0
    inputs, outputs = found.plan.inputs, [one for one, _ in found.plan.outputs]
    for name in dict.fromkeys(one.name for one in inputs):
        row = [one for one in inputs if one.name == name]
        kind = f"int{row[0].bits}_t"
        values = ", ".join(f"({kind})from[{place + k}]" for k in range(len(row)))
        declared.append(f"const {kind} {name}[{len(row)}] = {{{values}}};")
        passed.append(name if row[0].element is not None else f"{name}[0]")
        place += len(row)
    place = 0
    for name in dict.fromkeys(one.name for one in outputs):
        row = [one for one in outputs if one.name == name]
        declared.append(f"int{row[0].bits}_t {name}[{len(row)}];")
        passed.append(name)
        stored += [f"to[{place + k}] = {name}[{k}];" for k in range(len(row))]
        place += len(row)
    return LOOP.format(
        name=found.name, inputs=len(inputs), outputs=len(outputs), declared=" ".join(declared),
        passed=", ".join(passed), stored=" ".join(stored),
    )  # fmt: skip


@pytest.fixture(scope="module")
def functions() -> dict[str, Compiled]:
    return {name: case.compiled() for name, case in CASES.items()}


@pytest.mark.parametrize(
    ("core", "level"),
    [("cortex-m0", "-O0"), ("cortex-m0", "-O2"), ("cortex-m3", "-O2"), ("cortex-m4", "-Os"),
     ("cortex-m4", "-O2"), ("riscv32", "-O2")],
)  # fmt: skip
def test_every_core_gives_the_models_bits(functions, core, level, tmp_path):
    for file, text in c_files("cases", list(functions.values())).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "loops.c").write_text(BUFFERS + "".join(map(loop, functions.values())))
    target = core_named(core)
    require_tools(target)
    compiler = [
        *target.compile, "-std=c99", level, *WARNINGS, f"-I{resources.firmware() / 'include'}",
    ]  # fmt: skip
    files = [tmp_path / "cases.c", tmp_path / "loops.c"]
    roots = ["given", "taken", *(f"run_{name}" for name in functions)]
    program = Program(link(compiler, files, roots, tmp_path / "cases.elf"), CORES[core])
    for name, found in functions.items():
        values = drawn(found, ROWS)
        columns = [values[key].reshape(ROWS, -1) for key in dict.fromkeys(values)]
        program.write("given", np.concatenate(columns, axis=1).astype("<i4").tobytes())
        assert program.call(f"run_{name}", (ROWS,), counted=False).result == 0
        expected = [array.reshape(ROWS, -1) for array in found.evaluate(values).values()]
        table = np.concatenate(expected, axis=1)
        taken = np.frombuffer(program.read("taken", 4 * table.size), "<i4")
        np.testing.assert_array_equal(taken.reshape(table.shape), table, name)


PRODUCTS = """
#include <avr/io.h>
#include <avr/sleep.h>
#include "ccgen/kernel16.h"

static volatile int32_t a, b;

static void put(char sign) {
    while (!(UCSR0A & (1 << UDRE0))) {
    }
    UDR0 = (uint8_t)sign;
}

int main(void) {
    static const int32_t ends[] = {0, 1, -1, 0xFFFF, 0x10000, -0x10000, INT32_MAX, INT32_MIN};
    uint32_t drawn = 1;
    uint8_t wrong = 0; /* a bit for each function */
    UCSR0B = 1 << TXEN0;
    for (uint16_t k = 0; k < 1200; ++k) {
        drawn = drawn * 1664525u + 1013904223u;
        a = k % 5 == 0 ? ends[drawn >> 29] : (int32_t)drawn;
        drawn = drawn * 1664525u + 1013904223u;
        b = k % 3 == 0 ? ends[drawn >> 29] : (int32_t)drawn;
        const int32_t half = b >> 16;
        if (ccgen_product_high(a, b) != (int32_t)(((int64_t)a * b) >> 32)) {
            wrong |= 1;
        }
        if (ccgen_product_word(a, half) != (int32_t)(((int64_t)a * half) >> 16)) {
            wrong |= 2;
        }
        if (ccgen_product16(a >> 16, half) != (a >> 16) * half) {
            wrong |= 4;
        }
        if (SHIFTS) {
            wrong |= 8;
        }
        if (ccgen_product_half((a >> 15) | 1, half) != ((a >> 15) | 1) * half) {
            wrong |= 16;
        }
        const uint32_t product = (uint32_t)((a >> 16) * half);
        if (ccgen_add_product16((uint32_t)b, (int16_t)(a >> 16), (int16_t)half) !=
            (uint32_t)b + product) {
            wrong |= 32;
        }
        const ccgen_axis16_t axis = {1, 1, (uint8_t)(drawn >> 27), 0, false, true, 0, NULL, NULL};
        static const ccgen_axis16_t known = {1, 1, 13, 0, false, true, 0, NULL, NULL};
        if (ccgen_steps16(&axis, (uint32_t)a) != a >> axis.shift ||
            ccgen_steps16(&known, (uint32_t)a) != a >> 13) {
            wrong |= 64;
        }
    }
    put(wrong == 0 ? 'A' : 'B');
    put('\\n');
    __asm__("cli");
    sleep_enable();
    sleep_cpu();
}
"""


@pytest.mark.parametrize("plain", [False, True])
def test_products_in_avrs_assembly_have_the_bits_of_plain_c(plain, tmp_path):
    require_tools(core_named("avr"))
    source, program = tmp_path / "products.c", tmp_path / "products.elf"
    shifts = " || ".join(f"ccgen_right(a, {k}) != (a >> {k})" for k in range(32))
    source.write_text(PRODUCTS.replace("SHIFTS", shifts))
    flags = ["-DCCGEN_PLAIN_PRODUCTS"] if plain else []
    include = f"-I{resources.firmware() / 'include'}"
    build = ["avr-gcc", "-mmcu=atmega1284p", "-std=gnu99", "-O2", *WARNINGS, *flags, include]
    subprocess.run([*build, source, "-o", program], check=True)
    assembly = subprocess.run(
        ["avr-objdump", "-d", program], check=True, capture_output=True, text=True
    )
    assert ("ccgen_avr_word" in assembly.stdout) is not plain
    run = ["simavr", "-m", "atmega1284p", "-f", "16000000", str(program)]
    told = subprocess.run(run, check=True, capture_output=True, text=True, timeout=60)
    assert "A." in told.stdout + told.stderr
