"""Runs firmware in an emulator whose UART is the emulator's standard input and output."""

import errno
import os
import select
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO

import can

from ccgen.can.transports import not_run
from ccgen.can.transports.slcan import BlockSlcanBus
from ccgen.can.transports.terminal import raw_terminal
from ccgen.errors import ToolError

_START = 30.0
"""Seconds until the firmware must have said that its receiver listens."""

_LONGEST_LINE = 1000
"""Bytes; the firmware's own lines are far shorter."""

_GRACE = 30.0
"""Seconds until an emulator that has closed its line has ended."""


@contextmanager
def running_node(command: Sequence[str]) -> Iterator[can.BusABC]:
    """Run the node's firmware; gives the bus at the other end of its UART.

    However the block is left, the emulator is gone afterwards.

    Args:
        command: the emulator's.

    Raises:
        ToolError: the emulator or the firmware does not start, or ended by itself.
    """
    with ExitStack() as stack:
        errors = stack.enter_context(tempfile.TemporaryFile())
        controlling, terminal = raw_terminal()
        stack.callback(os.close, terminal)
        try:
            process = _start(command, controlling, controlling, errors)
        finally:
            os.close(controlling)
        stack.callback(_stop, process)
        if not select.select([terminal], [], [], _START)[0] or not os.read(terminal, 1):
            _stop(process)
            raise _ended(command, process, errors)
        yield stack.enter_context(BlockSlcanBus(os.ttyname(terminal)))
        if _hung_up(terminal):
            process.wait(_GRACE)
        if process.poll() is not None:
            raise _ended(command, process, errors)


def run_to_end(command: Sequence[str], silence: float, on_line: Callable[[str], None]) -> None:
    """Run firmware that prints lines over its UART and ends by itself, however long it takes.

    Args:
        command: the emulator's.
        silence: seconds without a line after which it is stopped.
        on_line: called with each whole line as it comes.

    Raises:
        ToolError: it does not start, fell silent, or ended with a status other than 0.
    """
    with tempfile.TemporaryFile() as errors:
        process = _start(command, subprocess.DEVNULL, subprocess.PIPE, errors)
        try:
            assert process.stdout is not None
            for line in _lines(process.stdout, silence):
                on_line(line.decode("ascii", errors="replace").rstrip())
            with suppress(subprocess.TimeoutExpired):
                process.wait(_GRACE)
        except TimeoutError as error:
            raise ToolError(
                f"{command[0]}: the firmware printed no line for {silence:g} s and was stopped"
            ) from error
        finally:
            _stop(process)
        if process.returncode != 0:
            raise _ended(command, process, errors)


def _lines(pipe: IO[bytes], silence: float) -> Iterator[bytes]:
    """Whole lines as they come; a last one without its end is none of the firmware's.

    Raises:
        TimeoutError: no line came for so many seconds.
    """
    rest = b""
    while select.select([pipe], [], [], silence)[0]:
        data = os.read(pipe.fileno(), 1 << 16)
        if not data:
            return
        *lines, rest = (rest + data).split(b"\n")
        yield from lines
        if len(rest) > _LONGEST_LINE:
            yield rest  # which says what was printed instead
            return
    raise TimeoutError


def _start(
    command: Sequence[str], stdin: int, stdout: int, errors: IO[bytes]
) -> subprocess.Popen[bytes]:
    # An emulator outlives a parent that was killed, and would idle for ever.
    guard = ["setpriv", "--pdeathsig", "KILL"] if shutil.which("setpriv") else []
    try:
        if os.sep in command[0] and not os.access(command[0], os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return subprocess.Popen([*guard, *command], stdin=stdin, stdout=stdout, stderr=errors)
    except OSError as error:
        raise ToolError(f"{command[0]}: {not_run(Path(command[0]), error)}") from error


def _hung_up(terminal: int) -> bool:
    """Whether the other end of the line is closed, as it is before its process has ended."""
    line = select.poll()
    line.register(terminal, 0)
    return any(event & select.POLLHUP for _, event in line.poll(0))


def _stop(process: subprocess.Popen[bytes]) -> None:
    if process.stdout is not None:
        process.stdout.close()
    if process.poll() is None:
        process.kill()
        process.wait()


def _ended(
    command: Sequence[str], process: subprocess.Popen[bytes], errors: IO[bytes]
) -> ToolError:
    errors.seek(0)
    said = errors.read().decode(errors="replace").strip().splitlines()
    status = process.returncode
    how = f"ended with status {status}" if status >= 0 else "did not answer and was stopped"
    return ToolError(f"{command[0]}: the firmware {how}{': ' + said[-1] if said else ''}")
