"""Exact instructions of the calls of a joint, counted in an emulated core."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ccgen.cost.emulator import Program
from ccgen.cost.harness import REPEATS, results_of
from ccgen.cost.snapshots import snapshots
from ccgen.errors import CheckError
from ccgen.targets.exported import Exported


@dataclass(frozen=True)
class Checks:
    """The most that holding sensors against each other took, beside an estimate.

    Attributes:
        quiet: where a snapshot's sensors clearly agree.
        examined: where those of as many groups as can be contradict each other.
    """

    quiet: int
    examined: int


@dataclass(frozen=True)
class Times:
    """The most that each call took over the snapshots of the harness.

    Attributes:
        estimate: of all axes.
        tip_pose: of the estimated angles.
        frame: received, without completing a snapshot.
        receive: all frames of a snapshot, without estimate, check and tip pose.
        transmit: all frames that answer it, and the call that says there are no more.
        health: a HEALTH frame fetched, which belongs to no snapshot; 0 where none is sent.
        snapshot: its frames in, the estimate and the tip pose, all answers out, without HEALTH;
            where sensors are checked, of a quiet one.
        unit: "instructions" or "cycles".
        checks: None where no sensors are checked.
        functions: of the user's own, by name; part of no snapshot.
        jacobian: the tip Jacobian in integers, part of no snapshot either.
    """

    estimate: int
    tip_pose: int
    frame: int
    receive: int
    transmit: int
    health: int
    snapshot: int
    jacobian: int
    unit: str
    checks: Checks | None = None
    functions: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, spent: "Sequence[Spent]", examined: "Sequence[Examined]", unit: str) -> "Times":
        """The most of several snapshots."""
        most = {name: max(getattr(one, name) for one in spent) for name in _COUNTED}
        functions = {name: max(one.functions[name] for one in spent) for name in spent[0].functions}
        checks = None
        if examined:
            checks = Checks(max(one.check for one in spent), max(one.check for one in examined))
            most["estimate"] = max(most["estimate"], *(one.estimate for one in examined))
        return cls(**most, unit=unit, checks=checks, functions=functions)


@dataclass(frozen=True)
class Spent:
    """What one snapshot took, in parts.

    Attributes:
        estimate, tip_pose, frame, transmit, health: as of `Times`.
        received: by the calls that took its frames, the last with estimate and tip pose in it.
        functions: of the user's own, by name, of its angles.
        follow: estimate and check together; None where no sensors are checked.
        jacobian: as of `Times`.
    """

    estimate: int
    tip_pose: int
    frame: int
    received: int
    transmit: int
    health: int
    functions: Mapping[str, int]
    follow: int | None
    jacobian: int

    @property
    def check(self) -> int:
        """As of `Checks`; 0 where no sensors are checked."""
        return 0 if self.follow is None else self.follow - self.estimate

    @property
    def receive(self) -> int:
        """As of `Times`."""
        return self.received - self.estimate - self.check - self.tip_pose

    @property
    def snapshot(self) -> int:
        """As of `Times`."""
        return self.received + self.transmit


@dataclass(frozen=True)
class Examined:
    """What an examined snapshot took: its estimate, and at most with the check."""

    estimate: int
    follow: int

    @property
    def check(self) -> int:
        """As of `Checks`."""
        return self.follow - self.estimate


_COUNTED = (
    "estimate", "tip_pose", "frame", "receive", "transmit", "health", "snapshot", "jacobian",
)  # fmt: skip


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
    taken = snapshots(exported)
    size = program.size("cost_counts") // len(taken.all)
    counts = [program.address("cost_counts") + k * size for k in range(len(taken.all))]
    rows = len(taken.whole)
    spent = [_snapshot(exported, program, machine, k, counts[:rows]) for k in range(rows)]
    examined = [_examined(machine, one) for one in counts[rows:]]
    return Times.of(spent, examined, "instructions"), machine.stack_bytes


def _examined(machine: _Machine, counts: int) -> Examined:
    arguments = ("cost_joint", counts, "cost_angles")
    machine.call("init", "cost_joint")
    estimate, _ = machine.call("estimate", *arguments)
    follow = max(machine.call("follow", *arguments)[0] for _ in range(REPEATS))
    return Examined(estimate, follow)


def _snapshot(
    exported: Exported, program: Program, machine: _Machine, k: int, counts: Sequence[int]
) -> Spent:
    """What snapshot k takes, of those whose counts stand at some addresses."""
    frames = exported.layout.lengths_frames
    sent = program.address("cost_frames")
    frame_size = program.size("cost_frames") // (len(counts) * frames)
    now = k * exported.layout.cycle_us
    arguments = ("cost_joint", counts[k], "cost_angles")
    estimate, _ = machine.call("estimate", *arguments)
    checked = bool(exported.guarded.groups)
    follow = machine.call("follow", *arguments)[0] if checked else None
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
    jacobian, _ = machine.call("integer_tip_jacobian", "cost_angles", "cost_jacobian")
    functions = {
        function.name: machine.call(function.name, "cost_angles", *variables)[0]
        for function, variables in results_of(exported)
    }
    return Spent(estimate, tip_pose, frame, taken, answers, health, functions, follow, jacobian)


def _id_of(program: Program) -> int:
    """Identifier of the frame that was fetched last, the first field of its structure."""
    return int.from_bytes(program.read("cost_frame", 4), "little")
