"""Random joint files, legal and not, through fit, simulate, export and place: no fault, no wait.

Every run is a process of its own. It must end with status 0, or with 2 and one line that says why;
print JSON that is JSON and numbers that are some; leave nothing of what was refused; and take at
most 20 s of processor time. Takes some twenty minutes on two processors.

    python tests/benchmarks/random_joints.py [--joints N] [--first SEED] [--processes N]

Status 1 where a run is wrong.
"""

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from random_runs import COMMANDS, SLOWEST, Run, runs


def main() -> int:
    """Run the joints, print the figures, and return the status."""
    options = argparse.ArgumentParser()
    options.add_argument("--joints", type=int, default=400)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--processes", type=int, default=2)
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        seeds = range(given.first, given.first + given.joints)
        found = runs(seeds, Path(folder), given.processes)
    print_figures(found)
    faults = [(run, fault) for run in found for fault in run.faults]
    for run, fault in faults:
        print(f"joint {run.seed}, {run.command}: {fault}")
    print(f"{len(faults)} faults in {len(found)} runs of {given.joints} joints")
    return 1 if faults else 0


def print_figures(found: list[Run]) -> None:
    """Print for each command how its runs ended and how long the slowest took."""
    print(f"{'':10}{'done':>8}{'refused':>9}{'slowest':>12}   (of {SLOWEST:.0f} s)")
    for command in COMMANDS:
        own = [run for run in found if run.command == command]
        ends = Counter(run.status for run in own)
        slowest = max(run.seconds for run in own)
        print(f"{command:10}{ends[0]:>8}{ends[2]:>9}{slowest:>10.1f} s")


if __name__ == "__main__":
    sys.exit(main())
