"""The exported example for an AVR with an MCP2515 on the emulated board, at a modelled chip."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
from mcp2515 import OSCILLATOR, Told, frame, run
from runtime_c import HERE
from test_both_ends import Client

from ccgen.targets.exported import open_exported

STRICT = "-Wall -Wextra -Wconversion -Wdouble-promotion -Werror"
FIRST = 20_000
"""Microseconds by which the firmware has started."""


def needs() -> None:
    for program, package in (("avr-gcc", "gcc-avr"), ("avr-nm", "binutils-avr"), ("cmake",) * 2):
        assert shutil.which(program), f"needs {program}; install the Debian package {package}"


def output_of(*command: object, **variables: str) -> str:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False,
        env=os.environ | variables,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def build(folder: Path, out: Path, *options: str) -> Path:
    """Build the example with warnings as errors; gives the firmware."""
    needs()
    project = folder / "examples" / "mcp2515"
    flags = ("-DCMAKE_BUILD_TYPE=MinSizeRel", *options)
    output_of("cmake", "-S", project, "-B", out, *flags, CFLAGS=STRICT)
    output_of("cmake", "--build", out, CFLAGS=STRICT)
    return out / "firmware.elf"


class Board:
    """A folder's example, serving a sensor board's snapshots."""

    def __init__(self, folder: Path, out: Path) -> None:
        self.exported = open_exported(folder)
        self.firmware = build(folder, out / "build", "-DLENGTHS_FROM_BUS=ON")
        symbols = output_of("avr-nm", self.firmware).splitlines()
        (self.address,) = (line.split()[0] for line in symbols if line.split()[2:] == ["can"])
        self.emulator = out / "emulator"
        sources = [HERE / "mcp2515" / f"{stem}.c" for stem in ("chip", "bus", "avr")]
        output_of("gcc", "-std=gnu11", "-O2", *sources, "-lsimavr", "-o", self.emulator)

    @property
    def cycle_us(self) -> int:
        return self.exported.layout.cycle_us

    def counts(self, snapshots: int) -> np.ndarray:
        zero = self.exported.model.readings.zero
        rng = np.random.default_rng(11)
        return zero + rng.integers(-40, 40, (snapshots, len(zero)))

    def time_of(self, snapshot: int) -> int:
        return FIRST + snapshot * self.cycle_us

    def traffic(self, snapshots: int) -> list[str]:
        layout, codec = self.exported.layout, self.exported.codec
        return [
            frame(self.time_of(k), sent.arbitration_id, bytes(sent.data), int(layout.extended))
            for k, row in enumerate(self.counts(snapshots).tolist())
            for sent in codec.encode(row, k % layout.numbers)
        ]

    def run(self, script: list[str], snapshots: int) -> Told:
        rate = self.exported.joint.can.bitrate
        end = [f"end {self.time_of(snapshots) + self.cycle_us // 2}"]
        command = [self.emulator, self.firmware, self.address, str(OSCILLATOR), str(rate)]
        return run(command, [*script, *end])

    def answers(self, told: Told, snapshots: int) -> tuple[set[int], int]:
        """Snapshots that were answered whole, and how many values are not the model's.

        What is sent is decoded with cantools and checked with autosar-e2e.
        """
        client, layout = Client(self.exported.directory), self.exported.layout
        rows, joint = self.counts(snapshots), self.exported.joint
        axes = self.exported.model.axes.items()
        expected = np.hstack([own.estimate(rows[:, joint.own(axis)]) for axis, own in axes])
        columns = [f"{'elongation_' if a == 'h' else 'angle_' + a}{i}"
                   for a, own in axes for i in range(own.segments)]  # fmt: skip
        letter, digits = ("T", 8) if layout.extended else ("t", 3)
        found: dict[int, dict[str, int]] = {}
        wrong = 0
        for sent in told.sent:
            line = f"{letter}{sent.id:0{digits}X}{len(sent.data)}{sent.data.hex()}"
            kind, values = client.decode(line)
            if "_ANGLES" not in kind:
                continue
            number = values["counter"] + 15 * values.get("turn", 0)
            latest = (sent.at - FIRST) // self.cycle_us
            snapshot = latest - (latest - number) % layout.numbers
            for signal, value in values.items():
                if signal in columns:
                    right = 0 <= snapshot < snapshots
                    right = right and expected[snapshot, columns.index(signal)] == value
                    wrong += not right
                    found.setdefault(snapshot, {})[signal] = value
        return {k for k, own in found.items() if len(own) == len(columns)}, wrong
