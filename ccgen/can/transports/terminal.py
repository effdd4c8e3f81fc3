"""Pseudo-terminals, which POSIX systems have and Windows has not."""

import os

from ccgen.errors import ToolError


def has_terminals() -> bool:
    """Whether this system has pseudo-terminals."""
    try:
        import tty  # noqa: F401
    except ImportError:
        return False
    return hasattr(os, "openpty")


def raw_terminal() -> tuple[int, int]:
    """Open a pseudo-terminal that passes bytes as they are.

    Returns:
        File descriptors of its controlling end and of the terminal.

    Raises:
        ToolError: this system has none.
    """
    if not has_terminals():
        raise ToolError("a line to a process needs a pseudo-terminal, which this system has not")
    import tty

    controlling, terminal = os.openpty()
    try:
        tty.setraw(terminal)
    except BaseException:
        os.close(controlling)
        os.close(terminal)
        raise
    return controlling, terminal
