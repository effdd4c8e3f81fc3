"""Compiles an exported folder with its harness for a target, as it would be in a product."""

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ccgen.cost.harness import results_of, source
from ccgen.cost.link import link
from ccgen.cost.size import HARNESS
from ccgen.targets.compiler import LEVEL, run_compiler, sources
from ccgen.targets.cores import HOST, Core
from ccgen.targets.exported import Exported

FLAGS = (
    "-std=c99", "-ffunction-sections", "-fdata-sections", "-ffp-contract=off",
    "-fstack-usage",
)  # fmt: skip

_OF_THE_HOST = {HOST: ("-mno-red-zone",)}
"""What a leaf uses below the stack pointer stands in no record of its frame."""

_CALLS = ("estimate", "integer_tip_pose", "node_receive", "node_transmit")

_VARIABLES = ("counts", "frames", "joint", "angles", "pose", "jacobian", "node", "frame")

JACOBIAN = "integer_tip_jacobian"
"""Measured beside the node, which does not call it."""


def calls_of(exported: Exported) -> tuple[str, ...]:
    """Functions that are measured, without the joint's name."""
    return (*_CALLS, *(("follow",) if exported.guarded.groups else ()))


@dataclass(frozen=True)
class Compiled:
    """A linked program.

    Attributes:
        program: the ELF file.
        map: the linker's.
        folder: where the compiler wrote the frames of functions.
        disassembly: what objdump prints of the program.
        state_bytes: size of the node's state, which the caller owns.
    """

    program: Path
    map: Path
    folder: Path
    disassembly: str
    state_bytes: int


def compile_measured(exported: Exported, core: Core, folder: Path, level: str = LEVEL) -> Compiled:
    """Compile every file to an object, and link what the calls need.

    An object is named after its source, the runtime's with a prefix that no joint has.

    Args:
        exported: the folder.
        core: what it is compiled for.
        folder: for objects and program.
        level: of the compiler's optimisation.

    Raises:
        ToolError: the compiler or the linker does not accept the folder.
    """
    joint = exported.joint.name
    main = folder / f"{HARNESS}.c"
    main.write_text(source(exported), encoding="utf-8")
    flags = (*FLAGS, *_OF_THE_HOST.get(core.name, ()))
    compiler = [*core.compile, level, *flags, f"-I{exported.directory.absolute() / 'src'}"]
    objects = []
    for file in (*sources(exported.directory), main):
        prefix = "ccgen_" if file.parent.name == "ccgen" else ""
        objects.append(folder / f"{prefix}{file.stem}.o")
        command = [*compiler, "-c", str(file), "-o", str(objects[-1])]
        run_compiler(command, folder, f"{exported.directory}: {compiler[0]}")
    roots = [
        *(
            f"{joint}_{call}"
            for call in (*calls_of(exported), JACOBIAN, "init", "capture_zero", "node_init")
        ),
        *(f"cost_{variable}" for variable in _VARIABLES),
        *(f"{joint}_{function.name}" for function, _ in results_of(exported)),
        *(one for _, variables in results_of(exported) for one in variables),
    ]
    program = folder / "cost.elf"
    if core.name == "avr":
        kept = [f"-Wl,--undefined={root}" for root in roots]
        mapped = ["-Wl,--gc-sections", "-Xlinker", f"-Map={program.with_suffix('.map')}"]
        command = [*compiler, *map(str, objects), *kept, *mapped, "-o", str(program)]
        run_compiler(command, folder, f"{exported.directory}: {compiler[0]}")
    else:
        extra = core.link if core.name == HOST else ()
        link([*compiler, *extra], objects, roots, program)
    return Compiled(
        program=program,
        map=program.with_suffix(".map"),
        folder=folder,
        disassembly=_output([core.binutils("objdump"), "-d", str(program)]),
        state_bytes=_size_of("cost_node", _output([core.binutils("nm"), "-S", str(program)])),
    )


def _output(command: Sequence[str]) -> str:
    done = subprocess.run(
        command, capture_output=True, encoding="utf-8", errors="replace", check=True
    )
    return done.stdout


def _size_of(symbol: str, listing: str) -> int:
    lines = (line.split() for line in listing.splitlines())
    return next(int(words[1], 16) for words in lines if words[-1] == symbol)
