"""Two exported joints in one program on an emulated Cortex-M4, on one line."""

import itertools
import os
import shutil
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

import can
import numpy as np
import pytest
from waiting import PATIENCE

from ccgen.can.codec import Decoded, status_of
from ccgen.can.layout import FAULTS
from ccgen.export.package import export
from ccgen.targets.emulator import running_node
from ccgen.targets.exported import Exported, open_exported
from ccgen.targets.inputs import bus_counts

EXAMPLES = Path(__file__).parent.parent / "examples"
SNAPSHOTS = 300
IN_FLIGHT = 4
STALE = 1 << FAULTS.index("STALE")
MISSING = 1 << FAULTS.index("MISSING")
PACKAGES = {
    "cmake": "cmake", "arm-none-eabi-gcc": "gcc-arm-none-eabi",
    "qemu-system-arm": "qemu-system-arm",
}  # fmt: skip


@dataclass
class Answers:
    """What came back from one joint, by snapshot, kind and number of the frame."""

    exported: Exported
    frames: dict[tuple[int, str, int], tuple[int, ...]] = field(default_factory=dict)
    statuses: list[Decoded] = field(default_factory=list)
    repeated: int = 0

    @property
    def expected_frames(self) -> int:
        return SNAPSHOTS * (self.exported.layout.angles_frames + 1)

    def take(self, message: can.Message, sent: int) -> bool:
        """Decode a frame; False if it is another joint's."""
        decoded = self.exported.codec.decode(message)
        if decoded is None:
            return False
        if decoded.kind == "status":
            self.statuses.append(decoded)
            return True
        if decoded.kind == "health":
            return True
        numbers = self.exported.layout.numbers
        snapshot = sent - 1 - (sent - 1 - decoded.number) % numbers
        key = (snapshot, decoded.kind, decoded.index)
        self.repeated += key in self.frames
        self.frames[key] = decoded.values
        return True

    def angles(self) -> np.ndarray:
        parts = range(self.exported.layout.angles_frames)
        return np.array(
            [
                list(itertools.chain(*(self.frames[k, "angles", part] for part in parts)))
                for k in range(SNAPSHOTS)
            ]
        )


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """The example's project with both folders exported, built for the Cortex-M4."""
    for program, package in PACKAGES.items():
        assert shutil.which(program), f"needs {program}; install the Debian package {package}"
    folder = tmp_path_factory.mktemp("examples")
    shutil.copytree(EXAMPLES / "cmake", folder / "cmake")
    shutil.copytree(EXAMPLES / "two_joints", folder / "two_joints")
    for name in ("shoulder", "wrist"):
        export(EXAMPLES / f"{name}.toml", folder / "two_joints" / name)
    configure = [
        "cmake", "-S", "two_joints", "-B", "build", "-DCMAKE_BUILD_TYPE=MinSizeRel",
        f"-DCMAKE_TOOLCHAIN_FILE={folder / 'cmake' / 'cortex-m4.cmake'}",
    ]  # fmt: skip
    strict = os.environ | {"CFLAGS": "-Wall -Wextra -Wconversion -Wdouble-promotion -Werror"}
    for command in (configure, ["cmake", "--build", "build", "--parallel", "2"]):
        done = subprocess.run(
            command, cwd=folder, env=strict, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_two_joints_share_one_runtime_and_each_brings_its_own_estimator(project):
    listing = ["arm-none-eabi-nm", "--defined-only", project / "build" / "firmware.elf"]
    out = subprocess.run(listing, capture_output=True, text=True, check=True).stdout
    names = [line.split()[2] for line in out.splitlines()]
    for symbol in ("ccgen_crc8_table", "shoulder_estimate", "wrist_estimate"):
        assert names.count(symbol) == 1
    runtimes = list((project / "build").rglob("libccgen_runtime*.a"))
    assert len(runtimes) == 1


def test_two_joints_on_one_bus_answer_every_interleaved_snapshot_bit_for_bit(project):
    joints = [open_exported(project / "two_joints" / name) for name in ("shoulder", "wrist")]
    assert len({(j.model.segments, j.model.v.sensors) for j in joints}) == 2
    counts = [bus_counts(j, SNAPSHOTS, seed=11 + k) for k, j in enumerate(joints)]
    answers = [Answers(j) for j in joints]
    command = [
        "qemu-system-arm", "-M", "mps2-an386", "-display", "none", "-monitor", "none",
        "-serial", "stdio", "-semihosting-config", "enable=on,target=native",
        "-kernel", str(project / "build" / "firmware.elf"),
    ]  # fmt: skip
    with running_node(command) as bus:
        strangers = converse(bus, answers, counts)
    assert strangers == 0
    for answer, sent in zip(answers, counts, strict=True):
        guarded, layout = answer.exported.guarded, answer.exported.layout
        lacking = guarded.missing(sent) @ (1 << np.array(layout.missing_bits))
        assert np.unique(lacking).size > 5
        statuses = [status_of(decoded) for decoded in answer.statuses]
        # A busy host pauses between snapshots for longer than a node likes; nothing else is wrong.
        assert {status.faults & ~STALE for status in statuses} == {0, MISSING}
        assert answer.repeated == 0
        assert len(answer.frames) == answer.expected_frames
        assert np.array_equal(answer.angles(), guarded.follow(sent).values)
        assert statuses[-1].sample_counter == SNAPSHOTS
        assert {status.missing_sensors for status in statuses} <= {*lacking.tolist(), 0}


def converse(bus: can.BusABC, answers: list[Answers], counts: list[np.ndarray]) -> int:
    """Send both joints' snapshots frame by frame in turn; returns frames that are nobody's."""
    sent = strangers = 0
    deadline = time.monotonic() + 5 * PATIENCE
    while not all(finished(answer) for answer in answers) and time.monotonic() < deadline:
        if sent < SNAPSHOTS and all(in_flight(answer, sent) < IN_FLIGHT for answer in answers):
            for message in interleaved(answers, counts, sent):
                bus.send(message, timeout=PATIENCE)
            sent += 1
            continue
        message = bus.recv(0.5)
        if message is not None:
            strangers += not any(answer.take(message, sent) for answer in answers)
    return strangers


def interleaved(answers: list[Answers], counts: list[np.ndarray], k: int) -> list[can.Message]:
    frames = [
        answer.exported.codec.encode(each[k].tolist(), number=k % answer.exported.layout.numbers)
        for answer, each in zip(answers, counts, strict=True)
    ]
    turns = itertools.zip_longest(*frames)
    return [message for turn in turns for message in turn if message is not None]


def in_flight(answer: Answers, sent: int) -> int:
    """Snapshots whose answer has not come in full."""
    return sent - len(answer.frames) // (answer.exported.layout.angles_frames + 1)


def finished(answer: Answers) -> bool:
    """Whether every frame came, and a status that knows the last snapshot."""
    reported = answer.statuses and status_of(answer.statuses[-1]).sample_counter == SNAPSHOTS
    return len(answer.frames) == answer.expected_frames and bool(reported)
