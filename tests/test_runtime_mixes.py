"""No estimate mixes two sendings: a small run of the benchmark, and faults that it must find."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from mixes import Traffic, compile_mixes, stream

from ccgen.export.package import export

EXAMPLES = Path(__file__).parent.parent / "examples"
BENCHMARK = Path(__file__).parent / "benchmarks" / "snapshot_mixes.py"


@pytest.fixture(scope="module")
def shoulder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mixes") / "shoulder"
    export(EXAMPLES / "shoulder.toml", folder)
    return folder


@pytest.fixture(scope="module")
def without_turn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mixes")
    text = (EXAMPLES / "shoulder.toml").read_text(encoding="utf-8")
    (folder / "joint.toml").write_text(f"{text}turn = false\n", encoding="utf-8")
    export(folder / "joint.toml", folder / "shoulder")
    return folder / "shoulder"


def test_disturbed_traffic_to_every_example_joint_mixes_nothing_that_it_must_not():
    done = subprocess.run(
        [sys.executable, BENCHMARK, "--snapshots", "20000"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.count(": 0 mixed, 0 late recoveries, 0 wrong STALE") == 9


@pytest.mark.parametrize("window", [1, 6])
def test_without_the_turn_nothing_mixes_within_its_contract(without_turn, tmp_path, window):
    program = compile_mixes(without_turn, tmp_path)
    result = stream(program, Traffic(100_000, window, delay=7), seed=5)
    assert (result["mixed"], result["slow"], result["false_stale"]) == (0, 0, 0)


def test_beyond_its_contract_the_observer_sees_mixes(without_turn, tmp_path):
    """15 numbers, and frames late by up to 40 cycles."""
    program = compile_mixes(without_turn, tmp_path)
    assert stream(program, Traffic(100_000, 6, delay=40), seed=5)["mixed"] > 0


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("snapshot_inline.h", "ccgen_snapshot_begin(snapshot, snapshot->newest);", ";"),
        ("snapshot_inline.h", "? now_us : snapshot->now_us", "? now_us : now_us"),
        ("layout_inline.h", "!layout->fd && layout->turn;", "layout->fd && layout->turn;"),
        (
            "snapshot_inline.h",
            "first_us) > snapshot->window_us",
            "first_us) > snapshot->window_us / 64u",
        ),
        ("snapshot_inline.h", "snapshot->stale = false;\n    snapshot->aged = false;", ""),
    ],
)
def test_a_planted_fault_is_found(shoulder, tmp_path, file, right, wrong):
    folder = Path(shutil.copytree(shoulder, tmp_path / "shoulder"))
    source = folder / "src" / "ccgen" / file
    text = source.read_text(encoding="utf-8")
    assert text.count(right) == 1
    source.write_text(text.replace(right, wrong), encoding="utf-8")
    program = compile_mixes(folder, tmp_path)
    with pytest.raises(AssertionError, match="not so"):
        stream_soundly(program)


def stream_soundly(program: Path) -> None:
    result = stream(program, Traffic(50_000, 15, any_number=True), seed=1)
    assert (result["mixed"], result["false_stale"]) == (result["by_chance"], 0), "not so"
