"""Targets by name: the host, or a microcontroller's core in an emulator."""

from ccgen.targets.compiler import LEVEL
from ccgen.targets.cores import HOST, VERIFIED, require_known
from ccgen.targets.exported import Exported
from ccgen.verify import host
from ccgen.verify.emulated import verify_core
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run


def verify_target(
    exported: Exported, target: str, plan: Plan, report: Progress, level: str = LEVEL
) -> list[Run]:
    """Verify a folder on one target, compiled at a level; a record for each transport.

    Raises:
        ArgumentError: unknown target.
        ToolError: a compiler or an emulator is missing, or does not accept the folder.
    """
    require_known(target, VERIFIED)
    if target == HOST:
        return host.verify(exported, plan, report, level)
    return verify_core(exported, target, plan, report, level)
