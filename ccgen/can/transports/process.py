"""A node in a process of its own that speaks SLCAN over a pseudo-terminal."""

import os
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import can

from ccgen.can.transports import not_run
from ccgen.can.transports.slcan import BlockSlcanBus
from ccgen.can.transports.terminal import raw_terminal
from ccgen.errors import ToolError

_GRACE = 10.0
"""Seconds that a process has to end by itself once its line is closed."""


@contextmanager
def process_node(program: Path) -> Iterator[can.BusABC]:
    """Run the program built from an exported folder's ports/posix; gives the host's bus.

    It has the terminal's controlling end as standard input and output, is patient (its clock runs
    slower than the machine's, and a snapshot has the widest window that there is), and ends when
    the line is closed. However the block is left, the process is gone afterwards.

    Raises:
        ToolError: the program does not start, or ended with an error for which it gave a reason.
    """
    with tempfile.TemporaryFile() as errors:
        process, bus = _start(program, errors.fileno())
        try:
            yield bus
        finally:
            bus.shutdown()
            status = _reap(process)
        if status:
            errors.seek(0)
            reason = errors.read().decode(errors="replace").strip()
            raise ToolError(f"{program}: the node ended with status {status}: {reason}")


def _start(program: Path, errors: int) -> tuple[subprocess.Popen[bytes], can.BusABC]:
    controlling, terminal = raw_terminal()
    try:
        process = subprocess.Popen(
            [program, "--patient"],
            stdin=controlling,
            stdout=controlling,
            stderr=errors,
        )
        try:
            return process, BlockSlcanBus(os.ttyname(terminal))
        except BaseException:
            _reap(process)
            raise
    except OSError as error:
        reason = not_run(program, error)
        raise ToolError(f"{program}: does not start as a node: {reason}") from error
    except can.CanError as error:
        raise ToolError(f"{program}: does not start as a node: {error}") from error
    finally:
        os.close(controlling)
        os.close(terminal)


def _reap(process: subprocess.Popen[bytes]) -> int:
    """Return the exit status; 0 for a program that had to be stopped."""
    try:
        return process.wait(_GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return 0
