"""Work spread over processes of this machine, or over a Dask cluster.

Either way it is a `concurrent.futures` executor; results do not depend on which, nor on the order
in which pieces finish.
"""

import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

from ccgen.errors import ArgumentError, ToolError

_RESUME = "finished joints are kept, and the same command studies the others"

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def on_processes(processes: int | None = None) -> Iterator[Executor]:
    """Give an executor of so many processes; by default one for each processor.

    Linear algebra runs on one thread in each: more would contend for the same processors.

    Raises:
        ArgumentError: fewer than one process; ToolError: one of them ended before its work was
            done.
    """
    if processes is not None and processes < 1:
        raise ArgumentError(f"{processes} do nothing; give at least 1", "processes")
    from multiprocessing import active_children, get_context

    # Spawned processes read these when they load the libraries.
    with _environment(dict.fromkeys(_THREADS, "1")):
        number = processes or _processors()
        executor = ProcessPoolExecutor(number, get_context("spawn"), _begin_work)
        others = set(active_children())
        cancel = partial(executor.shutdown, wait=False, cancel_futures=True)
        try:
            with _cancelled_on_error(executor, cancel):
                yield executor
        except BrokenProcessPool as error:
            raise ToolError(
                f"a process of the study was killed, maybe for want of memory; {_RESUME}"
                " (fewer processes need less)"
            ) from error
        except BaseException:
            # Joints in work would keep the program from ending.
            for worker in set(active_children()) - others:
                worker.terminate()
            raise


@contextmanager
def on_cluster(scheduler: str, timeout: float = 10.0) -> Iterator[Executor]:
    """Give an executor on the workers of a Dask scheduler, which need ccgen installed.

    Args:
        scheduler: its address.
        timeout: how long to wait for it to answer, seconds.

    Raises:
        ToolError: Dask is not installed, or the cluster was lost before the work was done;
            ArgumentError: no scheduler answers there.
    """
    try:
        from distributed import KilledWorker
        from distributed.client import ClosedClientError
        from distributed.comm.core import CommClosedError
    except ImportError as error:
        raise ToolError(
            "a cluster needs Dask, which is not installed; pip install 'ccgen[distributed]'"
        ) from error
    # A scheduler that is gone cancels what it had.
    lost = (CancelledError, ClosedClientError, CommClosedError, KilledWorker, TimeoutError)

    def cancel() -> None:
        with suppress(*lost):
            executor.shutdown(wait=False)

    try:
        with _client(scheduler, timeout) as client:
            executor = client.get_executor(pure=False)
            with _cancelled_on_error(executor, cancel):
                yield executor
    except lost as error:
        raise ToolError(
            f"the Dask cluster at {scheduler} was lost; {_RESUME} once a cluster is up again"
        ) from error


@contextmanager
def _client(scheduler: str, timeout: float) -> Iterator[Any]:
    """Give a client of a Dask scheduler, closed in the end even if it never got a connection.

    Raises:
        ArgumentError: no scheduler answers there.
    """
    from distributed import Client

    client: Any = Client.__new__(Client)  # untyped
    # What it would log about a lost scheduler, tracebacks included, is said in one line.
    logs = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [log.level for log in logs]
    for log in logs:
        log.setLevel(logging.CRITICAL)
    try:
        try:
            client.__init__(scheduler, timeout=timeout, set_as_default=False)
        except (ImportError, OSError, TypeError, ValueError) as error:
            raise ArgumentError(
                f"no Dask scheduler answers at {scheduler};"
                " give the address that it prints, such as tcp://192.0.2.1:8786",
                "scheduler",
            ) from error
        yield client
    finally:
        client.close()
        for log, level in zip(logs, levels, strict=True):
            log.setLevel(level)


def _processors() -> int:
    """Processors that this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _cancelled_on_error(executor: Executor, cancel: Callable[[], None]) -> Iterator[None]:
    """Shut an executor down; by `cancel`, without what is queued, when the block raises."""
    try:
        yield
    except BaseException:
        cancel()
        raise
    executor.shutdown()


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin_work() -> None:
    """Leave Ctrl-C to the parent, and end with it: a worker without would wait for ever."""
    from multiprocessing import parent_process

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
