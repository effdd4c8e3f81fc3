"""Verification on an emulated microcontroller: over its UART, and in batches on the core itself."""

from ccgen.can.exchange import Pace
from ccgen.errors import ToolError
from ccgen.targets.compiler import LEVEL
from ccgen.targets.cores import core_named, require_tools
from ccgen.targets.emulated import emulated_node
from ccgen.targets.exported import Exported
from ccgen.targets.inputs import bus_counts
from ccgen.verify.bus import verify_bus
from ccgen.verify.on_core import compare_batch, run_batch
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run

UART_SNAPSHOTS = 1_000
"""Snapshots over the UART if the plan names no number."""

_PACE = Pace(in_flight=4, timeout=10.0)
"""A time-out means a lost frame: it must outlast whatever else the host is doing."""


def verify_core(
    exported: Exported, target: str, plan: Plan, report: Progress, level: str = LEVEL
) -> list[Run]:
    """Verify a folder on an emulated core, over its UART and in batches.

    Args:
        exported: the folder.
        target: one of `ccgen.targets.cores.MICROCONTROLLERS`.
        plan: extent; `UART_SNAPSHOTS` over the UART unless it names a number.
        report: of progress.
        level: of the compiler's optimisation.

    Raises:
        ArgumentError: unknown target.
        ToolError: a tool is missing, or the firmware does not compile or run.
    """
    require_tools(core_named(target))
    try:
        printed = run_batch(exported, target, plan, report, (level,))
        batch = compare_batch(exported, target, plan, printed)
        return [verify_uart(exported, target, plan, report, level), batch]
    except ToolError as error:
        raise ToolError(f"{target}: {error}") from error


def verify_uart(
    exported: Exported, target: str, plan: Plan, report: Progress, level: str = LEVEL
) -> Run:
    """Send snapshots over the emulated UART; arguments as for `verify_core`."""
    number = UART_SNAPSHOTS if plan.snapshots is None else plan.snapshots
    counts = bus_counts(exported, number, plan.seed)
    with emulated_node(exported, target, level) as bus:
        return verify_bus(exported, bus, counts, _PACE, report, target, "uart")
