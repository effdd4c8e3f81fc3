"""An exported node on an emulated microcontroller."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import can

from ccgen.can.transports import WINDOW_MS
from ccgen.targets.build import LEVEL
from ccgen.targets.cores import build, core_named, require_tools
from ccgen.targets.emulator import running_node
from ccgen.targets.exported import Exported


@contextmanager
def emulated_node(
    exported: Exported, target: str, level: str = LEVEL, options: Sequence[str] = ()
) -> Iterator[can.BusABC]:
    """Compile the node for a core and run it in an emulator; gives the bus that it is on.

    However the block is left, the emulator is gone afterwards.

    Args:
        exported: the folder.
        target: one of `CORES`.
        level: of the compiler's optimisation.
        options: further flags for the compiler.

    Raises:
        InputError: unknown target.
        ToolError: a tool is missing, or the firmware does not compile, start or stay alive.
    """
    require_tools(target)
    core = core_named(target)
    flags = (level, f"-DPORT_WINDOW_US={1000 * WINDOW_MS}u", *options)
    with tempfile.TemporaryDirectory() as name:
        out = Path(name)
        program = build(exported.directory, core, "node", out, flags)
        with running_node(core.emulate(program, exported.directory / "ports", out)) as bus:
            yield bus
