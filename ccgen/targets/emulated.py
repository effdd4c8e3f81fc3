"""An exported node on an emulated microcontroller."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import can

from ccgen.targets.compiler import LEVEL
from ccgen.targets.cores import core_named, require_tools
from ccgen.targets.emulator import running_node
from ccgen.targets.exported import Exported
from ccgen.targets.firmware import compile_firmware


@contextmanager
def emulated_node(
    exported: Exported, target: str, level: str = LEVEL, options: Sequence[str] = ()
) -> Iterator[can.BusABC]:
    """Compile the node for a core and run it in an emulator; gives the bus that it is on.

    It is patient: its clock runs slower than the emulator's, and a snapshot has the widest window.
    However the block is left, the emulator is gone afterwards.

    Args:
        exported: the folder.
        target: one of `MICROCONTROLLERS`.
        level: of the compiler's optimisation.
        options: further flags for the compiler.

    Raises:
        ArgumentError: unknown target.
        ToolError: a tool is missing, or the firmware does not compile, start or stay alive.
    """
    core = core_named(target)
    require_tools(core)
    flags = (level, "-DPORT_PATIENT=1", *options)
    with tempfile.TemporaryDirectory() as name:
        out = Path(name)
        program = compile_firmware(exported.directory, core, "node", out, flags)
        with running_node(core.emulate(program, exported.directory / "ports", out)) as bus:
            yield bus
