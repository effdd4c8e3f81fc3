"""What `ccgen bridge --json-lines` prints while it runs: snapshots as `ccgen monitor` does."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import can

from ccgen.can.codec import Codec, read_database
from ccgen.can.logs import Log
from ccgen.can.monitor import Monitor
from ccgen.can.seen import Seen, plain
from ccgen.cli.output import print_json
from ccgen.errors import InputError
from ccgen.targets.exported import Exported


@contextmanager
def snapshot_lines(exported: Exported, log: Log | None) -> Iterator[Log]:
    """Print a line for every snapshot out of the frames that pass, and pass them on to a log."""
    database = read_database(exported.directory / f"{exported.joint.name}.dbc")
    codec = Codec(exported.layout, database)  # of its own, which counts its own errors
    watch = Monitor(exported.guarded, codec, exported.fingerprint)
    strange = False

    def show(snapshots: Iterable[Seen]) -> None:
        for seen in snapshots:
            print_json(plain(seen, exported.model, exported.layout))
            sys.stdout.flush()

    def take(message: can.Message) -> None:
        nonlocal strange
        if log is not None:
            log(message)
        try:
            if not strange:
                show(watch.take(message))
        except InputError:
            strange = True  # a node of another model, which the summary tells

    yield take
    if not strange:
        show(watch.finish())
