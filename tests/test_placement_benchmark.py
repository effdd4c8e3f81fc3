import re
import subprocess
import sys
from pathlib import Path

BENCHMARK = Path(__file__).parent / "benchmarks" / "placement_speed.py"


def test_the_literal_way_runs_until_enough_evaluations_count():
    options = ["--segments", "12", "--individuals", "2", "--evaluations", "5"]
    done = subprocess.run(
        [sys.executable, str(BENCHMARK), *options], capture_output=True, text=True, timeout=120
    )
    assert not done.stderr
    assert int(re.search(r"literal: (\d+) evaluations", done.stdout)[1]) >= 5
    assert re.search(r"an evaluation: \d+ times cheaper", done.stdout)


def test_no_evaluation_is_refused():
    done = subprocess.run(
        [sys.executable, str(BENCHMARK), "--evaluations", "0"], capture_output=True, timeout=120
    )
    assert done.returncode == 2
    assert b"give at least 1" in done.stderr
