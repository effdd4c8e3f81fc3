"""What the tip pose costs on Cortex-M, by four ways of generating it; prints a table.

Counts the instructions of whole calls in an emulated core, exactly, and the bytes of code and
stack; every variant's result is compared with NumPy. The Jacobian of the exported C stands beside.
Needs arm-none-eabi-gcc, unicorn and pyelftools:

    python tests/benchmarks/kinematics_cost.py
"""

import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import unicorn
from elftools.elf.elffile import ELFFile
from unicorn import arm_const

from ccgen import kinematics, resources
from ccgen.export.kinematics_c import advance_function, degrees, kinematics_context
from ccgen.export.literals import float_literal
from ccgen.kinematics.bounds import error_bounds, largest_angle

SEGMENT_LENGTH = 0.02
FRACTION_BITS = {"u": 18, "v": 18}
ANGLE = largest_angle(16, FRACTION_BITS)
CORES = {
    "cortex-m0": (arm_const.UC_CPU_ARM_CORTEX_M0, []),
    "cortex-m3": (arm_const.UC_CPU_ARM_CORTEX_M3, []),
    "cortex-m4": (arm_const.UC_CPU_ARM_CORTEX_M4, ["-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]),
    "cortex-m7": (arm_const.UC_CPU_ARM_CORTEX_M7, ["-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"]),
}
FLASH, RAM, STACK_TOP, RETURN = 0x10000, 0x20000000, 0x20020000, 0x100000

HEADER = """\
#ifndef ARM_H
#define ARM_H
#include <stdint.h>
#define ARM_SEGMENTS {segments}
#define ARM_VALUES (2 * ARM_SEGMENTS)
#define ARM_RADIANS_PER_STEP_U {scale}
#define ARM_RADIANS_PER_STEP_V {scale}
typedef struct {{
    int16_t u[ARM_SEGMENTS], v[ARM_SEGMENTS];
}} arm_angles_t;
#endif
"""

POSE = """\
arm_angles_t angles;
arm_pose_t result;
int run(void) { return arm_tip_pose(&angles, &result); }
"""

JACOBIAN = """\
arm_angles_t angles;
float result[6][2 * ARM_SEGMENTS];
int run(void) { return arm_tip_jacobian(&angles, result); }
"""

PRODUCT = """\
arm_angles_t angles;
float result[12];
int run(void) {
    for (int k = 0; k < 12; ++k) result[k] = k < 9 && k % 4 == 0 ? 1.0f : 0.0f;
    for (int i = 0; i < ARM_SEGMENTS; ++i) {
        const float u = (float)angles.u[i] * ARM_RADIANS_PER_STEP_U;
        const float v = (float)angles.v[i] * ARM_RADIANS_PER_STEP_V;
        const float *arg[2] = {&u, &v};
        float s[12];
        float *res[1] = {s};
        generated(arg, res, 0, 0, 0);
        for (int r = 0; r < 3; ++r) {
            const float x = result[3 * r], y = result[3 * r + 1], z = result[3 * r + 2];
            for (int c = 0; c < 3; ++c) {
                result[3 * r + c] = x * s[c] + y * s[3 + c] + z * s[6 + c];
            }
            result[9 + r] += x * s[9] + y * s[10] + z * s[11];
        }
    }
    return 0;
}
"""

WHOLE = """\
arm_angles_t angles;
float result[12];
int run(void) {{
    float start[12], bends[2 * ARM_SEGMENTS], w[{sz_w} + 1];
    casadi_int iw[{sz_iw} + 1];
    const float *arg[{sz_arg}] = {{start, bends}};
    float *res[{sz_res}] = {{result}};
    for (int k = 0; k < 12; ++k) start[k] = k < 9 && k % 4 == 0 ? 1.0f : 0.0f;
    for (int i = 0; i < ARM_SEGMENTS; ++i) {{
        bends[2 * i] = (float)angles.u[i] * ARM_RADIANS_PER_STEP_U;
        bends[2 * i + 1] = (float)angles.v[i] * ARM_RADIANS_PER_STEP_V;
    }}
    return generated(arg, res, iw, w, 0);
}}
"""


@dataclass(frozen=True)
class Cost:
    """One call: instructions, bytes of code without the compiler's float library, stack, result."""

    instructions: int
    code: int
    stack: int
    result: np.ndarray


def exported(segments: int, caller: str) -> str:
    """The exported C."""
    context = kinematics_context("arm", segments, SEGMENT_LENGTH, 16, FRACTION_BITS)
    axes = {axis: {"axis": axis, "first_value": k * segments} for k, axis in enumerate("uv")}
    values = {
        "name": "arm", "NAME": "ARM", "version": "", "kinematics": context, "axes": axes,
        "columns_said": "",
    }  # fmt: skip
    header, source = (
        resources.template(f"kinematics.{ending}.j2").render(values) for ending in "hc"
    )
    return header + source.replace('#include "arm_kinematics.h"', "") + caller


def as_it_comes(function: Any, caller: str) -> str:
    """CasADi's C of a function named "generated", without the extraction."""
    generator = casadi.CodeGenerator("f.c", {"casadi_real": "float", "casadi_int": "int"})
    generator.add(function)
    return f'#include "arm.h"\n{generator.dump()}\n{caller}'


def step(name: str = "step") -> Any:
    """One segment: (row-major rotation and position, (u, v)) -> the same."""
    pose, bend = casadi.SX.sym("pose", 12), casadi.SX.sym("bend", 2)
    frame = casadi.reshape(pose[:9], 3, 3).T
    rotation, position = advance_function(SEGMENT_LENGTH, degrees(ANGLE))(
        frame, pose[9:], bend[0], bend[1]
    )
    return casadi.Function(name, [pose, bend], [casadi.vertcat(casadi.vec(rotation.T), position)])


def product_loop(segments: int) -> str:
    """A generated segment transform, multiplied up by loops in C."""
    u, v = casadi.SX.sym("u"), casadi.SX.sym("v")
    straight = casadi.DM([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0])
    transform = casadi.densify(step()(straight, casadi.vertcat(u, v)))
    return as_it_comes(casadi.Function("generated", [u, v], [transform]), PRODUCT)


def unrolled(segments: int) -> str:
    """One SX graph of the whole chain."""
    pose, bends = casadi.SX.sym("start", 12), casadi.SX.sym("bends", 2, segments)
    inputs = [pose, bends]
    for i in range(segments):
        pose = step()(pose, bends[:, i])
    return whole(casadi.Function("generated", inputs, [pose]))


def fold(segments: int) -> str:
    """CasADi's own loop."""
    start, bends = casadi.MX.sym("start", 12), casadi.MX.sym("bends", 2, segments)
    pose = step().fold(segments)(start, bends)
    return whole(casadi.Function("generated", [start, bends], [pose]))


def whole(function: Any) -> str:
    """A function of the whole chain with the work memory that it asks for."""
    sizes = {size: getattr(function, size)() for size in ("sz_w", "sz_iw", "sz_arg", "sz_res")}
    return as_it_comes(function, WHOLE.format(**sizes))


VARIANTS: dict[str, Callable[[int], str]] = {
    "C loop, advanced frame (exported)": lambda segments: exported(segments, POSE),
    "C loop, matrix products": product_loop,
    "CasADi, unrolled": unrolled,
    "CasADi, fold": fold,
    "exported Jacobian": lambda segments: exported(segments, JACOBIAN),
}


def build(source: str, segments: int, core: str, folder: Path) -> tuple[ELFFile, int]:
    """Compile and link; return the program and the bytes of its own functions."""
    scale = float_literal(2.0 ** -FRACTION_BITS["u"])
    (folder / "arm.h").write_text(HEADER.format(segments=segments, scale=scale))
    (folder / "main.c").write_text(source)
    options = ["-O2", f"-mcpu={core}", "-mthumb", *CORES[core][1]]
    language = ["-std=c99", "-fsingle-precision-constant", "-ffunction-sections"]
    runtime = f"-I{resources.firmware() / 'include'}"
    gcc = ["arm-none-eabi-gcc", *options]
    subprocess.run([*gcc, *language, runtime, "-c", "main.c"], cwd=folder, check=True)
    link = ["-nostartfiles", "-Wl,--gc-sections,-e,run", f"-Wl,-Ttext={FLASH:#x},-Tbss={RAM:#x}"]
    subprocess.run([*gcc, "main.o", *link, "-o", "main.elf"], cwd=folder, check=True)
    own = functions(ELFFile((folder / "main.o").open("rb")))
    program = ELFFile((folder / "main.elf").open("rb"))
    return program, sum(size for name, size in functions(program).items() if name in own)


def functions(elf: ELFFile) -> dict[str, int]:
    """Sizes of the functions defined in a file."""
    return {
        symbol.name: symbol["st_size"]
        for symbol in elf.get_section_by_name(".symtab").iter_symbols()
        if symbol["st_info"]["type"] == "STT_FUNC" and symbol["st_shndx"] != "SHN_UNDEF"
    }


def measure(source: str, core: str, angles: np.ndarray, outputs: int) -> Cost:
    """Run one call on integer angles, shape (2, segments), in an emulated core."""
    with tempfile.TemporaryDirectory() as folder:
        program, code = build(source, angles.shape[1], core, Path(folder))
        address = {
            s.name: s["st_value"] for s in program.get_section_by_name(".symtab").iter_symbols()
        }
        machine = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        machine.ctl_set_cpu_model(CORES[core][0])
        machine.mem_map(0, 0x200000)
        machine.mem_map(RAM, 0x40000)
        for segment in program.iter_segments("PT_LOAD"):
            machine.mem_write(segment["p_paddr"], segment.data())
    machine.mem_write(address["angles"], angles.astype("<i2").tobytes())
    machine.reg_write(arm_const.UC_ARM_REG_SP, STACK_TOP)
    machine.reg_write(arm_const.UC_ARM_REG_LR, RETURN | 1)
    instructions, lowest = 0, STACK_TOP

    def count(uc: unicorn.Uc, *_: object) -> None:
        nonlocal instructions, lowest
        instructions += 1
        lowest = min(lowest, uc.reg_read(arm_const.UC_ARM_REG_SP))

    machine.hook_add(unicorn.UC_HOOK_CODE, count)
    machine.emu_start(address["run"] | 1, RETURN)
    result = np.frombuffer(machine.mem_read(address["result"], 4 * outputs), "<f4")
    return Cost(instructions, code, STACK_TOP - lowest, result.astype(float))


def check(variant: str, angles: np.ndarray, result: np.ndarray) -> None:
    """Compare with double precision."""
    u, v = angles * 2.0 ** -FRACTION_BITS["u"]
    segments = len(u)
    bounds = error_bounds(segments, segments * SEGMENT_LENGTH, ANGLE)
    if "Jacobian" in variant:
        error = result.reshape(6, -1) - kinematics.tip_jacobian(u, v, SEGMENT_LENGTH)
        bound = bounds.linear + bounds.angular
    else:
        error = result[9:] - kinematics.tip_pose(u, v, SEGMENT_LENGTH)[:3, 3]
        bound = bounds.position
    if np.abs(error).max() > bound:
        raise SystemExit(f"{variant}: off by {np.abs(error).max()}")


def main() -> None:
    """Print the table."""
    print(f"{'':36}{'':>9}" + "".join(f"{core:>25}" for core in CORES))
    print(f"{'variant':36}{'segments':>9}" + f"{'instr.':>11}{'code':>7}{'stack':>7}" * len(CORES))
    for variant, generate in VARIANTS.items():
        for segments in (12, 48):
            angles = np.random.default_rng(1).integers(-(2**15), 2**15, (2, segments))
            outputs = 12 * segments if "Jacobian" in variant else 12
            source = generate(segments)
            row = f"{variant:36}{segments:9}"
            for core in CORES:
                cost = measure(source, core, angles, outputs)
                check(variant, angles, cost.result)
                row += f"{cost.instructions:11,}{cost.code:7,}{cost.stack:7,}"
            print(row, flush=True)


if __name__ == "__main__":
    main()
