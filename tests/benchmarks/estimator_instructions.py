"""Instructions per segment and axis of NAME_estimate on Cortex-M, beside their budgets.

Counts whole calls exported at -O2, both axes with all checks, exactly, in an emulated core; the
most over shapes, corners of the ranges and drawn readings. Needs arm-none-eabi-gcc, unicorn and
pyelftools:

    python tests/benchmarks/estimator_instructions.py
"""

import tempfile
from pathlib import Path

from ccgen.cost.build import build
from ccgen.cost.emulator import CORES, Program
from ccgen.cost.instructions import count_estimates
from ccgen.cost.size import read_map
from ccgen.export.package import export
from ccgen.verify.exported import Exported, open_exported
from ccgen.verify.targets import cross

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
[sensors.transducer]
bits = {bits}
metres_per_count = {step}
[fixed_point]
precision = {precision}
"""


def exported(segments: int, sensors: int, precision: int, folder: Path) -> Exported:
    """A joint with weights that are fitted, and that saturate beyond its shapes."""
    bits, step = (16, 5e-6) if precision == 16 else (30, 1e-8)
    values = {"segments": segments, "sensors": sensors, "precision": precision}
    path = folder / "arm.toml"
    path.write_text(JOINT.format(**values, bits=bits, step=step))
    export(path, folder / "arm")
    return open_exported(folder / "arm")


def instructions(folder: Exported, core: str) -> float:
    """Of one estimate, divided by segments and axes."""
    with tempfile.TemporaryDirectory() as place:
        program = build(folder, cross.core_named(core), Path(place)).program
        counted = count_estimates(folder, Program(program, CORES[core]))
    return counted / (2 * folder.joint.geometry.segments)


def code_bytes(folder: Exported, core: str) -> int:
    """Of the estimator's own code."""
    with tempfile.TemporaryDirectory() as place:
        built = build(folder, cross.core_named(core), Path(place))
        return read_map(built.map, folder.joint.name)["estimator"].code


def main() -> None:
    """Print the table."""
    print("instructions per segment and axis of a whole estimate")
    print(f"{'segments':>8}{'sensors':>9}{'bits':>6}  {'core':<10}{'counted':>8}{'budget':>8}"
          f"{'CMSIS-DSP':>11}{'code bytes':>12}")  # fmt: skip
    for segments, sensors, precision in JOINTS:
        with tempfile.TemporaryDirectory() as place:
            folder = exported(segments, sensors, precision, Path(place))
            for core in ("cortex-m0", "cortex-m3", "cortex-m4", "cortex-m7"):
                key = (core, segments, sensors, precision)
                budget, other = BUDGETS.get(key, ""), CMSIS.get(key, "")
                print(f"{segments:8}{sensors:9}{precision:6}  {core:<10}"
                      f"{instructions(folder, core):8.2f}{budget:>8}{other:>11}"
                      f"{code_bytes(folder, core):12}")  # fmt: skip


if __name__ == "__main__":
    main()
