"""Work spread over processes of this machine, or over a Dask cluster.

Either way it is a `concurrent.futures` executor; results do not depend on which, nor on the order
in which pieces finish.
"""

import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from ccgen.errors import InputError, ToolError

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def processes(count: int | None = None) -> Iterator[Executor]:
    """Give an executor of so many processes; by default one for each processor.

    Linear algebra runs on one thread in each: more would contend for the same processors.

    Raises:
        InputError: fewer than one process.
    """
    if count is not None and count < 1:
        raise InputError(f"--processes: {count} processes do nothing; give at least 1")
    from multiprocessing import active_children, get_context

    # Spawned processes read these when they load the libraries.
    with _environment(dict.fromkeys(_THREADS, "1")):
        executor = ProcessPoolExecutor(count or _processors(), get_context("spawn"), _begin_work)
        others = set(active_children())
        try:
            with _cancelled_on_error(executor):
                yield executor
        except BaseException:
            # Joints in work would keep the program from ending.
            for worker in set(active_children()) - others:
                worker.terminate()
            raise


@contextmanager
def cluster(address: str, timeout: float = 10.0) -> Iterator[Executor]:
    """Give an executor on the workers of a Dask scheduler, which need ccgen installed.

    Args:
        address: the scheduler's.
        timeout: how long to wait for it to answer, seconds.

    Raises:
        ToolError: Dask is not installed; InputError: no scheduler answers there.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise ToolError(
            "--scheduler needs Dask, which is not installed; pip install 'ccgen[distributed]'"
        ) from error
    try:
        connect: Any = Client  # untyped
        client = connect(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler: no Dask scheduler answers at {address};"
            " give the address that it prints, such as tcp://192.0.2.1:8786"
        ) from error
    with client, _cancelled_on_error(client.get_executor(pure=False)) as executor:
        yield executor


def _processors() -> int:
    """Processors that this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _cancelled_on_error(executor: Executor) -> Iterator[Executor]:
    """Shut an executor down; at once and without what is queued when the block raises."""
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
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
