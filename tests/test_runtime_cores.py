"""The kernels as compiled for Cortex-M: the same bits as the reference model, instruction counts.

Each core takes another way through kernel16.h: Thumb-1 on the M0, SSAT on the M3, SMLAD and packed
saturation on the M4. The compiled functions run in an emulated core.
"""

import shutil
import subprocess
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import unicorn
from elftools.elf.elffile import ELFFile
from numpy.typing import NDArray
from runtime_c import C99, INCLUDE, WARNINGS
from test_runtime_estimator import CASES, SEGMENTS, Case, functions_of, readings, tables
from unicorn import arm_const

from ccgen.fixedpoint import AxisModel
from ccgen.resources import firmware

COMPILER = "arm-none-eabi-gcc"
MODELS = {
    "cortex-m0": arm_const.UC_CPU_ARM_CORTEX_M0,
    "cortex-m3": arm_const.UC_CPU_ARM_CORTEX_M3,
    "cortex-m4": arm_const.UC_CPU_ARM_CORTEX_M4,
}
LINK = ("-nostartfiles", "-Wl,-Ttext=0x1000", "-Wl,--entry=0x1000")
ZERO, COUNTS, ANGLES, STACK, RETURN = 0x20000000, 0x20001000, 0x20040000, 0x200F0000, 0xFF000


@cache
def build(core: str, source: str, level: str) -> bytes:
    """A program of these functions, linked for a core."""
    assert shutil.which(COMPILER), f"{COMPILER} is missing: apt-get install gcc-arm-none-eabi"
    with TemporaryDirectory() as folder:
        file, out = Path(folder) / "kernels.c", Path(folder) / "kernels.elf"
        file.write_text(source)
        needed = [bits for bits in (16, 32) if f"estimator{bits}.h" in source]
        runtime = [str(firmware() / "src" / f"estimator{bits}.c") for bits in needed]
        command = [
            COMPILER, f"-mcpu={core}", "-mthumb", *C99, *WARNINGS, *INCLUDE, level, *LINK,
            str(file), *runtime, "-lgcc", "-o", str(out),
        ]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return out.read_bytes()


class Core:
    """A program in an emulated core."""

    def __init__(self, core: str, source: str, level: str = "-O2") -> None:
        self.core = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self.core.ctl_set_cpu_model(MODELS[core])
        self.core.mem_map(0, 0x100000)
        self.core.mem_map(0x20000000, 0x100000)
        with TemporaryDirectory() as folder:
            file = Path(folder) / "kernels.elf"
            file.write_bytes(build(core, source, level))
            with file.open("rb") as stream:
                program = ELFFile(stream)
                for segment in program.iter_segments("PT_LOAD"):
                    self.core.mem_write(segment["p_paddr"], segment.data())
                symbols = program.get_section_by_name(".symtab").iter_symbols()
                self.address = {symbol.name: symbol["st_value"] for symbol in symbols}

    def call(self, name: str, *arguments: int) -> int:
        registers = [getattr(arm_const, f"UC_ARM_REG_R{i}") for i in range(4)]
        for register, value in zip(registers, arguments, strict=False):
            self.core.reg_write(register, value)
        self.core.reg_write(arm_const.UC_ARM_REG_SP, STACK)
        self.core.reg_write(arm_const.UC_ARM_REG_LR, RETURN | 1)
        self.core.emu_start(self.address[name] | 1, RETURN)
        result = self.core.reg_read(arm_const.UC_ARM_REG_R0)
        return result - 2**32 if result >= 2**31 else result

    def estimate(
        self, name: str, model: AxisModel, zero: NDArray[np.int64], counts: NDArray[np.int64]
    ) -> tuple[int, NDArray[np.int64]]:
        """Result and angles of a batch of snapshots."""
        kind = np.dtype(f"<i{model.precision // 8}")
        self.core.mem_write(ZERO, zero.astype(kind).tobytes())
        self.core.mem_write(COUNTS, counts.astype(kind).tobytes())
        result = self.call(name, ZERO, COUNTS, len(counts), ANGLES)
        size = len(counts) * model.segments * kind.itemsize
        angles = np.frombuffer(bytes(self.core.mem_read(ANGLES, size)), kind)
        return result, angles.astype(np.int64).reshape(len(counts), -1)

    def instructions(self, name: str, *arguments: int) -> int:
        """Instructions of one call."""
        count = 0

        def step(*_: object) -> None:
            nonlocal count
            count += 1

        hook = self.core.hook_add(unicorn.UC_HOOK_CODE, step)
        self.call(name, *arguments)
        self.core.hook_del(hook)
        return count


NARROW, WIDE = ([case for case in CASES if case.model.precision == bits] for bits in (16, 32))


@pytest.mark.parametrize("level", ["-O0", "-Os", "-O2", "-O3"])
@pytest.mark.parametrize("core", MODELS)
def test_every_core_gives_the_bits_of_the_reference_model(core, level):
    some = [*NARROW, *WIDE[::5]]
    program = Core(core, functions_of(some), level)
    for case in some:
        model = case.model
        counts = readings(model, 30)[-60:]
        corners = readings(model, 0)[:: max(1, 2**model.sensors // 16)]
        counts = np.concatenate([corners, counts])
        for zero in (model.zero, model.minimum, model.maximum):
            result, angles = program.estimate(case.name, model, zero, counts)
            assert result == 0
            np.testing.assert_array_equal(angles, model.estimate(counts, zero), case.name)


def ramp(precision: int, sign: int, shift: int) -> Case:
    """angle = sign * limit + count - zero: reaches every value around a limit."""
    weights = np.full((SEGMENTS, 1), 1 << shift)
    bias = np.full(SEGMENTS, sign * (2 ** (precision - 1) - 1) << shift)
    ends = [np.array([value]) for value in (-50, 50, 0)]
    model = AxisModel("u", precision, weights, bias, shift, 10, *ends, True, 0, 0.0, 0.0)
    return Case("ramp", model)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("precision", "shift"), [(16, 0), (16, 7), (32, 0), (32, 1), (32, 20)])
@pytest.mark.parametrize("core", MODELS)
def test_saturation_is_exact_step_by_step_around_both_limits(core, precision, shift, sign):
    """The most negative value, which means "no reading", must never come out."""
    case = ramp(precision, sign, shift)
    program = Core(core, functions_of([case]))
    for count in range(-5, 6):  # one by one: each snapshot alone must be noticed
        counts = np.array([[count]])
        result, angles = program.estimate("ramp", case.model, case.model.zero, counts)
        assert result == 0
        np.testing.assert_array_equal(angles, case.model.estimate(counts))
        assert int(np.abs(angles).max()) <= case.model.angle_limit


def joint(segments: int, sensors: int, precision: int = 16) -> str:
    """Two axes that are wide and may saturate, as a joint's estimator is generated."""
    random = np.random.default_rng(segments)
    kind, axis_name = f"int{precision}_t", f"ccgen_axis{precision}"
    text = f'#include "ccgen/estimator{precision}.h"\n'
    for axis in "uv":
        ends = [np.full(sensors, value) for value in (-22000, 22000, 0)]
        weights = random.integers(-6000, 6001, (segments, sensors))
        bias = random.integers(-9999, 10000, segments)
        model = AxisModel(axis, precision, weights, bias, 14, 17, *ends, True, 0, 0.0, 0.0)
        text += tables(Case(axis, model))
    return (
        f"{text}typedef struct {{ {kind} u[{sensors}], v[{sensors}]; }} counts_t;\n"
        f"typedef struct {{ {kind} u[{segments}], v[{segments}]; }} angles_t;\n"
        "int estimate(const counts_t *zero, const counts_t *counts, angles_t *angles);\n"
        "int estimate(const counts_t *zero, const counts_t *counts, angles_t *angles) {\n"
        "    if (zero == NULL || counts == NULL || angles == NULL) {\n        return -1;\n    }\n"
        f"    if (!{axis_name}_complete(&u_axis, counts->u) ||\n"
        f"        !{axis_name}_complete(&v_axis, counts->v)) {{\n        return -2;\n    }}\n"
        f"    {axis_name}_evaluate(&u_axis, zero->u, counts->u, angles->u);\n"
        f"    {axis_name}_evaluate(&v_axis, zero->v, counts->v, angles->v);\n    return 0;\n}}\n"
    )


@pytest.mark.parametrize(
    ("core", "segments", "sensors", "precision", "budget"),
    [
        ("cortex-m0", 24, 3, 16, 24), ("cortex-m0", 48, 6, 16, 40),
        ("cortex-m3", 24, 3, 16, 14), ("cortex-m3", 48, 6, 16, 20),
        ("cortex-m4", 24, 3, 16, 10), ("cortex-m4", 48, 6, 16, 12),
        ("cortex-m4", 24, 3, 32, 18), ("cortex-m4", 48, 6, 32, 25),
    ],
)  # fmt: skip
def test_instructions_per_segment_and_axis_stay_within_budget(
    core, segments, sensors, precision, budget
):
    """Of a whole call with checks, at -O2, for a model that is wide and may saturate."""
    program = Core(core, joint(segments, sensors, precision))
    program.core.mem_write(ZERO, bytes(64))
    program.core.mem_write(COUNTS, np.full(2 * sensors, 321, f"<i{precision // 8}").tobytes())
    count = program.instructions("estimate", ZERO, COUNTS, ANGLES)
    assert count / (2 * segments) <= budget


def test_precision_16_needs_no_function_of_the_compilers_library():
    """No 64-bit arithmetic, no division, no float on a Cortex-M0."""
    program = Core("cortex-m0", joint(48, 6))
    helpers = [name for name in program.address if name.startswith("__aeabi")]
    assert helpers == []
