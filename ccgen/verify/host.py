"""Verifies a folder on this machine, over each transport in turn."""

import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import can

from ccgen.can.exchange import Pace
from ccgen.can.transports.library import library_node
from ccgen.can.transports.process import process_node
from ccgen.can.transports.terminal import has_terminals
from ccgen.targets.compiler import LEVEL
from ccgen.targets.exported import Exported
from ccgen.targets.host import compile_process, compile_shared
from ccgen.targets.inputs import bus_counts
from ccgen.targets.library import JointLibrary
from ccgen.verify.batch import compare_batches
from ccgen.verify.bus import verify_bus
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run


def verify_host(exported: Exported, plan: Plan, report: Progress, level: str = LEVEL) -> list[Run]:
    """Batches through the shared library, then both buses; a record each.

    The node as a process of its own is left out where there are no pseudo-terminals for its line.

    Args:
        exported: the folder.
        plan: extent.
        report: of progress.
        level: of the compiler's optimisation.

    Raises:
        ToolError: no compiler, or it does not accept the folder.
    """
    counts = bus_counts(exported, plan.bus_snapshots(exported.model.values), plan.seed)
    runs = []
    with tempfile.TemporaryDirectory(prefix="ccgen-") as folder:
        shared = compile_shared(exported.directory, Path(folder), level)
        library = JointLibrary(shared, exported.model)
        runs.append(compare_batches(exported, library, plan, report))
        nodes: dict[str, Callable[[], AbstractContextManager[can.BusABC]]] = {
            "virtual": lambda: library_node(shared, exported.layout)
        }
        if has_terminals():
            program = compile_process(exported.directory, Path(folder), level)
            nodes["slcan-pty"] = lambda: process_node(program)
        for transport, node in nodes.items():
            with node() as bus:
                runs.append(verify_bus(exported, bus, counts, Pace(), report, "host", transport))
    return runs
