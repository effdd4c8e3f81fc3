"""Exact cycles of the calls of a joint on an ATmega, from simavr."""

import subprocess
from itertools import pairwise
from pathlib import Path

from ccgen.can.transports import not_run
from ccgen.cost.instructions import Times
from ccgen.errors import ToolError
from ccgen.resources import template
from ccgen.targets.compiler import compiler, run_compiler

MCU, HERTZ = "atmega1284p", 16_000_000

_EMPTY = (7, 8)


def cycles(program: Path, folder: Path) -> Times:
    """Run the harness's own main.

    Args:
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
    return _times(notes)


def _times(notes: list[tuple[int, int]]) -> Times:
    """Cycles between notes, without those of an empty pair; a snapshot is its frames' sum."""
    spent = [(number, later - cycle) for (number, cycle), (_, later) in pairwise(notes)]
    empty = next(taken for number, taken in spent if number == _EMPTY[0])
    most: dict[int, int] = {}
    snapshots, frames = [0], []
    for number, taken in spent:
        most[number] = max(most.get(number, 0), taken - empty)
        if number in (3, 4):
            snapshots[-1] += taken - empty
        if number == 5:
            frames.append(taken - empty)
            snapshots.append(0)
    return Times(most[1], most[2], max(frames), max(snapshots), unit="cycles")
