"""Targets by name: the host, or a microcontroller's core in an emulator."""

from ccgen.errors import InputError
from ccgen.verify import host, targets
from ccgen.verify.build import LEVEL
from ccgen.verify.exported import Exported
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run

TARGETS = ("host", *targets.TARGETS)


def verify_target(
    exported: Exported, target: str, plan: Plan, report: Progress, level: str = LEVEL
) -> list[Run]:
    """Verify a folder on one target, compiled at a level; a record for each transport.

    Raises:
        InputError: unknown target.
        ToolError: a compiler or an emulator is missing, or does not accept the folder.
    """
    if target not in TARGETS:
        raise InputError(f"--target {target}: unknown; known: {', '.join(TARGETS)}")
    if target in targets.TARGETS:
        return targets.verify_target(exported, target, plan, report, level)
    return host.verify(exported, plan, report, level)
