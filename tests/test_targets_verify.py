"""The same bits on every core: emulated microcontrollers against the reference models."""

import dataclasses
import functools
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.export.package import export
from ccgen.targets.compiler import LEVEL, LEVELS
from ccgen.targets.cores import MICROCONTROLLERS as TARGETS
from ccgen.targets.exported import Exported, open_exported
from ccgen.verify.emulated import verify_core as verify_target
from ccgen.verify.on_core import compare_batch, run_batch
from ccgen.verify.plan import Plan, silent

BENT = {
    "segments": 6, "length": 0.12, "range_of_motion": 4.0, "transducer": "[sensors.v]\ncount = 2",
}  # fmt: skip
FINGER = joint_text("finger", **BENT)
FINE = joint_text("fine", precision=32, bits=28, step=1e-8, **BENT)
CORTEX_M = tuple(target for target in TARGETS if target.startswith("cortex-m"))
SMALL = Plan(values=8_000)


@pytest.fixture(scope="module")
def joints(tmp_path_factory) -> dict[int, Exported]:
    root = tmp_path_factory.mktemp("targets")
    for name, text in (("finger", FINGER), ("fine", FINE)):
        (root / f"{name}.toml").write_text(text)
        export(root / f"{name}.toml", root / name)
    return {16: open_exported(root / "finger"), 32: open_exported(root / "fine")}


@pytest.fixture(scope="module")
def printed_by(joints):
    """What the batch firmware prints, by precision and target; each runs once."""
    return functools.cache(lambda bits, target: run_batch(joints[bits], target, SMALL, silent))


def test_every_core_that_was_promised_is_a_target():
    assert tuple(TARGETS) == ("cortex-m0", "cortex-m3", "cortex-m4", "cortex-m7", "riscv32", "avr")


@pytest.mark.parametrize("precision", [16, 32])
@pytest.mark.parametrize("target", TARGETS)
def test_every_angle_is_the_models_over_the_uart_and_in_batches(joints, target, precision):
    plan = Plan(snapshots=300, values=100_000, seed=5)
    uart, batch = verify_target(joints[precision], target, plan, silent)
    assert (uart.transport, batch.transport) == ("uart", "batch")
    assert uart.snapshots == 300
    assert uart.compared_values == 300 * 12
    assert batch.compared_values >= 100_000
    assert uart.compared_poses == 300
    assert batch.compared_poses >= 128
    for run in (uart, batch):
        assert run.passed, run
        assert run.pose_mismatches == 0
        assert run.target == target
        assert 0.0 < run.pose_max_error_m <= run.pose_bound_m


@pytest.mark.parametrize("target", TARGETS)
def test_no_level_of_optimisation_changes_a_bit_of_the_angles(joints, target):
    others = [level for level in LEVELS if level != LEVEL]  # at which all else here is compiled
    for precision, levels in ((16, others), (32, ("-O0", "-O3"))):
        runs = [run_batch(joints[precision], target, SMALL, silent, (level,)) for level in levels]
        for printed in runs:
            assert compare_batch(joints[precision], target, SMALL, printed).passed
            assert printed.checksums == runs[0].checksums


@pytest.mark.parametrize("precision", [16, 32])
def test_poses_have_the_same_bits_on_every_cortex_m(printed_by, precision):
    first, *others = [printed_by(precision, target) for target in CORTEX_M]
    assert first.poses is not None
    for printed in others:
        assert printed.poses == first.poses
        assert printed.tips == first.tips


@pytest.mark.parametrize("target", ["cortex-m4", "cortex-m7"])
def test_contracted_poses_differ_and_stay_within_the_bound(joints, printed_by, target):
    contracted = run_batch(joints[16], target, SMALL, silent, ("-O2", "-ffp-contract=fast"))
    assert contracted.poses != printed_by(16, target).poses
    assert contracted.checksums == printed_by(16, target).checksums
    assert compare_batch(joints[16], target, SMALL, contracted).passed


@pytest.mark.parametrize("target", ["cortex-m0", "avr"])
def test_a_weight_that_is_off_by_one_is_a_mismatch_in_both_runs(joints, target, tmp_path):
    root = Path(shutil.copytree(joints[16].directory, tmp_path / "finger"))
    source = root / "src" / "finger.c"
    weight = re.search(r"CCGEN_PAIR\((-?\d+),", source.read_text())
    assert weight is not None
    wrong = f"CCGEN_PAIR({int(weight[1]) + 1},"
    source.write_text(source.read_text().replace(weight[0], wrong, 1))
    uart, batch = verify_target(open_exported(root), target, Plan(50, 20_000), silent)
    assert uart.mismatches > 0
    assert batch.mismatches >= 12 * batch.snapshots
    assert not uart.passed
    assert not batch.passed


@pytest.mark.parametrize("field", ["integers", "jacobians", "vectors"])
def test_poses_in_integers_that_differ_are_told(joints, printed_by, field):
    printed = printed_by(16, "cortex-m4")
    right = compare_batch(joints[16], "cortex-m4", SMALL, printed)
    assert (right.compared_poses, right.pose_mismatches) == (128 + printed.vectors[2], 0)
    assert printed.vectors[2:] == (10, 0)
    wrong = {
        "integers": printed.integers ^ 1,
        "jacobians": printed.jacobians ^ 1,
        "vectors": (*printed.vectors[:3], 3),
    }
    changed = dataclasses.replace(printed, **{field: wrong[field]})
    run = compare_batch(joints[16], "cortex-m4", SMALL, changed)
    assert run.pose_mismatches == (3 if field == "vectors" else 64)
    assert not run.passed


def test_a_wrong_pose_is_out_of_bounds(joints, printed_by):
    printed = printed_by(16, "cortex-m4")
    (x, y, z), *tips = printed.tips
    moved = dataclasses.replace(printed, tips=[(x + 1e-5, y, z), *tips])
    run = compare_batch(joints[16], "cortex-m4", SMALL, moved)
    assert run.pose_max_error_m == pytest.approx(1e-5, rel=0.1)
    assert not run.passed


def test_drawn_poses_cover_the_whole_format(joints):
    from ccgen.verify.on_core import pose_angles

    for precision, exported in joints.items():
        angles = pose_angles(exported, seed=0)
        full = 2.0 ** (precision - 1)
        assert np.all(np.abs(angles) <= full)
        assert angles.min() < -0.98 * full
        assert angles.max() > 0.98 * full


def test_verify_takes_a_core_by_name_and_lists_them(joints):
    folder = str(joints[16].directory)
    command = ["verify", folder, "--snapshots", "40", "--values", "5000", "--target"]
    done = CliRunner().invoke(app, [*command, "cortex-m3", "--json"])
    assert done.exit_code == 0, done.output
    assert [run["transport"] for run in json.loads(done.stdout)["runs"]] == ["uart", "batch"]
    unknown = CliRunner().invoke(app, [*command, "cortex-m1"])
    assert unknown.exit_code == 2
    assert all(target in unknown.output for target in ("host", *TARGETS))


def test_the_bridge_runs_a_joint_file_on_an_emulated_core(joints):
    joint = str(joints[16].directory / "joint.toml")
    command = ["bridge", joint, "--target", "cortex-m4", "--seconds", "0.5", "--json"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    summary = json.loads(done.stdout)
    assert summary["transport"] == "cortex-m4"
    assert summary["answered"] == summary["snapshots"] == 50
    assert summary["mismatches"] == summary["lost_frames"] == 0
