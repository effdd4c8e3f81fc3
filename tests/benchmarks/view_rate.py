"""Updates a second that reach the socket of `ccgen.view`, of a joint of 48 segments.

A client takes all messages of the page for some seconds while it is shown a new state every 5 ms,
and counts those that move the joint. Needs ccgen[view]:

    python tests/benchmarks/view_rate.py
"""

import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from viewer import moves, viewer

import ccgen
from ccgen.sensing.bending import Bending
from ccgen.view.page import open_page
from ccgen.view.sight import Bends
from ccgen.view.simulated import as_found, simulated_sights

SPINE = Path(__file__).resolve().parents[2] / "examples" / "spine.toml"
SECONDS = 5.0
LEAST = 30.0
"""Updates a second."""


def scaled(bends: Bends, share: float) -> Bends:
    """Another state each time: what has not changed is not sent."""
    return Bends(share * bends.u, share * bends.v, bends.h)


def main() -> None:
    """Print what came; status 1 where it is too little."""
    fit = ccgen.fit(ccgen.load(SPINE))
    joint = as_found(fit)
    bending = Bending("end-force", joint.geometry.range_of_motion)
    (sight,) = simulated_sights(fit, [bending.at(joint)])
    ended = threading.Event()
    with open_page(joint, "the simulated shape") as page, viewer(page.url) as batch:

        def show() -> None:
            begin = time.monotonic()
            while not ended.wait(0.005):
                now = time.monotonic() - begin
                page.show(replace(sight, t=now, estimate=scaled(sight.estimate, np.sin(7.0 * now))))

        shown = threading.Thread(target=show)
        shown.start()
        begin, batches, messages, updates = time.monotonic(), 0, 0, 0
        spent = time.process_time()
        while time.monotonic() - begin < SECONDS:
            found = batch()
            batches, messages = batches + 1, messages + len(found)
            updates += any(map(moves, found))
        spent = time.process_time() - spent
        ended.set()
        shown.join()
    print(f"{joint.geometry.segments} segments, {len(joint.sensors)} sensors")
    print(f"{updates / SECONDS:.1f} updates a second in {batches / SECONDS:.1f} packets")
    print(f"{messages / max(updates, 1):.1f} messages an update")
    print(f"{1e3 * spent / max(updates, 1):.1f} ms of a processor an update, the client's included")
    if updates / SECONDS < LEAST:
        sys.exit(f"fewer than {LEAST:g} a second")


if __name__ == "__main__":
    main()
