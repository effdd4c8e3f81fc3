"""One mutant under the tests that see it, in a process of its own."""

import functools
import importlib
import os
import re
import resource
import signal
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import pytest
from mutants.mutant import Group, Mutant, copy_with

from ccgen import resources
from ccgen.targets import compiler

TESTS = Path(__file__).resolve().parent.parent
BUSY, PATIENCE = 60, 600.0
"""Seconds of computing, and of waiting, after which tests that a mutant holds up have failed."""

KILLED, SURVIVES, REFUSED = "killed", "survives", "does not compile"
COMPILERS_ERROR = re.compile(r"(?<!runtime )\b(error|Error): |undefined reference")
FAILED_TEST = re.compile(r"^FAILED (\S+)", re.MULTILINE)


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant.

    Attributes:
        by: the first test that failed, or how the tests ended otherwise.
        log: what the tests said.
    """

    mutant: Mutant
    verdict: str
    by: str
    log: str

    @property
    def expected(self) -> bool:
        return self.verdict == (SURVIVES if self.mutant.equivalent else KILLED)


class Trial:
    """A mutant whose tests have been started."""

    def __init__(self, group: Group, mutant: Mutant, folder: Path, store: Path) -> None:
        folder.mkdir()
        runtime = copy_with(mutant, folder)
        self.mutant = mutant
        self._log = folder / "log"
        self._deadline = time.monotonic() + PATIENCE
        self._late = False
        self._pid = os.fork()
        if self._pid == 0:
            _run_tests(group, runtime, folder, store)

    def outcome(self) -> Outcome | None:
        """What became of it; None while its tests run.

        Raises:
            RuntimeError: pytest found no tests, or could not run them.
        """
        if not self._late and time.monotonic() > self._deadline:
            self._late = True
            self.stop()
        ended, status = os.waitpid(self._pid, os.WNOHANG)
        if not ended:
            return None
        return self._judge(os.waitstatus_to_exitcode(status))

    def stop(self) -> None:
        """End the tests and what they have started."""
        with suppress(ProcessLookupError):  # it has only just begun, or just ended
            os.killpg(self._pid, signal.SIGKILL)

    def _judge(self, status: int) -> Outcome:
        log = self._log.read_text(errors="replace")
        if status == pytest.ExitCode.OK:
            return Outcome(self.mutant, SURVIVES, "", log)
        if status == pytest.ExitCode.TESTS_FAILED:
            by = FAILED_TEST.search(log)
            verdict = REFUSED if COMPILERS_ERROR.search(log) else KILLED
            return Outcome(self.mutant, verdict, by[1] if by else "undefined behaviour", log)
        if status < 0:
            by = "took too long" if self._late else f"ended by {signal.Signals(-status).name}"
            return Outcome(self.mutant, KILLED, by, log)
        raise RuntimeError(f"{self.mutant}: pytest ended with status {status}\n{log}")


def import_what_tests_need() -> None:
    """Import what takes long once, before the processes part."""
    for module in ("can", "ccgen.export.package", "ccgen.cost.emulator", "hypothesis"):
        importlib.import_module(module)


def _run_tests(group: Group, runtime: Path, folder: Path, store: Path) -> NoReturn:
    status: int = pytest.ExitCode.INTERNAL_ERROR
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (BUSY, BUSY))
        os.chdir(TESTS.parent)
        for stream in (1, 2):
            os.dup2(os.open(folder / "log", os.O_WRONLY | os.O_CREAT | os.O_APPEND), stream)
        tempfile.tempdir = str(folder)
        resources.firmware = lambda: runtime
        compiler.WARNINGS = ("-w",)
        runtime_c = importlib.import_module("runtime_c")
        runtime_c.WARNINGS = ("-w",)
        objects = importlib.import_module("objects_c")
        runtime_c.compile_c = functools.partial(objects.compile_objects, store)
        options = ["-x", "-q", "--tb=short", "-p", "no:cacheprovider", "-p", "no:xdist"]
        options += [f"--basetemp={folder / 'pytest'}", f"-k={group.chosen}"]
        status = pytest.main([*options, *(str(TESTS / test) for test in group.tests)])
    finally:
        os._exit(status)
