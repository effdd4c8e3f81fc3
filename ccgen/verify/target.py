"""Targets by name: the host, or a microcontroller's core in an emulator."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ccgen.errors import require_least
from ccgen.targets.compiler import LEVEL, level_named
from ccgen.targets.cores import HOST, VERIFIED, require_known
from ccgen.targets.exported import Exported, open_exported
from ccgen.verify.emulated import verify_core
from ccgen.verify.host import verify_host
from ccgen.verify.plan import LEAST_VALUES, Plan, Progress, silent
from ccgen.verify.run import Run


@dataclass(frozen=True)
class Verification:
    """What was found on every target that was asked for.

    Attributes:
        runs: a comparison for each target and transport.
        changed: files of the folder that differ from what was exported.
    """

    runs: tuple[Run, ...]
    changed: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether every check held."""
        return all(run.passed for run in self.runs)


def verify(
    directory: str | Path,
    target: str | Sequence[str] = HOST,
    snapshots: int | None = None,
    values: int = LEAST_VALUES,
    optimise: str = "2",
    seed: int = 0,
    report: Progress | None = None,
) -> Verification:
    """Compile a folder, stream counts to it over CAN and compare every angle bit for bit.

    Args:
        directory: a folder that was exported.
        target: one or several of `ccgen.targets.cores.VERIFIED`, or "all".
        snapshots: over each bus; by default as many as the transport has time for.
        values: angles compared in batches, besides.
        optimise: the level of the compiler's optimisation: "0", "s", "2" or "3".
        seed: of the random counts.
        report: called now and then.

    Raises:
        ArgumentError: a value that cannot be. InputError: no exported folder. ToolError: a
            compiler or an emulator is missing, or does not accept the folder.
    """
    named = [target] if isinstance(target, str) else list(target)
    for name in named:
        require_known(name, (*VERIFIED, "all"))
    level = level_named(optimise)
    for argument, least, value in (("snapshots", 1, snapshots), ("values", 1, values)):
        if value is not None:
            require_least(least, argument, value)
    require_least(0, "seed", seed)
    exported = open_exported(Path(directory))
    plan, runs = Plan(snapshots, values, seed), []
    for name in VERIFIED if "all" in named else named:
        runs += verify_target(exported, name, plan, report or silent, level)
    return Verification(tuple(runs), exported.changed)


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
        return verify_host(exported, plan, report, level)
    return verify_core(exported, target, plan, report, level)
