import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CHECK = ROOT / "examples" / "ci" / "check.sh"


def check(*joints: Path, scratch: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "TMPDIR": str(scratch),
        "SNAPSHOTS": "60",
        **variables,
    }
    return subprocess.run(
        ["bash", CHECK, *joints], env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture
def scratch(tmp_path):
    (tmp_path / "scratch").mkdir()
    return tmp_path / "scratch"


def test_the_script_verifies_every_joint_file_it_is_given(scratch):
    joints = [ROOT / "examples" / "shoulder.toml", ROOT / "examples" / "wrist.toml"]
    done = check(*joints, scratch=scratch)
    assert done.returncode == 0, done.stderr
    assert (
        done.stdout.count("Every angle and pose is the model's, bit for bit; no frame was lost.")
        == 2
    )
    assert list(scratch.iterdir()) == []


def test_the_script_fails_on_joints_that_do_not_go_together_and_reports_it(scratch, tmp_path):
    text = (ROOT / "examples" / "wrist.toml").read_text()
    (tmp_path / "wrist.toml").write_text(text.replace("0x400", "0x305"))
    joints = [ROOT / "examples" / "shoulder.toml", tmp_path / "wrist.toml"]
    report = tmp_path / "check.xml"
    done = check(*joints, scratch=scratch, JUNIT=str(report))
    assert done.returncode == 1
    assert "FAILED: " in done.stdout
    assert "Every angle" not in done.stdout
    assert "<failure " in report.read_text()


def test_the_script_verifies_folders_that_are_there_with_ccgen_from_a_checkout(scratch, tmp_path):
    from ccgen.export.package import export

    export(ROOT / "examples" / "wrist.toml", tmp_path / "wrist")
    run = f"{sys.executable} -m ccgen"
    done = check(tmp_path / "wrist", scratch=scratch, CCGEN=run, PATH=os.environ["PATH"])
    assert done.returncode == 0, done.stderr
    assert "Every angle and pose is the model's" in done.stdout


def test_the_script_fails_on_a_wrong_joint_file_and_says_why(scratch, tmp_path):
    joint = tmp_path / "joint.toml"
    joint.write_text('name = "while"\n')
    done = check(joint, scratch=scratch)
    assert done.returncode == 2
    assert "joint.toml: " in done.stderr
    assert list(scratch.iterdir()) == []


def test_the_script_without_a_joint_file_says_how_to_use_it(scratch):
    done = check(scratch=scratch)
    assert done.returncode == 2
    assert "usage: " in done.stderr
