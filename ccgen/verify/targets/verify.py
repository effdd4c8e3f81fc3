"""Verification on an emulated microcontroller: over its UART, and in batches on the core itself."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import can

from ccgen.can.exchange import Pace
from ccgen.can.transports import WINDOW_MS
from ccgen.errors import ToolError
from ccgen.verify.build import LEVEL
from ccgen.verify.bus import verify_bus
from ccgen.verify.exported import Exported
from ccgen.verify.inputs import bus_counts
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run
from ccgen.verify.targets.batch import compare_batch, run_batch
from ccgen.verify.targets.cross import build, core_named, require_tools
from ccgen.verify.targets.emulator import running_node

UART_SNAPSHOTS = 1_000
"""Snapshots over the UART if the plan names no number."""

_PACE = Pace(in_flight=4, timeout=10.0)
"""A time-out means a lost frame: it must outlast whatever else the host is doing."""


def verify_target(
    exported: Exported, target: str, plan: Plan, report: Progress, level: str = LEVEL
) -> list[Run]:
    """Verify a folder on an emulated core, over its UART and in batches.

    Args:
        exported: the folder.
        target: one of `TARGETS`.
        plan: extent; `UART_SNAPSHOTS` over the UART unless it names a number.
        report: of progress.
        level: of the compiler's optimisation.

    Raises:
        InputError: unknown target.
        ToolError: a tool is missing, or the firmware does not compile or run.
    """
    require_tools(target)
    try:
        printed = run_batch(exported, target, plan, report, (level,))
        batch = compare_batch(exported, target, plan, printed)
        return [verify_uart(exported, target, plan, report, level), batch]
    except ToolError as error:
        raise ToolError(f"{target}: {error}") from error


def verify_uart(
    exported: Exported, target: str, plan: Plan, report: Progress, level: str = LEVEL
) -> Run:
    """Send snapshots over the emulated UART; arguments as for `verify_target`."""
    number = UART_SNAPSHOTS if plan.snapshots is None else plan.snapshots
    counts = bus_counts(exported, number, plan.seed)
    with emulated_node(exported, target, level) as bus:
        return verify_bus(exported, bus, counts, _PACE, report, target, "uart")


@contextmanager
def emulated_node(
    exported: Exported, target: str, level: str = LEVEL, options: Sequence[str] = ()
) -> Iterator[can.BusABC]:
    """Compile the node for a core and run it in an emulator; gives the bus that it is on.

    However the block is left, the emulator is gone afterwards.

    Args:
        exported: the folder.
        target: one of `TARGETS`.
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
