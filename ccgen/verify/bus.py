"""Verifies a node over the bus that it is on."""

import can
import numpy as np
from numpy.typing import NDArray

from ccgen.can.exchange import Answer, Pace, exchange
from ccgen.targets.exported import Exported
from ccgen.verify.compare import compare_exchange
from ccgen.verify.plan import Progress
from ccgen.verify.run import Run

_REPORT_EVERY = 256


def verify_bus(
    exported: Exported,
    bus: can.BusABC,
    counts: NDArray[np.int64],
    pace: Pace,
    report: Progress,
    target: str,
    transport: str,
) -> Run:
    """Send every snapshot and compare the answers with the reference models.

    Args:
        exported: the folder that the node was compiled from.
        bus: the host's end.
        counts: shape (k, nu + nv).
        pace: of the exchange.
        report: of progress.
        target, transport: for the record.
    """
    total = len(counts)

    def on_answer(answer: Answer) -> None:
        done = answer.index + 1
        if done % _REPORT_EVERY == 0 or done == total:
            report(f"{target}, {transport}", done, total)

    answers = exchange(bus, exported.codec, counts, pace, on_answer)
    return compare_exchange(exported, target, transport, counts, answers)
