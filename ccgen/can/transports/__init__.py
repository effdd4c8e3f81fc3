"""Ways to a node: this process, another one, an emulator's UART, a bus."""

import logging
import os
from pathlib import Path

# Errors are ours to tell; without a handler of its own python-can's log is printed beside them.
logging.getLogger("can").addHandler(logging.NullHandler())


def not_run(program: Path, error: OSError) -> str:
    """Why a program or a library that was compiled cannot be run, and what to do about it."""
    reason = error.strerror.lower() if error.strerror else str(error)
    try:
        forbidden = os.statvfs(program.parent).f_flag & os.ST_NOEXEC
    except (OSError, AttributeError):  # Windows has no such flag
        forbidden = 0
    if not forbidden:
        return reason
    return f"{reason}: no program may run there; set TMPDIR to a folder where programs may"


def gone_because(error: Exception) -> str:
    """Why nothing can be received any more, on one line, with the system's own reason."""
    causes = [error, *filter(None, (error.__cause__, error.__context__))]
    reasons = [str(getattr(cause, "strerror", None) or cause) for cause in causes]
    words = dict.fromkeys(" ".join(reason.split()) for reason in reasons if reason)
    return ": ".join(words) or type(error).__name__
