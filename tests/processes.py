"""What the system knows about processes, for tests of what starts and ends them."""

import os
from pathlib import Path


def runs(pid: int) -> bool:
    """Whether a process is there and has not ended."""
    state, _ = _state_and_parent(pid)
    return state not in ("", "Z", "X")


def children() -> set[int]:
    """Processes that this one has started and not waited for, whether they have ended or not."""
    found = (int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit())
    return {pid for pid in found if _state_and_parent(pid)[1] == os.getpid()}


def _state_and_parent(pid: int) -> tuple[str, int]:
    """As in `man 5 proc`; no state and no parent for a process that is gone."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):  # gone before or while it is read
        return "", 0
    state, parent = stat.rpartition(")")[2].split()[:2]
    return state, int(parent)
