"""What the estimator takes of a Cortex-M0's flash and stack, whatever the joint's axes."""

import subprocess
from pathlib import Path

import pytest
from benchmarks.estimator_instructions import Footprint, footprint
from joint_files import joint_text

from ccgen.export.package import export
from ccgen.targets.exported import Exported, open_exported
from ccgen.verify.emulated import verify_core as verify_target
from ccgen.verify.plan import Plan, silent

ALIKE = ""
OTHER_RADIUS = "[sensors.v]\nradius = 0.04"
OTHER_SHIFT = "[sensors.v]\nradius = 0.015"
"""Axes with the same tables; with tables of their own; besides with formats of their own."""

AXES = {"alike": ALIKE, "radius": OTHER_RADIUS, "shift": OTHER_SHIFT}
CLANG = {
    "cortex-m0": ("--target=thumbv6m-none-eabi", "-mcpu=cortex-m0"),
    "cortex-m23": ("--target=thumbv8m.base-none-eabi", "-mcpu=cortex-m23"),
}


OFF = "check = false\nfallback = false"
"""Nothing serves without a sensor, and nothing watches them."""


def joint(
    folder: Path,
    sensors: int,
    axes: str,
    segments: int = 24,
    step: float = 2e-5,
    precision: int = 16,
    estimator: str = "",
) -> Exported:
    path = folder / "arm.toml"
    text = joint_text(
        "arm", segments, sensors, length=0.96, transducer=axes, step=step, precision=precision,
        bits=16 if precision == 16 else 30, tables=f"[estimator]\n{estimator}",
    )  # fmt: skip
    path.write_text(text.replace('"heuristic"', '"single"') if sensors == 1 else text)
    export(path, folder / "arm")
    return open_exported(folder / "arm")


def measured(folder: Path, sensors: int, axes: str, segments: int, estimator: str) -> Footprint:
    exported = joint(folder, sensors, axes, segments, estimator=estimator)
    return footprint(exported, "cortex-m0")


@pytest.mark.parametrize(("estimator", "code"), [(OFF, 1024), ("", 1280)])
@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize(("segments", "sensors"), [(12, 3), (24, 3), (48, 6), (24, 8)])
def test_an_estimator_fits_a_kilobyte_and_its_fallbacks_a_quarter_more(
    segments, sensors, axes, estimator, code, tmp_path
):
    assert measured(tmp_path, sensors, AXES[axes], segments, estimator).code <= code


@pytest.mark.parametrize(("estimator", "code"), [(OFF, 1024), ("", 1280)])
@pytest.mark.parametrize(
    ("u", "v"), [(7, 8), (8, 1), (3, 4), (4, 6), (4, 8), (6, 8)], ids=lambda n: str(n)
)
def test_axes_of_different_sensors_take_no_more_together(u, v, estimator, code, tmp_path):
    placement = "single" if v == 1 else "heuristic"
    axes = f'[sensors.v]\ncount = {v}\nplacement = "{placement}"'
    assert measured(tmp_path, u, axes, 24, estimator).code <= code


@pytest.mark.parametrize(("estimator", "stack"), [(OFF, 80), ("", 128)])
@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("sensors", range(1, 7))
def test_an_estimate_of_one_to_six_sensors_takes_little_stack(
    sensors, axes, estimator, stack, tmp_path
):
    assert measured(tmp_path, sensors, AXES[axes], 24, estimator).stack <= stack


@pytest.mark.parametrize(("estimator", "stack"), [(OFF, 96), ("", 152)])
def test_seven_and_eight_sensors_take_a_little_more_stack(estimator, stack, tmp_path):
    assert measured(tmp_path, 7, "[sensors.v]\ncount = 8", 24, estimator).stack <= stack


@pytest.mark.parametrize("level", ["0", "s", "2", "3"])
def test_axes_of_different_shifts_share_code_and_keep_the_models_bits(level, tmp_path):
    exported = joint(tmp_path, 3, OTHER_SHIFT, segments=10)
    shifts = (exported.model.u.shift, exported.model.v.shift)
    assert shifts[0] != shifts[1]
    source = (exported.directory / "src" / "arm.c").read_text()
    assert source.count("CCGEN_SHARED void evaluate(") == 1
    plan = Plan(snapshots=50, values=20_000)
    for run in verify_target(exported, "cortex-m0", plan, silent, f"-O{level}"):
        assert run.compared_values >= 1_000
        assert run.mismatches == 0


@pytest.mark.parametrize("level", ["0", "1", "s", "2", "3"])
@pytest.mark.parametrize("core", CLANG)
def test_clang_compiles_the_estimator_for_cores_with_thumb_1(core, level, tmp_path):
    for sensors, axes in ((3, ALIKE), (6, OTHER_SHIFT), (8, OTHER_RADIUS)):
        source = joint(tmp_path, sensors, axes).directory / "src" / "arm.c"
        command = [
            "clang", *CLANG[core], f"-O{level}", "-std=c99", "-ffreestanding", "-Wall", "-Wextra",
            "-Werror", f"-I{source.parent}", "-c", str(source), "-o", str(tmp_path / "arm.o"),
        ]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
