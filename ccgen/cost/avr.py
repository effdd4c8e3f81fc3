"""Exact cycles of the calls of a joint on an ATmega, from simavr."""

import subprocess
from itertools import pairwise
from pathlib import Path

from ccgen.cost.instructions import Times
from ccgen.errors import ToolError
from ccgen.targets.compiler import compiler, run_compiler

MCU, HERTZ = "atmega1284p", 16_000_000

EMULATOR = r"""
#include <simavr/avr_ioport.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_io.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static void note(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *unused) {
    (void)unused;
    avr->data[address] = value;
    printf("note %u %llu\n", (unsigned)value, (unsigned long long)avr->cycle);
}

int main(int count, char **arguments) {
    static elf_firmware_t firmware;
    avr_t *avr = count == 4 ? avr_make_mcu_by_name(arguments[1]) : NULL;
    if (avr == NULL || elf_read_firmware(arguments[3], &firmware) != 0) {
        return 2;
    }
    avr_init(avr);
    avr->log = LOG_NONE;
    firmware.frequency = (uint32_t)atol(arguments[2]);
    avr_load_firmware(avr, &firmware);
    avr_register_io_write(avr, 0x3E, note, NULL);
    int state = cpu_Running;
    while (state != cpu_Done && state != cpu_Crashed) {
        state = avr_run(avr);
    }
    return state == cpu_Crashed ? 3 : 0;
}
"""
"""Runs a program and prints number and cycle whenever it writes GPIOR0."""

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
    source.write_text(EMULATOR, encoding="utf-8")
    command = [*compiler(), "-O2", str(source), "-lsimavr", "-o", str(emulator)]
    run_compiler(command, folder, command[0])
    command = [str(emulator), MCU, str(HERTZ), str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
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
