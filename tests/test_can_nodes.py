"""The exported C as a node: both transports, every angle bit for bit, and what it makes of errors.

The clock of the library's node advances with snapshots only, so these tests do not depend on the
speed of the machine.
"""

import subprocess
import threading
import time
from dataclasses import dataclass
from functools import reduce
from itertools import takewhile
from operator import or_
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text
from waiting import PATIENCE

from ccgen.can.codec import status_of
from ccgen.can.exchange import Pace, exchange
from ccgen.can.layout import FAULTS
from ccgen.can.transports.library import library_node
from ccgen.can.transports.process import process_node
from ccgen.errors import ToolError
from ccgen.export.package import export
from ccgen.fixedpoint.guarded import DEGRADED, GOOD, LOST
from ccgen.kinematics import tip_pose
from ccgen.sensing.counts import corner_counts, random_counts
from ccgen.targets.compiler import sources
from ccgen.targets.exported import Exported, open_exported
from ccgen.targets.host import compile_process, compile_shared

STALE = 1 << FAULTS.index("STALE")
CAN = "[can]\nbase_id = {base_id}\nextended = {extended}\nfd = {fd}\n"
VARIANTS = {
    "classic": (
        {"step": 1e-6, "precision": 16},
        CAN.format(base_id="0x123", extended="false", fd="false"),
    ),
    "fd 24-bit": (
        {"bits": 24, "step": 1e-9, "precision": 32},
        CAN.format(base_id="0x18FF0000", extended="true", fd="true"),
    ),
}
FINGER = {
    "name": "finger", "segments": 5, "count": 2, "length": 0.1, "range_of_motion": 4.0,
    "radius": 0.01,
}  # fmt: skip


@dataclass(frozen=True)
class Built:
    exported: Exported
    library: Path
    program: Path

    @property
    def counts(self):
        axes = (self.exported.model.u, self.exported.model.v)
        return np.concatenate([corner_counts(axes), random_counts(axes, 300)])


@pytest.fixture(scope="module", params=VARIANTS)
def built(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("node")
    numbers, can = VARIANTS[request.param]
    joint = folder / "finger.toml"
    joint.write_text(joint_text(**FINGER, **numbers, tables=can), encoding="utf-8")
    export(joint, folder / "finger")
    exported = open_exported(folder / "finger")
    return Built(
        exported,
        compile_shared(exported.directory, folder),
        compile_process(exported.directory, folder),
    )


def node(built, kind):
    if kind == "library":
        return library_node(built.library, built.exported.layout)
    return process_node(built.program)


@pytest.mark.parametrize("kind", ["library", "process"])
@pytest.mark.parametrize("in_flight", [1, 8])
def test_every_angle_is_the_models_and_no_frame_is_lost(built, kind, in_flight):
    with node(built, kind) as bus:
        pace = Pace(in_flight=in_flight, timeout=PATIENCE)
        result = exchange(bus, built.exported.codec, built.counts, pace)
    assert (result.lost_frames, result.corrupted, result.unexpected) == (0, 0, 0)
    np.testing.assert_array_equal(result.angles, built.exported.model.estimate(built.counts))
    assert result.statuses[-1].sample_counter == len(built.counts)


@pytest.mark.parametrize("kind", ["library", "process"])
def test_the_tip_is_where_the_angles_put_it(built, kind):
    exported = built.exported
    with node(built, kind) as bus:
        result = exchange(bus, exported.codec, built.counts, Pace(timeout=PATIENCE))
    split = exported.model.segments
    u, v = result.angles[:, :split], result.angles[:, split:]
    angles = exported.model.u.radians(u), exported.model.v.radians(v)
    true = tip_pose(*angles, exported.joint.geometry.segment_length)[:, :3, 3]
    metres = result.tips * 2.0**-exported.layout.tip_fraction_bits
    assert np.abs(metres - true).max() <= 0.6 * 2.0**-exported.layout.tip_fraction_bits


@pytest.mark.parametrize(("out", "state"), [([3], DEGRADED), ([2, 3], LOST)])
def test_counts_out_of_range_degrade_or_lose_their_axis_alone(built, out, state):
    model, codec = built.exported.model, built.exported.codec
    counts = np.full((3, 4), 7)
    counts[1, out] = model.v.maximum[1] + 1
    with library_node(built.library, built.exported.layout) as bus:
        result = exchange(bus, codec, counts, Pace(in_flight=1, timeout=PATIENCE))
    followed = built.exported.guarded.follow(counts)
    assert result.lost_frames == 0
    assert followed.states.tolist() == [[GOOD, GOOD], [GOOD, state], [GOOD, GOOD]]
    np.testing.assert_array_equal(result.angles, followed.values)
    u, v = np.split(result.angles, 2, axis=1)
    assert (u == u[0]).all()
    assert ((v[1] == -(2 ** (model.precision - 1))).all()) == (state == LOST)
    assert ((result.tips[1] == -32768).all()) == (state == LOST)
    reported = [s for s in result.statuses if s.missing_sensors]
    assert {s.missing_sensors for s in reported} == {sum(1 << 6 + j for j in out)}
    assert reported[0].faults & ~STALE == 1 << FAULTS.index("MISSING")


def spoilt(frames):
    frames[0].data[3] ^= 1
    return frames[:1]


def shortened(frames):
    length = 12 if frames[0].is_fd else 7
    frames[0].data, frames[0].dlc = frames[0].data[:length], length
    return frames[:1]


@pytest.mark.parametrize(
    ("traffic", "fault", "snapshots"),
    [
        (lambda frames: spoilt(frames(0)), "CRC", 0),
        (lambda frames: shortened(frames(0)), "FORMAT", 0),
        (lambda frames: frames(0) + frames(0), "REPEATED", 1),
        (lambda frames: frames(5) + frames(4), "REORDERED", 1),
        (lambda frames: frames(0) + frames(3), "LOST", 2),
    ],
)
def test_the_status_says_what_was_wrong_with_the_traffic(built, traffic, fault, snapshots):
    codec = built.exported.codec
    with library_node(built.library, built.exported.layout) as bus:
        for frame in traffic(lambda counter: codec.encode([1, 2, 3, 4], counter)):
            bus.send(frame)
        statuses = []
        while len(statuses) < 5:
            decoded = codec.decode(bus.recv(PATIENCE))
            statuses += [status_of(decoded)] if decoded.kind == "status" else []
    reported = reduce(or_, (status.faults for status in statuses))
    assert reported & ~STALE == 1 << FAULTS.index(fault)
    assert statuses[-1].sample_counter == snapshots


@pytest.mark.parametrize("kind", ["library", "process"])
def test_a_sender_that_is_held_up_within_a_snapshot_loses_nothing(built, kind):
    exported = built.exported
    frames = exported.codec.encode([1, 2, 3, 4], 0)
    with node(built, kind) as bus:
        bus.send(frames[0])
        time.sleep(0.1)  # ten cycles
        for frame in frames[1:]:
            bus.send(frame)
        received = (exported.codec.decode(bus.recv(PATIENCE)) for _ in range(1000))
        before_tip = [decoded.kind for decoded in takewhile(lambda d: d.kind != "tip", received)]
    assert before_tip.count("angles") == exported.layout.angles_frames


def test_a_library_that_is_none_is_named(tmp_path, built):
    path = tmp_path / "libjoint.so"
    path.write_bytes(b"no library")
    with (
        pytest.raises(ToolError, match="cannot be loaded"),
        library_node(path, built.exported.layout),
    ):
        pass


def test_no_thread_stays_behind(built):
    before = set(threading.enumerate())
    with (
        pytest.raises(RuntimeError, match="mine"),
        library_node(built.library, built.exported.layout),
    ):
        raise RuntimeError("mine")
    assert set(threading.enumerate()) <= before


START = """
#include <string.h>
#include "finger_can.h"
int main(void) {
    static finger_node_t zeros, ones;
    memset(&zeros, 0, sizeof zeros);
    memset(&ones, 255, sizeof ones);
    if (finger_node_init(&zeros) != CCGEN_OK || finger_node_init(&ones) != CCGEN_OK) {
        return 2;
    }
    __builtin_clear_padding(&zeros);
    __builtin_clear_padding(&ones);
    return memcmp(&zeros, &ones, sizeof zeros) != 0;
}
"""


def test_a_node_starts_alike_whatever_its_memory_held(built, tmp_path):
    directory = built.exported.directory
    (tmp_path / "start.c").write_text(START)
    files = [*sources(directory), tmp_path / "start.c"]
    command = ["gcc", f"-I{directory / 'src'}", *map(str, files), "-o", str(tmp_path / "start")]
    subprocess.run(command, check=True)
    assert subprocess.run([tmp_path / "start"], check=False).returncode == 0
