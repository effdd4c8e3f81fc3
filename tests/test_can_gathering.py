"""The gatherer makes of any traffic what the node's C makes of it."""

import ctypes
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ccgen.can.gathering import Gatherer
from ccgen.can.transports.library import _Node
from ccgen.export.package import export
from ccgen.targets.exported import open_exported
from ccgen.targets.host import compile_shared

SHOULDER = Path(__file__).resolve().parent.parent / "examples" / "shoulder.toml"
COUNTERS = (
    "snapshots", "corrupted", "malformed", "repeated", "reordered", "lost", "late", "estimates",
    "failures", "overruns",
)  # fmt: skip
CYCLE = 10_000
VARIANTS = {
    "turn": lambda text: text,
    "no turn": lambda text: text.replace("cycle_ms = 10", "cycle_ms = 10\nturn = false"),
    "three frames": lambda text: text.replace("count = 3", "count = 4"),
}


@pytest.fixture(scope="module", params=VARIANTS)
def built(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("gathering")
    (folder / "shoulder.toml").write_text(VARIANTS[request.param](SHOULDER.read_text()))
    export(folder / "shoulder.toml", folder / "shoulder")
    exported = open_exported(folder / "shoulder")
    return exported, compile_shared(exported.directory, folder)


def traffic(layout, random):
    """Frames of some numbers near each other, mostly in order, with pauses: (us, slot, number, x).

    x tells contents of one place apart.
    """
    now, number = 0, int(random.integers(layout.numbers))
    for _ in range(400):
        now += int(random.choice([50, 200, 3000, 9900, 10_000, 10_200, 31_000, 45_000],
                                 p=[0.3, 0.3, 0.1, 0.1, 0.1, 0.06, 0.02, 0.02]))  # fmt: skip
        number += int(random.choice([0, 1, 2, -1, 7, -20, 119, 120], p=[
            0.55, 0.3, 0.04, 0.04, 0.02, 0.02, 0.02, 0.01,
        ]))  # fmt: skip
        slot = int(random.integers(layout.lengths_frames))
        yield now, slot, number % layout.numbers, int(random.integers(2))


def counters(node):
    found = (ctypes.c_uint32 * len(COUNTERS))()
    node._functions.ccgen_shared_node_counters(node._state, found)
    return dict(zip(COUNTERS, found, strict=True))


@pytest.mark.parametrize("seed", range(12))
def test_any_traffic_is_gathered_as_the_node_gathers_it(built, seed):
    exported, library = built
    layout, codec = exported.layout, exported.codec
    node = _Node(library, layout)
    node._functions.ccgen_shared_node_set_window(node._state, CYCLE)
    gatherer = Gatherer(layout, layout.lengths_frames, 1e-6 * CYCLE)
    begun, done, last = [], [], counters(node)
    for now, slot, number, content in traffic(layout, np.random.default_rng(seed)):
        counts = [100 * number + 10 * j + content for j in range(len(layout.sensors))]
        message = codec.encode(counts, number)[slot]
        completes = node.receive(message, now)
        decoded = codec.decode(message)
        gatherer.tick(1_700_000_000 + 1e-6 * now)
        before = gatherer.newest.complete
        started, fault = gatherer.take(slot, number, decoded.values)
        begun += [started] if started is not None else []
        finished = gatherer.newest.complete and not (before and started is None)
        assert completes == (finished and fault is None)
        done += [replace(gatherer.newest)] if completes else []
        found = counters(node)
        changed = {name for name in COUNTERS if found[name] != last[name]}
        last = found
        told = {fault} - {None}
        assert changed & {"reordered", "repeated"} == told - {"late"}
        assert "late" not in changed or fault == "late"
    assert len(done) == last["snapshots"] > 2
    skipped = sum(one.skipped for one in begun)
    cut_short = sum(not one.complete and "some_lost" in one.faults for one in begun)
    assert last["lost"] >= skipped
    assert last["lost"] <= skipped + cut_short
