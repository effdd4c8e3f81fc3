"""Instructions per segment and axis of NAME_estimate on Cortex-M, its code and stack.

Counts whole calls exported at -O2, both axes with all checks, exactly, in an emulated core; the
most over shapes, corners of the ranges and drawn readings. Code is all of NAME.c's, used or not;
stack is that of NAME_estimate. Axes are alike, or with sensors at another radius. Needs
arm-none-eabi-gcc, unicorn and pyelftools:

    python tests/benchmarks/estimator_instructions.py
"""

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from ccgen.cost.emulator import CORES, Program
from ccgen.cost.instructions import count
from ccgen.cost.program import compile_measured
from ccgen.cost.stack import read_disassembly, read_frames, worst_case
from ccgen.export.package import export
from ccgen.targets.cores import core_named
from ccgen.targets.exported import Exported, open_exported

JOINTS = ((24, 3, 16), (48, 6, 16), (24, 3, 32), (48, 6, 32))
"""Segments, sensors an axis, precision."""

BUDGETS = {
    ("cortex-m0", 24, 3, 16): 24, ("cortex-m0", 48, 6, 16): 40,
    ("cortex-m3", 24, 3, 16): 14, ("cortex-m3", 48, 6, 16): 20,
    ("cortex-m4", 24, 3, 16): 10, ("cortex-m4", 48, 6, 16): 12,
    ("cortex-m4", 24, 3, 32): 18, ("cortex-m4", 48, 6, 32): 25,
}  # fmt: skip
"""Instructions per segment and axis."""

CMSIS = {
    ("cortex-m0", 24, 3, 16): 119, ("cortex-m0", 48, 6, 16): 124,
    ("cortex-m3", 24, 3, 16): 37, ("cortex-m3", 48, 6, 16): 61,
    ("cortex-m4", 24, 3, 16): 26, ("cortex-m4", 48, 6, 16): 29,
    ("cortex-m4", 24, 3, 32): 24, ("cortex-m4", 48, 6, 32): 34,
}  # fmt: skip
"""The matrix products arm_mat_vec_mult_q15 and _q31 of CMSIS-DSP, counted the same way."""

JOINT = """\
name = "arm"
[geometry]
segments = {segments}
length = 0.96
range_of_motion = 3.0
[sensors]
placement = "heuristic"
count = {sensors}
radius = 0.05
[sensors.v]
radius = {radius}
[sensors.transducer]
bits = {bits}
metres_per_count = {step}
[fixed_point]
precision = {precision}
"""


@dataclass(frozen=True)
class Footprint:
    """Bytes of code and of stack that an estimator takes."""

    code: int
    stack: int


def exported(
    segments: int, sensors: int, precision: int, folder: Path, radius: float = 0.05
) -> Exported:
    """A joint with weights that are fitted, and that saturate beyond its shapes.

    Args:
        radius: of the sensors of axis v; those of u are at 0.05 m.
    """
    bits, step = (16, 5e-6) if precision == 16 else (30, 1e-8)
    values = {"segments": segments, "sensors": sensors, "precision": precision, "radius": radius}
    path = folder / "arm.toml"
    path.write_text(JOINT.format(**values, bits=bits, step=step))
    export(path, folder / "arm")
    return open_exported(folder / "arm")


def instructions(folder: Exported, core: str) -> float:
    """Of one estimate, divided by segments and axes."""
    with tempfile.TemporaryDirectory() as place:
        program = compile_measured(folder, core_named(core), Path(place)).program
        times, _ = count(folder, Program(program, CORES[core]))
    return times.estimate / (2 * folder.joint.geometry.segments)


KEEPING = ("zero", "restore_zero", "restore_model", "check_zero")
"""Functions that read a zero out, check it and take it back: no part of a program without them."""


def footprint(folder: Exported, core: str) -> Footprint:
    """Of the estimator and the capture of its zero; constants and the keeping of zeros apart."""
    name = folder.joint.name
    with tempfile.TemporaryDirectory() as place:
        compiled = compile_measured(folder, core_named(core), Path(place))
        command = ["arm-none-eabi-size", "-A", str(Path(place) / f"{name}.o")]
        listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        kept = {f".text.{name}_{function}" for function in KEEPING}
        lines = (line.split() for line in listing.splitlines() if line.startswith(".text"))
        sections = [words for words in lines if words[0] not in kept]
        functions, frames = read_disassembly(compiled.disassembly), read_frames(Path(place))
        stack, _ = worst_case(f"{name}_estimate", functions, frames)
        return Footprint(code=sum(int(words[1]) for words in sections), stack=stack)


def main() -> None:
    """Print the table."""
    print("instructions per segment and axis of a whole estimate, bytes of code and stack")
    print(f"{'segments':>8}{'sensors':>9}{'bits':>6}  {'axes':<11}{'core':<10}{'counted':>8}"
          f"{'budget':>8}{'CMSIS-DSP':>11}{'code':>7}{'stack':>7}")  # fmt: skip
    for segments, sensors, precision in JOINTS:
        for axes, radius in (("alike", 0.05), ("different", 0.04)):
            with tempfile.TemporaryDirectory() as place:
                folder = exported(segments, sensors, precision, Path(place), radius)
                for core in ("cortex-m0", "cortex-m3", "cortex-m4", "cortex-m7"):
                    key = (core, segments, sensors, precision)
                    budget, other = BUDGETS.get(key, ""), CMSIS.get(key, "")
                    bytes_of = footprint(folder, core)
                    print(f"{segments:8}{sensors:9}{precision:6}  {axes:<11}{core:<10}"
                          f"{instructions(folder, core):8.2f}{budget:>8}{other:>11}"
                          f"{bytes_of.code:7}{bytes_of.stack:7}")  # fmt: skip


if __name__ == "__main__":
    main()
