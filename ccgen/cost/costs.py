"""What an exported folder costs on several targets: those named, or those that can be measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.errors import ToolError
from ccgen.targets.compiler import level_named
from ccgen.targets.cores import COUNTED, core_named, missing_tools
from ccgen.targets.exported import Exported, open_exported

if TYPE_CHECKING:
    from ccgen.cost.measure import Cost

Report = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


@dataclass(frozen=True)
class Choice:
    """Targets to measure.

    Attributes:
        measured: their names.
        left_out: names of the others, with what each would need.
    """

    measured: tuple[str, ...]
    left_out: dict[str, str]


@dataclass(frozen=True)
class Costs:
    """What a folder costs.

    Attributes:
        targets: the cost on each target.
        left_out: targets that were not named and are not measured, with what each would need.
    """

    targets: "tuple[Cost, ...]"
    left_out: dict[str, str] = field(default_factory=dict)


def cost(
    directory: str | Path,
    target: str | Sequence[str] | None = None,
    optimise: str = "2",
    write: bool = False,
    report: Report | None = None,
) -> Costs:
    """Tell what a folder costs on each target: compiled for it, and counted exactly.

    Args:
        directory: a folder that was exported.
        target: one or several of `ccgen.targets.cores.COUNTED`; by default all whose tools are
            installed.
        optimise: the level of the compiler's optimisation: "0", "s", "2" or "3".
        write: whether to put the table into the folder's README.md.
        report: called before each target.

    Raises:
        ArgumentError: an unknown target or level. InputError: no exported folder. ToolError: a
            tool is missing or does not accept the folder. CheckError: no bound of the stack can be
            given, or a call fails.
    """
    level = level_named(optimise)
    choice = choose([target] if isinstance(target, str) else target)
    exported = open_exported(Path(directory))
    costs = Costs(measure_all(exported, choice.measured, level, report), choice.left_out)
    if write:
        from ccgen.cost.readme import write_table

        write_table(exported, costs.targets)
    return costs


def choose(named: Sequence[str] | None = None) -> Choice:
    """Choose the targets that are named, or all whose tools are installed.

    Raises:
        ArgumentError: unknown target.
        ToolError: what counts, or a tool of a named target, is missing; or no target is left.
    """
    _require_counter()
    measured, left_out = [], {}
    for name in dict.fromkeys(named or COUNTED):
        missing = " ".join(missing_tools(core_named(name, COUNTED), to_run=False))
        message = f"{name}: needs {missing}; install with `apt-get install {missing}`"
        if not missing:
            measured.append(name)
        elif named:
            raise ToolError(message)
        else:
            left_out[name] = message
    if not measured:
        reasons = "; ".join(left_out.values())
        raise ToolError(f"no target is left to measure: {reasons}")
    return Choice(tuple(measured), left_out)


def measure_all(
    exported: Exported, targets: Sequence[str], level: str, report: Report | None = None
) -> "tuple[Cost, ...]":
    """Costs on some targets, as `ccgen.cost.measure.measure`."""
    from ccgen.cost.measure import measure

    costs: list[Cost] = []
    for target in targets:
        if report is not None:
            report("targets", len(costs), len(targets))
        costs.append(measure(exported, target, level))
    return tuple(costs)


def _require_counter() -> None:
    """Make sure that what counts is installed.

    Raises:
        ToolError: it is not.
    """
    for module in ("unicorn", "elftools"):
        try:
            import_module(module)
        except ImportError as error:
            raise ToolError(
                f"counting needs {module}; install it with `pip install 'ccgen[cost]'`"
            ) from error
