"""Exact instructions of the calls of a joint, counted in an emulated core."""

from dataclasses import dataclass

from ccgen.cost.emulator import Program
from ccgen.cost.harness import snapshots
from ccgen.errors import CheckError
from ccgen.targets.exported import Exported


@dataclass(frozen=True)
class Times:
    """The most that each call took over the snapshots of the harness.

    Attributes:
        estimate: of both axes.
        tip_pose: of the estimated angles.
        frame: received, without completing a snapshot.
        snapshot: its frames in, the estimate and the tip pose, all answers out.
        unit: "instructions" or "cycles".
    """

    estimate: int
    tip_pose: int
    frame: int
    snapshot: int
    unit: str


class _Machine:
    """Calls the joint's functions and keeps the deepest stack of each."""

    def __init__(self, exported: Exported, program: Program) -> None:
        self._joint = exported.joint.name
        self._program = program
        self.stack_bytes = 0

    def call(self, function: str, *arguments: str | int) -> tuple[int, int]:
        """Return instructions and result of a call that must not fail."""
        done = self._program.call(f"{self._joint}_{function}", arguments)
        if done.result < 0:
            raise CheckError(f"{self._joint}_{function}: returned {done.result}")
        self.stack_bytes = max(self.stack_bytes, done.stack_bytes)
        return done.instructions, done.result


def count(exported: Exported, program: Program) -> tuple[Times, int]:
    """Count the instructions of every call; return them and the deepest stack seen, bytes.

    Raises:
        CheckError: a call failed.
    """
    machine = _Machine(exported, program)
    machine.call("init", "cost_joint")
    machine.call("node_init", "cost_node")
    rows = len(snapshots(exported))
    taken = [_snapshot(exported, program, machine, k, rows) for k in range(rows)]
    estimate, tip_pose, frame, snapshot = (max(column) for column in zip(*taken, strict=True))
    return Times(estimate, tip_pose, frame, snapshot, "instructions"), machine.stack_bytes


def _estimate(program: Program, machine: _Machine, k: int, rows: int) -> int:
    counts = program.address("cost_counts") + k * (program.size("cost_counts") // rows)
    return machine.call("estimate", "cost_joint", counts, "cost_angles")[0]


def _snapshot(
    exported: Exported, program: Program, machine: _Machine, k: int, rows: int
) -> tuple[int, int, int, int]:
    frames = exported.layout.lengths_frames
    sent = program.address("cost_frames")
    frame_size = program.size("cost_frames") // (rows * frames)
    now = k * exported.layout.cycle_us
    estimate = _estimate(program, machine, k, rows)
    tip_pose, _ = machine.call("tip_pose", "cost_angles", "cost_pose")
    received = [
        machine.call("node_receive", "cost_node", sent + (k * frames + i) * frame_size, now)
        for i in range(frames)
    ]
    if received[-1][1] != 1:
        raise CheckError(f"{exported.joint.name}_node_receive: a whole snapshot gave no estimate")
    answers, more = 0, 1
    while more == 1:
        instructions, more = machine.call("node_transmit", "cost_node", now, "cost_frame")
        answers += instructions
    # Once more: repeated, so that it completes nothing even where one frame is a snapshot.
    again, _ = machine.call("node_receive", "cost_node", sent + k * frames * frame_size, now)
    frame = max([again, *(taken for taken, _ in received[:-1])])
    return estimate, tip_pose, frame, sum(taken for taken, _ in received) + answers
