"""Logs that commands write while they run."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.errors import InputError
from ccgen.outputs import interruptible

if TYPE_CHECKING:
    from ccgen.can.logs import Log


@contextmanager
def open_log(path: Path | None, source: str | None) -> Iterator["Log | None"]:
    """Open a log that is closed properly at the end, at Ctrl-C and at SIGTERM; None without one.

    Raises:
        InputError: its ending is unknown, or it would replace the file that is read.
    """
    if path is None:
        yield None
        return
    from ccgen.can.logs import frame_log

    if source is not None and path.exists() and Path(source).exists() and path.samefile(source):
        raise InputError(f"--log: {path} is what is read; choose another file")
    with interruptible(), frame_log(path) as log:
        yield log
