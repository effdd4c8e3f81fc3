"""Exact cycles of the calls of a joint on an ATmega, from simavr."""

import subprocess
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from ccgen.can.transports import not_run
from ccgen.cost.harness import FIRST_FUNCTION
from ccgen.cost.instructions import Examined, Spent, Times
from ccgen.errors import ToolError
from ccgen.resources import template
from ccgen.targets.compiler import compiler, run_compiler
from ccgen.targets.exported import Exported

MCU, HERTZ = "atmega1284p", 16_000_000

_ESTIMATE, _TRANSMIT, _WAS_HEALTH = 1, 4, 10
_PARTS = (_ESTIMATE, 2, 3, _TRANSMIT, 5, _WAS_HEALTH)
"""Numbers that the harness notes before an estimate, a tip pose, a frame received, a frame fetched
and a frame received again; and behind a frame that was HEALTH."""

_EMPTY = (7, 8)
_FOLLOW, _EXAMINED, _EXAMINED_FOLLOW = 11, 12, 13
"""Noted before a quiet snapshot is followed, an examined one is estimated, and it is followed."""

_JACOBIAN = 14
"""Noted before the tip Jacobian of a snapshot's angles."""


def cycles(exported: Exported, program: Path, folder: Path) -> Times:
    """Run the harness's own main.

    Args:
        exported: the folder that it is of.
        program: linked for `MCU`.
        folder: for the emulator, which is compiled here.

    Raises:
        ToolError: simavr does not compile or run.
    """
    source, emulator = folder / "cycles.c", folder / "cycles"
    source.write_text(template("cost_cycles.c.j2").render(), encoding="utf-8")
    command = [*compiler(), "-O2", str(source), "-lsimavr", "-o", str(emulator)]
    run_compiler(command, folder, command[0])
    command = [str(emulator), MCU, str(HERTZ), str(program)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    except OSError as error:
        raise ToolError(f"{emulator}: {not_run(emulator, error)}") from error
    words = (line.split() for line in done.stdout.splitlines() if line.startswith("note "))
    notes = [(int(number), int(cycle)) for _, number, cycle in words]
    if done.returncode != 0 or not notes:
        raise ToolError(f"{program.name}: simavr ended with status {done.returncode}")
    return _times(notes, [function.name for function in exported.functions.compiled])


def _times(notes: list[tuple[int, int]], functions: Sequence[str]) -> Times:
    """Cycles between notes, without those of an empty pair."""
    spent = [(number, later - cycle) for (number, cycle), (_, later) in pairwise(notes)]
    empty = next(taken for number, taken in spent if number == _EMPTY[0])
    own = range(FIRST_FUNCTION, FIRST_FUNCTION + len(functions))
    snapshots: list[dict[int, int]] = []
    for place, (number, taken) in enumerate(spent):
        if number == _ESTIMATE:
            snapshots.append(dict.fromkeys((*_PARTS, _FOLLOW, _JACOBIAN, *own), 0))
        if number in (*_PARTS, _FOLLOW, _JACOBIAN, *own):
            is_health = number == _TRANSMIT and notes[place + 2][0] == _WAS_HEALTH
            snapshots[-1][_WAS_HEALTH if is_health else number] += taken - empty
    return Times.of(
        [
            Spent(
                estimate=one[1],
                tip_pose=one[2],
                frame=one[5],
                received=one[3],
                transmit=one[4],
                health=one[_WAS_HEALTH],
                functions={name: one[number] for name, number in zip(functions, own, strict=True)},
                follow=one[_FOLLOW] or None,
                jacobian=one[_JACOBIAN],
            )
            for one in snapshots
        ],
        _examined([(number, taken - empty) for number, taken in spent]),
        unit="cycles",
    )


def _examined(spent: list[tuple[int, int]]) -> list[Examined]:
    found: list[Examined] = []
    for number, taken in spent:
        if number == _EXAMINED:
            found.append(Examined(taken, 0))
        elif number == _EXAMINED_FOLLOW:
            found[-1] = Examined(found[-1].estimate, max(found[-1].follow, taken))
    return found
