"""The kernels as compiled for each core: the bits of the reference model, instruction budgets."""

import subprocess

import numpy as np
import pytest
from benchmarks.estimator_instructions import BUDGETS, JOINTS, exported, instructions
from test_runtime_estimator import (
    CASES,
    RAMPS,
    Case,
    every_count,
    function,
    functions_of,
    readings,
    tables,
)

from ccgen import resources
from ccgen.cost.emulator import CORES, Program
from ccgen.cost.link import link
from ccgen.targets.compiler import WARNINGS, run_compiler
from ccgen.targets.cores import core_named, require_tools

BUILDS = [
    *(("cortex-m0", level) for level in ("-O0", "-Os", "-O2")),
    ("cortex-m3", "-O2"),
    *(("cortex-m4", level) for level in ("-Os", "-O2")),
    ("riscv32", "-O2"),
]
BUFFERS = """
int32_t zero[16], counts[400 * 16], angles[400 * 10];
"""


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    path = tmp_path_factory.mktemp("kernels") / "kernels.c"
    path.write_text(functions_of(CASES) + BUFFERS)
    return path


@pytest.mark.parametrize(("core", "level"), BUILDS)
def test_angles_equal_the_reference_model_on_every_core(source, core, level, tmp_path):
    program = build(source, core, level, tmp_path, [case.name for case in CASES])
    for case in CASES[::4] if level == "-O0" else CASES:
        model = case.model
        kind = f"<i{model.precision // 8}"
        counts = readings(model, 40)
        program.write("counts", counts.astype(kind).tobytes())
        for zero in (model.zero, model.ranges.zeros.minimum, model.ranges.zeros.maximum):
            program.write("zero", zero.astype(kind).tobytes())
            arguments = ("zero", "counts", len(counts), "angles")
            assert program.call(case.name, arguments, counted=False).result == 0
            size = len(counts) * model.segments * model.precision // 8
            angles = np.frombuffer(program.read("angles", size), kind)
            expected = model.estimate(counts, zero)
            np.testing.assert_array_equal(angles.reshape(expected.shape), expected, case.name)


def with_shift_at_run_time(case: Case) -> str:
    """The case as exported where it shares its code with an axis of another shift."""
    name, shift = case.name, case.model.shift
    *constants, axis = tables(case).splitlines(keepends=True)
    known = f"{{{case.model.segments}, {case.model.sensors}, {shift},"
    assert known in axis
    late = axis.replace(known, known.replace(f" {shift},", f" {name}_shift,"))
    start = "    int result = 0;\n"
    body = function(case).replace(start, f"    {late.removeprefix('static ')}{start}")
    return f"{''.join(constants)}static const volatile uint8_t {name}_shift = {shift};\n{body}"


@pytest.mark.parametrize("level", ["-O0", "-Os", "-O2"])
def test_a_shift_that_is_read_at_run_time_gives_the_same_bits_on_cortex_m0(level, tmp_path):
    some = [case for case in (*CASES, *RAMPS) if case.model.precision == 16]
    source = tmp_path / "late.c"
    include = '#include "ccgen/estimator16.h"\n#include "ccgen/sensors16.h"\n'
    source.write_text(include + "".join(map(with_shift_at_run_time, some)) + BUFFERS)
    program = build(source, "cortex-m0", level, tmp_path, [case.name for case in some])
    for case in some[::4] if level == "-O0" else some:
        model = case.model
        counts = every_count(model) if case in RAMPS else readings(model, 20)
        program.write("zero", model.zero.astype("<i2").tobytes())
        program.write("counts", counts.astype("<i2").tobytes())
        arguments = ("zero", "counts", len(counts), "angles")
        assert program.call(case.name, arguments, counted=False).result == 0
        expected = model.estimate(counts, model.zero)
        angles = np.frombuffer(program.read("angles", 2 * expected.size), "<i2")
        np.testing.assert_array_equal(angles.reshape(expected.shape), expected, case.name)


def build(source, core, level, folder, names):
    target = core_named(core)
    require_tools(target)
    compiler = [
        *target.compile, "-std=c99", level, *WARNINGS, "-Wno-missing-prototypes",
        f"-I{resources.firmware() / 'include'}", "-ffunction-sections", "-fdata-sections",
    ]  # fmt: skip
    roots = [*names, "zero", "counts", "angles"]
    return Program(link(compiler, [source], roots, folder / "kernels.elf"), CORES[core])


@pytest.mark.parametrize("core", ["cortex-m0", "cortex-m3", "cortex-m4", "riscv32"])
def test_saturation_is_exact_step_by_step_around_both_limits(core, tmp_path):
    """The most negative value, which means "no reading", must never come out."""
    source = tmp_path / "ramps.c"
    source.write_text(functions_of(RAMPS) + BUFFERS)
    program = build(source, core, "-O2", tmp_path, [case.name for case in RAMPS])
    program.write("zero", bytes(4))
    for case in RAMPS:
        counts = every_count(case.model)
        kind = f"<i{case.model.precision // 8}"
        program.write("counts", counts.astype(kind).tobytes())
        arguments = ("zero", "counts", len(counts), "angles")
        assert program.call(case.name, arguments, counted=False).result == 0
        size = len(counts) * 8 * case.model.precision // 8
        angles = np.frombuffer(program.read("angles", size), kind).reshape(-1, 8)
        np.testing.assert_array_equal(angles, case.model.estimate(counts), case.name)
        assert int(np.abs(angles.astype(np.int64)).max()) >= case.model.angle_limit - 1


@pytest.fixture(scope="module", params=JOINTS, ids=str)
def joint(request, tmp_path_factory):
    return request.param, exported(*request.param, tmp_path_factory.mktemp("joint"))


def test_instructions_stay_within_budget(joint):
    """Of a whole call with its checks, saturating readings included."""
    (segments, sensors, precision), folder = joint
    for (core, *form), budget in BUDGETS.items():
        if tuple(form) == (segments, sensors, precision):
            assert instructions(folder, core) <= budget, core


def test_the_estimator_of_precision_16_needs_no_arithmetic_from_a_library(joint, tmp_path):
    """No 64-bit arithmetic, no division, no float on a Cortex-M0."""
    (_, _, precision), folder = joint
    source = folder.directory / "src" / f"{folder.joint.name}.c"
    target = tmp_path / "estimator.o"
    include = f"-I{folder.directory / 'src'}"
    compiler = [*core_named("cortex-m0").compile, "-O2", include]
    run_compiler([*compiler, "-c", str(source), "-o", str(target)], tmp_path, compiler[0])
    command = ["arm-none-eabi-nm", "-u", str(target)]
    needed = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    helpers = [symbol for symbol in needed if symbol.startswith("__")]
    assert helpers == ([] if precision == 16 else ["__aeabi_lmul"])
