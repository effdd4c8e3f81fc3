import json
import re
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.export.package import export

ROOT = Path(__file__).resolve().parent.parent
QUICK = ["--snapshots", "120", "--values", "20000"]


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    root = tmp_path_factory.mktemp("verify")
    for name in ("shoulder", "spine", "wrist"):
        export(ROOT / "examples" / f"{name}.toml", root / name)
    return root


@pytest.fixture
def shoulder(exported, tmp_path):
    return Path(shutil.copytree(exported / "shoulder", tmp_path / "shoulder"))


def verify(folder: Path, *options: str):
    result = CliRunner().invoke(app, ["verify", str(folder), *QUICK, *options])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def change(file: Path, pattern: str, replacement: str) -> None:
    text, count = re.subn(pattern, replacement, file.read_text(), count=1)
    assert count == 1, f"{pattern} does not occur in {file.name}"
    file.write_text(text)


def runs_of(result) -> dict[str, dict]:
    return {run["transport"]: run for run in json.loads(result.stdout)["runs"]}


@pytest.mark.parametrize("name", ["shoulder", "spine", "wrist"])
def test_every_example_equals_its_model_over_every_transport(exported, name):
    result = verify(exported / name, "--json")
    assert result.exit_code == 0, result.output
    runs = runs_of(result)
    assert list(runs) == ["batch", "virtual", "slcan-pty"]
    for run in runs.values():
        assert run["target"] == "host"
        assert run["mismatches"] == run["lost_frames"] == run["pose_mismatches"] == 0
        assert run["compared_poses"] >= 120
        assert run["compared_values"] >= 1000
        assert 0 < run["pose_max_error_m"] <= run["pose_bound_m"]
    assert runs["virtual"]["snapshots"] == runs["slcan-pty"]["snapshots"] == 120


@pytest.mark.parametrize(
    ("target", "compiler", "times"), [("host", "gcc", 2), ("cortex-m0", "arm-none-eabi-gcc", 2)]
)
def test_the_folder_is_compiled_at_the_level_asked_for(
    shoulder, tmp_path, monkeypatch, target, compiler, times
):
    programs = tmp_path / "bin"
    programs.mkdir()
    wrapper = programs / compiler
    real = shutil.which(compiler)
    wrapper.write_text(f'#!/bin/sh\necho "$@" >> {tmp_path}/calls\nexec {real} "$@"\n')
    wrapper.chmod(0o755)
    monkeypatch.setenv("PATH", str(programs), prepend=":")
    monkeypatch.setenv("CC", "gcc")
    assert verify(shoulder, "--target", target, "--optimise", "s").exit_code == 0
    calls = [line.split() for line in (tmp_path / "calls").read_text().splitlines()]
    levels = [[word for word in call if word.startswith("-O")] for call in calls if "-o" in call]
    assert levels == [["-Os"]] * times


def test_a_model_of_another_joint_is_refused(exported, shoulder):
    shutil.copy(exported / "wrist" / "model.json", shoulder / "model.json")
    result = verify(shoulder)
    assert result.exit_code == 2
    assert "model.json is not of the joint in joint.toml" in result.stderr


def test_a_missing_source_is_named_by_what_it_held(shoulder):
    (shoulder / "src" / "ccgen" / "slcan.c").unlink()
    result = verify(shoulder)
    assert result.exit_code == 2
    assert "src/ccgen/slcan.c differs from what was exported" in result.stderr
    assert "undefined reference to" in result.stderr


def test_a_wrong_weight_is_a_mismatch_over_every_transport(shoulder):
    change(shoulder / "src" / "shoulder.c", r"CCGEN_PAIR\(3544,", "CCGEN_PAIR(3545,")
    result = verify(shoulder, "--json")
    assert result.exit_code == 1
    assert all(run["mismatches"] > 0 for run in runs_of(result).values())
    assert "shoulder.c differs from what was exported" in result.stderr


def test_a_missing_saturation_is_a_mismatch(shoulder):
    change(shoulder / "src" / "shoulder.c", r"true, /\* saturates \*/", "false, /* saturates */")
    assert verify(shoulder).exit_code == 1


def test_a_frame_that_is_never_sent_is_a_lost_frame(shoulder):
    source = shoulder / "src" / "shoulder_can.c"
    change(
        source,
        r"(int shoulder_node_transmit\([^{]*\{)",
        r"\1\n    if (node->node.next == 3u) { ++node->node.next; }\n",
    )
    result = verify(shoulder, "--json", "--snapshots", "8")
    assert result.exit_code == 1
    runs = runs_of(result)
    assert runs["virtual"]["lost_frames"] == 8
    assert runs["slcan-pty"]["lost_frames"] == 8


def test_wrong_kinematics_fail_although_every_angle_is_right(shoulder):
    change(shoulder / "src" / "shoulder.h", r"(RADIANS_PER_STEP_V )\S+", r"\g<1>7.6e-06f")
    result = verify(shoulder, "--json")
    assert result.exit_code == 1
    assert runs_of(result)["batch"]["mismatches"] == 0


def test_a_pose_that_is_off_by_one_step_is_a_mismatch_over_every_transport(shoulder):
    change(shoulder / "src" / "shoulder_pose.c", r"(sum\[0\] \+= )", r"\g<1>4096 + ")
    result = verify(shoulder, "--json")
    assert result.exit_code == 1
    for run in runs_of(result).values():
        assert run["mismatches"] == 0
        assert run["pose_mismatches"] > 0
        assert not run["passed"]
    assert "poses in integers differ from the model's" in verify(shoulder).stdout


def test_code_that_does_not_compile_is_named(shoulder):
    change(shoulder / "src" / "shoulder.c", "static const", "static cons")
    result = verify(shoulder)
    assert result.exit_code == 2
    assert re.search(r"does not compile the folder: .*shoulder\.c:\d+:\d+: error", result.stderr)


def test_without_a_compiler_the_message_says_which_and_how_to_install_it(shoulder, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    result = verify(shoulder)
    assert result.exit_code == 2
    assert "no C compiler found (looked for $CC, cc, gcc and clang)" in result.stderr
    assert "apt-get install gcc" in result.stderr


def test_the_chosen_compiler_is_used(shoulder, monkeypatch, tmp_path):
    log = tmp_path / "log"
    compiler = tmp_path / "mycc"
    compiler.write_text(f'#!/bin/sh\necho "$@" >> {log}\nexec {shutil.which("gcc")} "$@"\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    assert verify(shoulder).exit_code == 0
    assert "-Werror" in log.read_text()


def test_a_folder_that_is_no_export_is_refused(tmp_path):
    result = verify(tmp_path)
    assert result.exit_code == 2
    assert "name a folder that `ccgen export` wrote" in result.stderr


def test_an_unknown_target_is_refused_with_the_known_ones(shoulder):
    result = verify(shoulder, "--target", "z80")
    assert result.exit_code == 2
    assert "known: host" in result.stderr


def test_nothing_is_left_behind(shoulder, tmp_path, monkeypatch):
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    before = sorted(p.name for p in shoulder.rglob("*"))
    assert verify(shoulder).exit_code == 0
    assert sorted(p.name for p in shoulder.rglob("*")) == before
    assert list(scratch.iterdir()) == []
