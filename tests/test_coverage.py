"""The unit tests take the branches of the C runtime, as `make coverage` measures it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from runtime_c import INLINED, RUNTIME

SCRIPT = Path(__file__).parent / "coverage" / "run.py"
LINE = re.compile(r"^(\S+) +(\d+) of +(\d+) branches +(\S+) %$", re.MULTILINE)


@pytest.mark.slow
def test_unit_tests_take_at_least_99_percent_of_the_branches_of_the_runtime():
    done = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    *files, (name, taken, total, _) = LINE.findall(done.stdout)
    sources = sorted(path.name for path in (*INLINED, *RUNTIME) if path.name != "crc.c")
    assert [file for file, *_ in files] == sources
    assert name == "all"
    assert int(total) == sum(int(of) for _, _, of, _ in files) > 400
    assert int(taken) >= 0.99 * int(total)
