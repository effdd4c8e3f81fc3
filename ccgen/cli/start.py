"""Where the program begins: nothing heavy is imported before its signals are in hand."""

import signal
import sys

from ccgen.cli.terminal import Terminal
from ccgen.outputs import terminate


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
    try:
        from ccgen.cli.main import main

        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except KeyboardInterrupt:
        sys.stderr.write("ccgen: interrupted\n")
        return 130
    return 0
