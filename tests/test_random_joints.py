"""Random joint files through every command that reads one; the benchmark has more of them."""

import pytest
from random_joints import random_joint
from random_runs import faults_of, runs

from ccgen.errors import CcgenError
from ccgen.joint.file import parse_joint

SEEDS = (5, 17, 23, 168, 204, 236, 242, 243, 1084, 1133)
"""Some that are fitted, some that are refused, and some that faults were found with."""


def parsed(seed):
    """The joint, or None where its file is refused."""
    try:
        return parse_joint(random_joint(seed).content.decode("utf-8"), "joint.toml")
    except (CcgenError, UnicodeDecodeError):
        return None


def test_random_joint_files_are_refused_in_one_line_or_work(tmp_path):
    found = runs(SEEDS, tmp_path)
    assert [(run.seed, run.command, run.faults) for run in found if run.faults] == []
    assert {run.status for run in found} == {0, 2}


def test_the_same_number_gives_the_same_files():
    assert random_joint(7) == random_joint(7) != random_joint(8)


def test_random_files_are_legal_and_not_and_know_every_table():
    joints = [parsed(seed) for seed in range(300)]
    legal = [joint for joint in joints if joint is not None]
    assert 150 < len(legal) < 250
    assert any(joint.u is None and joint.v is None for joint in legal)
    assert any(joint.recordings for joint in legal)
    assert any(joint.loads for joint in legal)
    assert any(joint.geometry.elongation for joint in legal)
    assert {joint.method for joint in legal} == {"direct", "equal", "wam", "noise-aware"}


@pytest.mark.parametrize(
    ("status", "printed", "said", "fault"),
    [
        (0, "{}", "", None),
        (0, "{} {}", "", "Extra data"),
        (0, '{"a": NaN}', "", "NaN is no JSON"),
        (0, '{"a": -Infinity}', "", "-Infinity is no JSON"),
        (0, "{}", "Traceback (most recent call last):", "a line that is none of ccgen's"),
        (0, "{}", "ccgen: warning: noise of nan m", "no number is told"),
        (1, "", "ccgen: error: a check failed", "status 1"),
        (3, "", "ccgen: error: a fault of ccgen's own", "status 3"),
        (2, "", "ccgen: error: {here}/joint.toml: name: missing", None),
        (2, "", "ccgen: error: name: missing", "no file, and no option"),
        (2, "", "ccgen: error: {here}/a\nccgen: error: {here}/b", "refused in 2 lines"),
        (2, "{}", "ccgen: error: {here}/joint.toml: name: missing", "refused, but printed"),
    ],
)
def test_what_is_wrong_with_a_run_is_found(tmp_path, status, printed, said, fault):
    found = list(faults_of(status, printed, said.format(here=tmp_path), True, tmp_path))
    assert len(found) == (fault is not None)
    assert fault is None or fault in found[0]
