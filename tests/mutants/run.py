"""Changes the C runtime in one place after the other and tells which changes no unit test notices.

    python tests/mutants/run.py            all of them
    python tests/mutants/run.py snapshot   those whose line contains one of the words

A mutant is killed where a test fails, crashes or takes too long; it survives where all tests that
see its file pass. One that the table calls equivalent must survive. A change that does not compile
proves nothing and is refused; warnings are no errors here, so that it takes a test to kill. The
status is 1 where a mutant survives without a reason, is killed in spite of one, or is refused.
"""

import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from mutants.mutant import Group, Mutant
from mutants.table import GROUPS
from mutants.trial import KILLED, Outcome, Trial, import_what_tests_need

PROCESSES = 2


def main(words: Sequence[str]) -> int:
    """Try the mutants that are asked for; the exit status."""
    chosen = [
        (group, mutant)
        for group in GROUPS
        for mutant in group.mutants
        if not words or any(word in str(mutant) for word in words)
    ]
    began = time.monotonic()
    outcomes = []
    for outcome in tried(chosen):
        outcomes.append(outcome)
        print(f"{outcome.verdict:9} {outcome.mutant}  {_reason(outcome)}", flush=True)
    wrong = [outcome for outcome in outcomes if not outcome.expected]
    killed = sum(outcome.verdict == KILLED for outcome in outcomes)
    argued = sum(outcome.expected and bool(outcome.mutant.equivalent) for outcome in outcomes)
    print(
        f"{len(outcomes)} mutants in {time.monotonic() - began:.0f} s: {killed} killed, "
        f"{argued} argued equivalent, {len(wrong)} not as they should be"
    )
    for outcome in wrong:
        print(f"\n{outcome.verdict}: {outcome.mutant}\n{outcome.log[-2000:]}")
    return 1 if wrong or not outcomes else 0


def tried(chosen: Sequence[tuple[Group, Mutant]]) -> Iterator[Outcome]:
    """Try mutants, some at a time; the outcomes come as their tests end."""
    import_what_tests_need()
    waiting = iter(enumerate(chosen))
    running: set[Trial] = set()
    with tempfile.TemporaryDirectory(prefix="ccgen-mutants-") as folder:
        store = Path(folder) / "objects"
        store.mkdir()
        try:
            while True:
                while len(running) < PROCESSES and (item := next(waiting, None)):
                    running.add(Trial(*item[1], Path(folder) / str(item[0]), store))
                if not running:
                    return
                time.sleep(0.02)
                for trial in tuple(running):
                    if outcome := trial.outcome():
                        running.remove(trial)
                        yield outcome
        finally:
            for trial in running:
                trial.stop()


def _reason(outcome: Outcome) -> str:
    return f"[{outcome.mutant.equivalent or outcome.by.rpartition('::')[2]}]"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
