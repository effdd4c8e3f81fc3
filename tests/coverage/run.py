"""Tells which branches of the C runtime the unit tests take, by gcov: `make coverage`.

Both ways of every condition count, those inside `&&` and `||` too. The tests are those of the
runtime's sources, compiled without optimisation. Status 1 below 99 % in all, where a source is not
tested, or where a test fails.
"""

import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import pytest
import runtime_c
from objects_c import compile_objects

TESTS = Path(__file__).resolve().parents[1]
LEAST = 0.99
OTHERS = ("compile", "cores", "estimator", "fuzz", "mixes", "ports", "queue")
FILES = [
    path
    for path in sorted(TESTS.glob("test_runtime_*.py"))
    if path.stem.removeprefix("test_runtime_") not in OTHERS
]
"""OTHERS only compile, fuzz, run whole ports and cores, or are about headers alone."""

SOURCES = tuple(path for path in (*runtime_c.INLINED, *runtime_c.RUNTIME) if path.name != "crc.c")
"""Sources and inline functions with branches; tables have none."""

Branch = tuple[str, int, int]
"""File, line, and which of the line."""


def main() -> int:
    """Run the tests, print a line a file; the exit status."""
    with tempfile.TemporaryDirectory(prefix="ccgen-coverage-") as folder:
        # Counts are written as a process ends.
        if subprocess.run([sys.executable, __file__, folder], check=False).returncode != 0:
            return 1
        taken = _branches(Path(folder))
    names = sorted({file for file, _, _ in taken})
    for name in names:
        _print(name, [count for (file, _, _), count in taken.items() if file == name])
        for (file, line, which), count in sorted(taken.items()):
            if file == name and count == 0:
                print(f"    line {line}, branch {which} is never taken")
    _print("all", list(taken.values()))
    complete = len(names) == len(SOURCES)
    return 0 if complete and _share(list(taken.values())) >= LEAST else 1


def _run_tests(store: Path) -> int:
    def compiled(files, flags=(), *arguments):
        kept = [
            flag for flag in flags if not flag.startswith(("-O", "-fsanitize", "-fno-sanitize"))
        ]
        return compile_objects(store, files, [*kept, "-O0", "--coverage"], *arguments)

    runtime_c.compile_c = compiled
    options = ["-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:xdist"]
    return pytest.main([*options, f"--basetemp={store / 'pytest'}", *map(str, FILES)])


def _branches(store: Path) -> Counter[Branch]:
    """How often each branch of the sources was taken, over all builds."""
    taken: Counter[Branch] = Counter()
    command = ["gcov", "--branch-probabilities", "--json-format", "--stdout"]
    for data in sorted(store.glob("*.gcda")):
        done = subprocess.run(
            [*command, data], capture_output=True, text=True, check=True, cwd=store
        )
        for file in json.loads(done.stdout)["files"]:
            if not _is_a_source(Path(file["file"])):
                continue
            for line in file["lines"]:
                for which, branch in enumerate(line["branches"]):
                    place = (Path(file["file"]).name, line["line_number"], which)
                    taken[place] += branch["count"]
    return taken


def _is_a_source(path: Path) -> bool:
    """Whether a file is one of the runtime's sources, there or in an exported folder."""
    same = next((source for source in SOURCES if source.name == path.name), None)
    return same is not None and same.read_bytes() == path.read_bytes()


def _share(counts: list[int]) -> float:
    return sum(count > 0 for count in counts) / len(counts)


def _print(name: str, counts: list[int]) -> None:
    taken = sum(count > 0 for count in counts)
    print(f"{name:18} {taken:4} of {len(counts):4} branches  {100 * _share(counts):6.2f} %")


if __name__ == "__main__":
    sys.exit(_run_tests(Path(sys.argv[1])) if sys.argv[1:] else main())
