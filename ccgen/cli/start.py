"""Where the program begins: nothing heavy is imported before its signals are in hand."""

import signal
import sys

from ccgen.outputs import terminate


def start() -> None:
    """Run the program; Ctrl-C and SIGTERM end it by way of every clean-up, in one line at most."""
    signal.signal(signal.SIGTERM, terminate)
    try:
        from ccgen.cli.main import main

        main()
    except KeyboardInterrupt:
        sys.stderr.write("ccgen: interrupted\n")
        sys.exit(130)
