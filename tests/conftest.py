import signal


def pytest_configure():
    """Make Ctrl-C work even where the shell started the tests with interrupts ignored.

    A shell starts background jobs that way, and children inherit it: tests that interrupt a
    program would wait for ever.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
