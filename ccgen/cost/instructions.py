"""Exact instructions of the calls of a joint, counted in an emulated core."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ccgen.cost.emulator import Program
from ccgen.cost.harness import results_of, snapshots
from ccgen.errors import CheckError
from ccgen.targets.exported import Exported


@dataclass(frozen=True)
class Times:
    """The most that each call took over the snapshots of the harness.

    Attributes:
        estimate: of all axes.
        tip_pose: of the estimated angles.
        frame: received, without completing a snapshot.
        receive: all frames of a snapshot, without estimate and tip pose.
        transmit: all frames that answer it, and the call that says there are no more.
        health: a HEALTH frame fetched, which belongs to no snapshot; 0 where none is sent.
        snapshot: its frames in, the estimate and the tip pose, all answers out, without HEALTH.
        unit: "instructions" or "cycles".
        functions: of the user's own, by name; part of no snapshot.
    """

    estimate: int
    tip_pose: int
    frame: int
    receive: int
    transmit: int
    health: int
    snapshot: int
    unit: str
    functions: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, spent: "Sequence[Spent]", unit: str) -> "Times":
        """The most of several snapshots."""
        most = {name: max(getattr(one, name) for one in spent) for name in _COUNTED}
        functions = {name: max(one.functions[name] for one in spent) for name in spent[0].functions}
        return cls(**most, unit=unit, functions=functions)


@dataclass(frozen=True)
class Spent:
    """What one snapshot took, in parts.

    Attributes:
        estimate, tip_pose, frame, transmit, health: as of `Times`.
        received: by the calls that took its frames, the last with estimate and tip pose in it.
        functions: of the user's own, by name, of its angles.
    """

    estimate: int
    tip_pose: int
    frame: int
    received: int
    transmit: int
    health: int
    functions: Mapping[str, int]

    @property
    def receive(self) -> int:
        """As of `Times`."""
        return self.received - self.estimate - self.tip_pose

    @property
    def snapshot(self) -> int:
        """As of `Times`."""
        return self.received + self.transmit


_COUNTED = ("estimate", "tip_pose", "frame", "receive", "transmit", "health", "snapshot")


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
    return Times.of(taken, "instructions"), machine.stack_bytes


def _estimate(program: Program, machine: _Machine, k: int, rows: int) -> int:
    counts = program.address("cost_counts") + k * (program.size("cost_counts") // rows)
    return machine.call("estimate", "cost_joint", counts, "cost_angles")[0]


def _snapshot(exported: Exported, program: Program, machine: _Machine, k: int, rows: int) -> Spent:
    frames = exported.layout.lengths_frames
    sent = program.address("cost_frames")
    frame_size = program.size("cost_frames") // (rows * frames)
    now = k * exported.layout.cycle_us
    estimate = _estimate(program, machine, k, rows)
    tip_pose, _ = machine.call("integer_tip_pose", "cost_angles", "cost_pose")
    received = [
        machine.call("node_receive", "cost_node", sent + (k * frames + i) * frame_size, now)
        for i in range(frames)
    ]
    if received[-1][1] != 1:
        raise CheckError(f"{exported.joint.name}_node_receive: a whole snapshot gave no estimate")
    health_id = exported.layout.frames_of("health")[0].id
    answers, health, more = 0, 0, 1
    while more == 1:
        instructions, more = machine.call("node_transmit", "cost_node", now, "cost_frame")
        is_health = more == 1 and _id_of(program) == health_id
        health += instructions if is_health else 0
        answers += 0 if is_health else instructions
    # Once more: repeated, so that it completes nothing even where one frame is a snapshot.
    again, _ = machine.call("node_receive", "cost_node", sent + k * frames * frame_size, now)
    frame = max([again, *(taken for taken, _ in received[:-1])])
    taken = sum(taken for taken, _ in received)
    functions = {
        function.name: machine.call(function.name, "cost_angles", *variables)[0]
        for function, variables in results_of(exported)
    }
    return Spent(estimate, tip_pose, frame, taken, answers, health, functions)


def _id_of(program: Program) -> int:
    """Identifier of the frame that was fetched last, the first field of its structure."""
    return int.from_bytes(program.read("cost_frame", 4), "little")
