"""What the variants of the estimator's kernels earn beside plain C, on each core.

Instructions (on AVR cycles) of a whole NAME_estimate per segment and axis, all checks included, the
most over the snapshots that `ccgen cost` counts, and bytes of code of NAME.c, both at -O2. Variants
are the exported headers with one thing switched off; plain C is a loop over segments with a loop
over sensors, in their place. All give the same angles, which is checked here. Needs the
cross-compilers, simavr, unicorn and pyelftools:

    python tests/benchmarks/kernels.py
"""

import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from estimator_instructions import JOINTS, KEEPING, exported

from ccgen.cost.avr import cycles
from ccgen.cost.emulator import CORES, Program
from ccgen.cost.instructions import count
from ccgen.cost.program import compile_measured
from ccgen.targets.cores import core_named
from ccgen.targets.exported import Exported, open_exported

PLAIN16 = """\
typedef int16_t __attribute__((may_alias)) weight_t;
CCGEN_INLINE void ccgen_evaluate16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                   const int16_t *const counts, const bool narrow,
                                   int16_t *const angles) {
    const weight_t *row = (const weight_t *)axis->rows;
    (void)narrow;
    for (uint16_t i = 0; i < axis->segments; ++i) {
        int32_t sum = axis->bias + (axis->biases == NULL ? 0 : axis->biases[i]);
        for (uint8_t j = 0; j < axis->sensors; ++j) {
            sum += row[j] * ((int32_t)counts[j] - zero[j]);
        }
        sum >>= axis->shift;
        sum = sum > 32767 ? 32767 : sum < -32767 ? -32767 : sum;
        angles[i] = (int16_t)sum;
        row += 2u * ccgen_words16(axis);
    }
}
"""

PLAIN32 = """\
CCGEN_INLINE void ccgen_axis32_segments(const ccgen_axis32_t *const axis,
                                        const ccgen_factors32_t *const factors,
                                        int32_t *const angles) {
    const int32_t *row = axis->weights;
    for (uint16_t i = 0; i < axis->segments; ++i) {
        int64_t sum = axis->bias + (axis->biases == NULL ? 0 : axis->biases[i]);
        for (uint8_t j = 0; j < axis->sensors; ++j) {
            sum += (int64_t)row[j] * factors->difference[j];
        }
        sum >>= axis->shift;
        sum = sum > INT32_MAX ? INT32_MAX : sum < -INT32_MAX ? -INT32_MAX : sum;
        angles[i] = (int32_t)sum;
        row += axis->sensors;
    }
}
"""


@dataclass(frozen=True)
class Edit:
    """A piece of a header and what stands in its place; to the end of a function if `whole`."""

    header: str
    old: str
    new: str
    whole: bool = False

    def apply(self, folder: Path) -> None:
        """Change the header of an exported folder."""
        path = folder / "src" / "ccgen" / self.header
        text = path.read_text()
        assert text.count(self.old) == 1, f"{self.header}: {self.old}"
        start = text.index(self.old)
        end = text.index("\n}\n", start) + 3 if self.whole else start + len(self.old)
        path.write_text(text[:start] + self.new + text[end:])


HALVES = Edit("axis16.h", "#define CCGEN_HALVES 0", "#define CCGEN_HALVES 1")
COMBINED = Edit("axis16.h", "#define CCGEN_HALVES 1", "#define CCGEN_HALVES 0")
NO_LOOP = Edit(
    "kernel16_thumb1.h", "#define CCGEN_HAS_THUMB1_LOOP 1", "#define CCGEN_HAS_THUMB1_LOOP 0"
)
NO_LOAD = Edit("load.h", "#define CCGEN_HAS_THUMB2_LOAD 1", "#define CCGEN_HAS_THUMB2_LOAD 0")
NO_HIDING = Edit(
    "load.h", '#define CCGEN_OPAQUE(value) __asm__("" : "+r"(value))', "#define CCGEN_OPAQUE(value)"
)
ONE_A_TURN = Edit(
    "load.h",
    "const uint16_t most = CCGEN_SMALL ? small : 4u;",
    "const uint16_t most = small > 0u ? 1u : 0u;",
)
NO_ASSEMBLY = Edit("product.h", "#define CCGEN_AVR_PRODUCTS 1", "#define CCGEN_AVR_PRODUCTS 0")
LOOP16 = Edit("kernel16.h", "CCGEN_INLINE void ccgen_evaluate16(", PLAIN16, whole=True)
LOOP32 = Edit("kernel32.h", "CCGEN_INLINE void ccgen_axis32_segments(", PLAIN32, whole=True)

ALL = ("cortex-m0", "cortex-m3", "cortex-m4", "riscv32", "avr")
PAIRED = ("cortex-m0", "cortex-m3", "riscv32")
"""Cores on which two weights make a combined word."""

VARIANTS: tuple[tuple[int, str, tuple[str, ...], tuple[Edit, ...]], ...] = (
    (16, "plain C", PAIRED, (LOOP16, HALVES)),
    (16, "plain C", ("cortex-m4", "avr"), (LOOP16,)),
    (16, "as exported", ALL, ()),
    (16, "kernel16.h for the loop of _thumb1.h", ("cortex-m0",), (NO_LOOP,)),
    (16, "halves for combined pairs", PAIRED, (HALVES,)),
    (16, "combined pairs for halves", ("cortex-m4", "avr"), (COMBINED,)),
    (16, "no loads in assembly", ("cortex-m3", "cortex-m4"), (NO_LOAD,)),
    (16, "nothing hidden from the compiler", ("cortex-m3", "cortex-m4"), (NO_HIDING,)),
    (16, "one segment a turn", ("cortex-m0", "cortex-m3", "cortex-m4", "riscv32"), (ONE_A_TURN,)),
    (16, "no products in assembly", ("avr",), (NO_ASSEMBLY,)),
    (32, "plain C", ("cortex-m3", "cortex-m4", "riscv32"), (LOOP32,)),
    (32, "as exported", ("cortex-m3", "cortex-m4", "riscv32"), ()),
    (32, "no loads in assembly", ("cortex-m3", "cortex-m4"), (NO_LOAD,)),
    (32, "one segment a turn", ("cortex-m3", "cortex-m4", "riscv32"), (ONE_A_TURN,)),
)
"""Precision, name, cores and changes of the exported headers."""


@dataclass(frozen=True)
class Figures:
    """Of one variant on one core; `angles` are the last snapshot's, empty on AVR."""

    instructions: float
    code: int
    angles: bytes


def measured(folder: Exported, core: str) -> Figures:
    """Compile a folder, and count."""
    with tempfile.TemporaryDirectory() as place:
        program = compile_measured(folder, core_named(core), Path(place)).program
        code = code_bytes(folder, core, Path(place))
        if core == "avr":
            estimate, angles = cycles(folder, program, Path(place)).estimate, b""
        else:
            emulated = Program(program, CORES[core])
            estimate = count(folder, emulated)[0].estimate
            angles = emulated.read("cost_angles", emulated.size("cost_angles"))
    return Figures(estimate / (2 * folder.joint.geometry.segments), code, angles)


def code_bytes(folder: Exported, core: str, place: Path) -> int:
    """Of the estimator and the capture of its zero; constants and the keeping of zeros apart."""
    name = folder.joint.name
    command = [core_named(core).binutils("size"), "-A", str(place / f"{name}.o")]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    kept = {f".text.{name}_{function}" for function in KEEPING}
    lines = (line.split() for line in listing.splitlines() if line.startswith(".text"))
    return sum(int(words[1]) for words in lines if words[0] not in kept)


def changed(folder: Exported, edits: tuple[Edit, ...], place: Path) -> Exported:
    """A copy of an exported folder with changed headers."""
    copy = place / "changed"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder.directory, copy)
    for edit in edits:
        edit.apply(copy)
    return open_exported(copy)


def table(precision: int, show: Callable[[str], None]) -> None:
    """Print the variants of one precision."""
    joints = [joint for joint in JOINTS if joint[2] == precision]
    with tempfile.TemporaryDirectory() as place:
        folders = []
        for segments, sensors, bits in joints:
            own = Path(place) / f"{segments}"
            own.mkdir()
            folders.append(exported(segments, sensors, bits, own))
        for core in ALL:
            expected: dict[int, bytes] = {}
            rows = [row for row in VARIANTS if row[0] == precision and core in row[2]]
            for _, name, _, edits in sorted(rows, key=lambda row: row[1] != "as exported"):
                columns = ""
                for number, folder in enumerate(folders):
                    found = measured(changed(folder, edits, Path(place)), core)
                    same = expected.setdefault(number, found.angles) == found.angles
                    assert same, f"{core}, {name}: other angles"
                    columns += f"{found.instructions:9.1f}{found.code:7}"
                show(f"{core:<11}{name:<38}{columns}")


def main() -> None:
    """Print the table."""
    for precision in (16, 32):
        print(f"\n{precision} bit: per segment and axis, and bytes of code; "
              "24 segments with 3 sensors, 48 with 6")  # fmt: skip
        table(precision, lambda line: print(line, flush=True))


if __name__ == "__main__":
    main()
