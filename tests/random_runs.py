"""Runs of ccgen on random joint files, each in a process of its own, and what is wrong with them.

A run is right where it ends with status 0, or with 2 and one line that says why; where nothing is
printed that is no number, JSON is JSON, and no file is left of what was refused.
"""

import contextlib
import io
import json
import multiprocessing
import re
import resource
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from random_joints import RandomJoint, random_joint

COMMANDS = ("fit", "simulate", "loads", "export", "place")

SLOWEST = 20.0
"""Seconds of processor time that a run may take."""

_HANGS = 100
"""Seconds of processor time after which a run is ended."""

_WAITS = 360
"""Seconds after which a run is ended that waits for something."""

_QUICK = ["--enumerate", "300", "--starts", "2", "--individuals", "20", "--generations", "2"]

_NO_NUMBER = re.compile(r"(?<![\w.])[-+]?(nan|inf|infinity)(?![\w.])", re.IGNORECASE)

_OPTION = re.compile(
    r"error: ([uv]: )?(--|ccgen place: |no placement|no span|the search|the layout|forbid)"
)
"""How an error begins that is one of options, and of no file."""

_LONGEST_LINE = 1500


@dataclass(frozen=True)
class Run:
    """A run and what is wrong with it.

    Attributes:
        seed: of the joint file.
        command: one of `COMMANDS`.
        status: of the program; None where it did not end.
        seconds: of processor time.
        said: on stderr.
        faults: what is wrong, a sentence each.
    """

    seed: int
    command: str
    status: int | None
    seconds: float
    said: str
    faults: tuple[str, ...]


def runs(seeds: Iterator[int] | range, folder: Path, processes: int = 2) -> list[Run]:
    """Every command on every random joint of these numbers.

    Args:
        seeds: numbers of the joints.
        folder: an empty one to work in.
        processes: how many runs at once.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["random_runs", "random_runs_preload"])
    tasks = [(seed, command) for seed in seeds for command in COMMANDS]
    with ThreadPoolExecutor(processes) as pool:
        return list(pool.map(lambda task: _run(context, folder, *task), tasks))


def _run(context: Any, folder: Path, seed: int, command: str) -> Run:
    here = folder / f"{seed}-{command}"
    here.mkdir()
    joint = random_joint(seed)
    write(joint, here)
    before = set(here.iterdir())
    words = arguments(joint, here, command, seed)
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_child, args=(words, sender))
    process.start()
    sender.close()
    answer = None
    with contextlib.suppress(EOFError):
        if receiver.poll(_WAITS):
            answer = receiver.recv()
    if answer is None:
        process.kill()
    process.join()
    if answer is None:
        what = f"ended without a status, or was ended after {_HANGS} s of work or {_WAITS} s"
        return Run(seed, command, None, _HANGS, "", (what,))
    status, seconds, printed, said = answer
    faults = list(faults_of(status, printed, said, "--json" in words, here))
    if status == 2:
        faults += [f"{path.name} is left" for path in sorted(set(here.iterdir()) - before)]
    if seconds > SLOWEST:
        faults.append(f"took {seconds:.0f} s")
    return Run(seed, command, status, seconds, said, tuple(faults))


def write(joint: RandomJoint, folder: Path) -> None:
    """Write the joint's files."""
    (folder / "joint.toml").write_bytes(joint.content)
    (folder / "loads.toml").write_bytes(joint.loads)
    for name, content in joint.beside.items():
        (folder / name).write_bytes(content)


def arguments(joint: RandomJoint, folder: Path, command: str, seed: int) -> list[str]:
    """The words of a run; every third prints for people, every fifth draws."""
    path = str(folder / "joint.toml")
    words = {
        "fit": ["fit", path],
        "simulate": ["simulate", path, *joint.words["simulate"]],
        "loads": ["simulate", path, "--loads", str(folder / "loads.toml")],
        "export": ["export", path, "-o", str(folder / "out")],
        "place": ["place", path, *joint.words["place"], *_QUICK],
    }[command]
    if seed % 3:
        words.append("--json")
    if seed % 5 == 0 and command != "export":
        words += ["--plot", str(folder / "plot.svg")]
    return words


def _child(words: list[str], sender: Any) -> None:
    """Run ccgen, and send its status, its processor time and what it printed."""
    from ccgen.cli.main import main

    resource.setrlimit(resource.RLIMIT_CPU, (_HANGS, _HANGS))
    printed, said = io.StringIO(), io.StringIO()
    start, status = time.process_time(), 0
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said):
        try:
            main(words)
        except SystemExit as end:
            status = int(end.code or 0)
    seconds = time.process_time() - start
    sender.send((status, seconds, printed.getvalue(), said.getvalue()))


def faults_of(status: int, printed: str, said: str, as_json: bool, here: Path) -> Iterator[str]:
    """What is wrong with what a run said, printed and wrote."""
    lines = said.splitlines()
    errors = [line for line in lines if line.startswith("ccgen: error: ")]
    if status not in (0, 2):
        yield f"status {status}: {errors or lines[-1:]}"
        return
    for line in lines:
        if not line.startswith("ccgen: "):
            yield f"a line that is none of ccgen's: {line}"
        elif len(line) > _LONGEST_LINE:
            yield f"a line of {len(line)} characters: {line[:200]}"
        elif line not in errors and _NO_NUMBER.search(line):
            yield f"no number is told: {line}"
    if status == 2:
        if len(errors) != 1 or lines[-1:] != errors:
            yield f"refused in {len(errors)} lines: {lines}"
        elif str(here) not in errors[0] and not re.search(_OPTION, errors[0]):
            yield f"no file, and no option, is named: {errors[0]}"
        if printed:
            yield f"refused, but printed {printed[:100]!r}"
        return
    if errors:
        yield f"an error with status 0: {errors}"
    if as_json:
        yield from _json_faults(printed, "the JSON that is printed")
    elif _NO_NUMBER.search(printed):
        yield f"no number is printed: {_NO_NUMBER.search(printed)}"
    for path in sorted(here.glob("out/**/*.json")):
        yield from _json_faults(path.read_text(encoding="utf-8"), path.name)


def _json_faults(text: str, what: str) -> Iterator[str]:
    def refuse(word: str) -> None:
        raise ValueError(f"{word} is no JSON")

    try:
        json.loads(text, parse_constant=refuse)
    except ValueError as error:
        yield f"{what}: {error}"
