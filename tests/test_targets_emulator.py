"""Emulators start, end, and never stay behind; the ports lose nothing when they are flooded."""

import os
import select
import shutil
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from joint_files import joint_text
from processes import children
from typer.testing import CliRunner
from waiting import PATIENCE

from ccgen.can.exchange import Pace, exchange
from ccgen.cli.main import app
from ccgen.errors import ToolError
from ccgen.export.package import export
from ccgen.targets import emulator
from ccgen.targets.cores import MICROCONTROLLERS, Tool, missing_tools
from ccgen.targets.emulated import emulated_node
from ccgen.targets.emulator import run_to_end
from ccgen.targets.exported import open_exported
from ccgen.targets.firmware import compile_firmware
from ccgen.targets.inputs import bus_counts
from ccgen.verify.emulated import verify_core as verify_target
from ccgen.verify.on_core import Printed, run_batch
from ccgen.verify.plan import Plan, silent

CASES = '[shapes]\ncases = ["constant-curvature"]'
SMALL = {
    "name": "wrist", "segments": 3, "count": 2, "step": 2e-6, "precision": 16,
}  # fmt: skip
LARGEST = {
    "name": "snake", "segments": 64, "count": 8, "bits": 28, "step": 1e-8, "precision": 32,
    "transducer": "[sensors.v]\ncount = 7",
}  # fmt: skip
WITHOUT_FALLBACKS = LARGEST | {"name": "eel"}
"""An AVR keeps tables in RAM: weights for each missing sensor of the largest joint are too many."""
BOARDS = ("cortex-m0", "cortex-m3", "riscv32", "avr")
FAULTS = {
    "cortex-m0": "__builtin_trap();",
    "cortex-m4": "*(volatile int *)0xF0000000u = 0;",
    "riscv32": "__builtin_trap();",
    "avr": "TIMSK0 = 1; TCCR0B = 1; for (;;) {}",
}


@pytest.fixture(scope="module")
def joints(tmp_path_factory):
    root = tmp_path_factory.mktemp("emulator")
    for options in (SMALL, LARGEST, WITHOUT_FALLBACKS):
        file = root / f"{options['name']}.toml"
        fallback = "false" if options is WITHOUT_FALLBACKS else "true"
        tables = f"{CASES}\n[estimator]\nfallback = {fallback}"
        file.write_text(joint_text(**options, length=0.2, range_of_motion=2.0, tables=tables))
        export(file, root / options["name"])
    return root


@pytest.fixture(scope="module")
def wrist(joints):
    return open_exported(joints / "wrist")


def with_program(joints: Path, folder: Path, text: str) -> Path:
    """A copy of the exported folder with another batch program."""
    root = Path(shutil.copytree(joints / "wrist", folder / "wrist"))
    (root / "ports" / "bare_metal" / "batch.c").write_text(text)
    return root


@pytest.mark.parametrize("target", BOARDS)
def test_more_bytes_than_the_receive_ring_holds_are_all_received(wrist, target):
    counts = bus_counts(wrist, 150, seed=3)
    with emulated_node(wrist, target) as bus:
        answers = exchange(bus, wrist.codec, counts, Pace(in_flight=14, timeout=PATIENCE))
    assert answers.complete.all()
    assert (answers.lost_frames, answers.corrupted, answers.unexpected) == (0, 0, 0)
    assert (answers.angles == wrist.guarded.follow(counts).values).all()


@pytest.mark.parametrize("target", FAULTS)
def test_a_fault_ends_the_emulator_with_its_status(joints, target, tmp_path):
    header = "#include <avr/io.h>\n" if target == "avr" else ""
    program = f'{header}#include "board.h"\nint main(void) {{ board_init(); {FAULTS[target]} }}\n'
    exported = open_exported(with_program(joints, tmp_path, program))
    with pytest.raises(ToolError, match="the firmware ended with status 3"):
        run_batch(exported, target, Plan(values=1), silent)


@pytest.mark.parametrize("target", ["cortex-m7", "riscv32", "avr"])
def test_the_programs_status_is_the_emulators(joints, target, tmp_path):
    program = '#include "board.h"\nint main(void) { board_init(); board_end(BOARD_WRONG); }\n'
    exported = open_exported(with_program(joints, tmp_path, program))
    with pytest.raises(ToolError, match="the firmware ended with status 1"):
        run_batch(exported, target, Plan(values=1), silent)


def test_a_batch_that_stops_halfway_is_no_success(joints, tmp_path):
    program = '#include "board.h"\nint main(void) { board_init(); board_end(BOARD_DONE); }\n'
    exported = open_exported(with_program(joints, tmp_path, program))
    with pytest.raises(ToolError, match="ended before its last line"):
        run_batch(exported, "cortex-m0", Plan(values=1), silent)


SLOW = "import time\nfor k in range(8):\n    time.sleep(0.05)\n    print(k, flush=True)\n"


def test_firmware_may_take_long_as_long_as_it_says_something(monkeypatch):
    """Each line has the whole silence anew, whatever those before took of theirs."""
    said, waits = [], []

    def watched(readers, writers, others, seconds):
        waits.append(seconds)
        return select.select(readers, writers, others, seconds)

    monkeypatch.setattr(emulator, "select", SimpleNamespace(select=watched))
    run_to_end([sys.executable, "-c", SLOW], PATIENCE, said.append)
    assert said == [str(k) for k in range(8)]
    assert len(waits) > 1
    assert set(waits) == {PATIENCE}


def test_firmware_that_falls_silent_is_stopped_and_half_a_line_is_none():
    program = "import time\nprint('one')\nprint('tw', end='', flush=True)\ntime.sleep(600)"
    said = []
    with pytest.raises(ToolError, match="printed no line for 1 s and was stopped"):
        run_to_end([sys.executable, "-c", program], 1.0, said.append)
    assert said in (["one"], [])  # a busy machine may not have started it


def test_endless_output_without_a_line_is_no_line_of_the_firmware():
    program = "while True:\n    print('x' * 100, end='', flush=True)"
    said = []
    with pytest.raises(ToolError):
        run_to_end([sys.executable, "-c", program], 60.0, said.append)
    assert len(said) == 1


def test_targets_that_were_done_are_shown_when_a_later_one_cannot_be(joints, monkeypatch):
    def failing(exported, target, *more):
        if target == "avr":
            raise ToolError("avr: no such luck")
        return verify_target(exported, target, *more)

    monkeypatch.setattr("ccgen.verify.target.verify_core", failing)
    options = ["--target", "cortex-m0", "--target", "avr", "--snapshots", "5", "--values", "100"]
    result = CliRunner().invoke(app, ["verify", str(joints / "wrist"), *options])
    assert result.exit_code == 2
    assert "cortex-m0, batch" in result.stdout
    assert "avr: no such luck" in result.stderr


@pytest.mark.parametrize("line", ["", "angles 0", "tip 1 2", "angles 0 xyz", "Hello", "vectors 1"])
def test_a_line_that_is_none_of_the_firmwares_is_named(line):
    with pytest.raises(ToolError, match="none of its lines"):
        Printed().take(line)


@pytest.mark.parametrize("target", ["cortex-m0", "avr"])
def test_the_emulator_is_gone_however_the_block_is_left(wrist, target):
    before = children()

    def interrupted() -> None:
        with emulated_node(wrist, target):
            assert len(children() - before) == 1
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert children() <= before


def test_an_emulator_that_dies_is_an_error_and_no_wait(wrist):
    before = children()

    def orphaned() -> None:
        with emulated_node(wrist, "cortex-m0") as bus:
            (emulator,) = children() - before
            os.kill(emulator, signal.SIGKILL)
            begin = time.monotonic()
            answers = exchange(
                bus, wrist.codec, bus_counts(wrist, 500, seed=0), Pace(timeout=PATIENCE)
            )
            assert time.monotonic() - begin < PATIENCE
            assert not answers.complete.any()
            assert answers.lost_frames > 0

    with pytest.raises(ToolError, match="qemu-system-arm: the firmware"):
        orphaned()
    assert children() <= before


@pytest.mark.parametrize("target", MICROCONTROLLERS)
def test_an_absent_tool_is_named_by_its_debian_package(wrist, target, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    packages = missing_tools(MICROCONTROLLERS[target])
    assert packages == list(dict.fromkeys(tool.package for tool in MICROCONTROLLERS[target].tools))
    with pytest.raises(ToolError, match=f"needs {' '.join(packages)}; install with `apt-get"):
        verify_target(wrist, target, Plan(), silent)


def test_a_library_that_the_compiler_does_not_find_is_absent():
    assert Tool("libc6-dev", ("cc",), "libc.so").present()
    assert not Tool("libnone-dev", ("cc",), "libnone.so").present()


@pytest.mark.parametrize(("target", "name"), [("cortex-m0", "snake"), ("avr", "eel")])
def test_the_largest_joint_fits_the_smallest_cores(joints, target, name):
    exported, plan = open_exported(joints / name), Plan(snapshots=30, values=40_000)
    for run in verify_target(exported, target, plan, silent):
        assert run.passed, run


@pytest.mark.parametrize("target", BOARDS)
def test_a_program_that_leaves_no_stack_is_refused_when_it_is_linked(joints, target, tmp_path):
    size = 62 if target == "riscv32" else 14
    program = (
        f'#include "board.h"\nstatic volatile char table[{size} * 1024u];\n'
        "int main(void) { board_init(); table[0] = 1; return table[1]; }\n"
    )
    root = with_program(joints, tmp_path, program)
    with pytest.raises(ToolError, match=r"wrist: .*RAM is full: no room for the stack"):
        compile_firmware(root, MICROCONTROLLERS[target], "batch", tmp_path, ("-O2",))


@pytest.mark.parametrize("target", MICROCONTROLLERS)
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_the_node_compiles_without_a_warning_with_and_without_optimisation(
    joints, target, level, tmp_path
):
    assert compile_firmware(
        joints / "wrist", MICROCONTROLLERS[target], "node", tmp_path, (level,)
    ).is_file()
