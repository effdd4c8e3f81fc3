import os
import signal

from hypothesis import HealthCheck, settings

# The same examples in every run, and as much time for each as a busy machine takes.
settings.register_profile(
    "ccgen",
    derandomize=True,
    database=None,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("ccgen")

os.environ["COLUMNS"] = "80"  # of tables, here and in programs that are run


def pytest_configure():
    """Make Ctrl-C work even where the shell started the tests with interrupts ignored.

    A shell starts background jobs that way, and children inherit it: tests that interrupt a
    program would wait for ever.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
