"""The mutants of the C runtime: each still applies, and the script tells what becomes of one.

All of them run in `make mutants`.
"""

import subprocess
import sys
from pathlib import Path

import pytest
from mutants.mutant import Mutant, StaleError, mutated
from mutants.table import GROUPS

from ccgen.resources import firmware

SCRIPT = Path(__file__).parent / "mutants" / "run.py"
TESTS = Path(__file__).parent
MUTANTS = [mutant for group in GROUPS for mutant in group.mutants]


def test_every_mutation_still_applies_to_exactly_one_place():
    for mutant in MUTANTS:
        assert mutated(mutant) != (firmware() / mutant.file).read_text()


def test_no_mutation_is_there_twice():
    assert len({mutated(mutant) for mutant in MUTANTS}) == len(MUTANTS)


def test_mutations_reach_every_source_and_the_kernel_in_assembly():
    files = {mutant.file for mutant in MUTANTS}
    assert {f"src/{path.name}" for path in (firmware() / "src").glob("*.c")} <= files
    assert "include/ccgen/kernel16_thumb1.h" in files
    assert sum(not mutant.equivalent for mutant in MUTANTS) >= 50


@pytest.mark.parametrize("old", ["no such text", "0x1Du"])
def test_a_mutation_whose_place_is_gone_or_not_alone_is_refused(old):
    with pytest.raises(StaleError, match=r"src/crc.c: .* stands there \d times"):
        mutated(Mutant("src/crc.c", old, "anything"))
    with pytest.raises(StaleError, match="there is no such file"):
        mutated(Mutant("src/none.c", old, "anything"))


OF_NO_USE = """
from mutants.mutant import of
from mutants.run import tried
group = of(
    "include/ccgen/tip.h", ("test_runtime_node.py",), ("(doubled & 1)", "(doubled & 1u)"),
    ("(doubled & 1)", "(doubled &* 1)"), chosen="tip",
)
outcomes = list(tried([(group, mutant) for mutant in group.mutants]))
assert not any(outcome.expected for outcome in outcomes)
verdicts = {outcome.mutant.new: outcome.verdict for outcome in outcomes}
assert verdicts == {
    "(doubled & 1u)": "survives", "(doubled &* 1)": "does not compile"
}, verdicts
"""


def test_a_mutant_that_survives_without_a_reason_or_does_not_compile_is_told():
    done = subprocess.run(
        [sys.executable, "-c", OF_NO_USE], cwd=TESTS, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_a_handful_of_mutants_is_killed_and_one_that_no_test_can_tell_lives():
    words = ("E2E_P05_START", "overlong = true", "#15", "layout->cycle_us >= 1u")
    done = subprocess.run(
        [sys.executable, SCRIPT, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "4 mutants in " in done.stdout
    assert "3 killed, 1 argued equivalent, 0 not as they should be" in done.stdout
