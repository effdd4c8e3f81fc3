"""Where the program begins: nothing heavy is imported before its signals are in hand."""

import gc
import os
import signal
import sys

from ccgen.cli.terminal import Terminal
from ccgen.outputs import terminate

_YOUNG = 100_000
"""Objects between two collections of garbage."""

_LARGE = 32_000_000
"""Bytes of a block up to which freed memory is kept."""


def start() -> None:
    """Run the program; Ctrl-C and SIGTERM end it by way of every clean-up, in one line at most."""
    signal.signal(signal.SIGTERM, terminate)
    terminal = Terminal()
    status = _run()
    failure = terminal.finish()
    if failure is not None:
        reason = (failure.strerror or str(failure)).lower()
        sys.stderr.write(f"ccgen: error: {failure.filename}: {reason}\n")
        status = status or 2
    sys.exit(status)


def _run() -> int:
    _spare()
    try:
        from ccgen.cli.main import main

        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except KeyboardInterrupt:
        sys.stderr.write("ccgen: interrupted\n")
        return 130
    return 0


def _spare() -> None:
    """Leave out work that does nothing for a program that soon ends."""
    # What imports make is there to stay: it need not be searched for garbage again and again.
    gc.set_threshold(_YOUNG, *gc.get_threshold()[1:])
    # The allocator of glibc keeps freed memory up to the size of the largest block that was given
    # back, instead of asking for the same pages again; this one is never touched.
    bytes(_LARGE)
    # Plugins of pydantic are looked for in the metadata of everything that is installed.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
