"""What an exported folder costs on one target."""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ccgen.cost.instructions import Times, count
from ccgen.cost.program import JACOBIAN, calls_of, compile_measured
from ccgen.cost.size import FUNCTIONS, Size, read_map
from ccgen.cost.size import JACOBIAN as JACOBIAN_SIZE
from ccgen.cost.stack import read_disassembly, read_frames, worst_case
from ccgen.errors import CheckError
from ccgen.targets.compiler import LEVEL
from ccgen.targets.cores import COUNTED, core_named
from ccgen.targets.exported import Exported


@dataclass(frozen=True)
class Cost:
    """Cost of one folder on one target.

    Attributes:
        target: its name.
        level: of the compiler's optimisation.
        parts: bytes by part of what a node links, and nothing that it does not call, such as SLCAN
            or kinematics in floating point; the node includes the runtime, the library is the
            compiler's.
        state_bytes: RAM that the caller owns for a whole node: state, counts, angles.
        constants_in_ram: whether tables stand in RAM as well.
        stacks: worst case of each call, bytes.
        times: the most that each call took.
        functions: bytes of the user's own functions, beside those of a node.
        function_stacks: their worst case, bytes.
        jacobian: bytes of the tip Jacobian in integers, beside those of a node.
    """

    target: str
    level: str
    parts: dict[str, Size]
    state_bytes: int
    constants_in_ram: bool
    stacks: dict[str, int]
    times: Times
    functions: Size
    function_stacks: Mapping[str, int]
    jacobian: Size

    @property
    def code_bytes(self) -> int:
        """Code of a whole node."""
        return sum(part.code for part in self.parts.values())

    @property
    def constant_bytes(self) -> int:
        """Constants of a whole node."""
        return sum(part.constants for part in self.parts.values())

    @property
    def flash_bytes(self) -> int:
        """Code and constants of a whole node."""
        return self.code_bytes + self.constant_bytes

    @property
    def ram_bytes(self) -> int:
        """RAM of a whole node without its stack."""
        held = sum(part.variables for part in self.parts.values())
        return self.state_bytes + held + (self.constant_bytes if self.constants_in_ram else 0)

    @property
    def stack_bytes(self) -> int:
        """Worst case of all calls."""
        return max(self.stacks.values())

    def record(self) -> dict[str, Any]:
        """Plain values for JSON; `unit` says what `instructions_per_...` count."""
        return {
            "target": self.target,
            "optimisation": self.level,
            "flash_bytes": self.flash_bytes,
            "code_bytes": self.code_bytes,
            "constant_bytes": self.constant_bytes,
            "ram_bytes": self.ram_bytes,
            "stack_bytes": self.stack_bytes,
            "unit": self.times.unit,
            "instructions_per_estimate": self.times.estimate,
            "instructions_per_tip_pose": self.times.tip_pose,
            "instructions_per_frame": self.times.frame,
            "instructions_per_receive": self.times.receive,
            "instructions_per_transmit": self.times.transmit,
            "instructions_per_health": self.times.health,
            "instructions_per_snapshot": self.times.snapshot,
            "instructions_per_jacobian": self.times.jacobian,
            **self._checks(),
            "parts": {
                name: {"code_bytes": part.code, "constant_bytes": part.constants}
                for name, part in self.parts.items()
            },
            "stacks": self.stacks,
            "functions": {
                name: {
                    "instructions_per_call": taken,
                    "stack_bytes": self.function_stacks[name],
                }
                for name, taken in self.times.functions.items()
            },
            "jacobian_flash_bytes": self.jacobian.code + self.jacobian.constants,
            "functions_flash_bytes": self.functions.code + self.functions.constants,
        }

    def _checks(self) -> dict[str, int]:
        """What holding sensors against each other takes; empty where none are checked."""
        checks = self.times.checks
        if checks is None:
            return {}
        return {
            "instructions_per_check": checks.quiet,
            "instructions_per_examination": checks.examined,
        }


def measure(exported: Exported, target: str, level: str = LEVEL) -> Cost:
    """Compile a folder for a target at a level of optimisation, and count.

    Raises:
        ArgumentError: unknown target.
        ToolError: a tool is missing or does not accept the folder.
        CheckError: no bound of the stack can be given, or a call fails.
    """
    core = core_named(target, COUNTED)
    with tempfile.TemporaryDirectory(prefix="ccgen-") as name:
        folder = Path(name)
        compiled = compile_measured(exported, core, folder, level)
        functions = read_disassembly(compiled.disassembly, core.return_bytes)
        frames = read_frames(folder)
        joint = exported.joint.name
        own = [function.name for function in exported.functions.compiled]
        beside = (*own, JACOBIAN)
        stacks = {
            call: worst_case(f"{joint}_{call}", functions, frames)[0]
            for call in (*calls_of(exported), "node_init", *beside)
        }
        times = _times(exported, target, compiled.program, folder, max(stacks.values()))
        parts = read_map(compiled.map, joint)
        return Cost(
            target=target,
            level=level,
            functions=parts.pop(FUNCTIONS),
            jacobian=parts.pop(JACOBIAN_SIZE),
            parts=parts,
            state_bytes=compiled.state_bytes,
            constants_in_ram=not core.constants_in_flash,
            stacks={call: taken for call, taken in stacks.items() if call not in beside},
            function_stacks={call: stacks[call] for call in own},
            times=times,
        )


def _times(exported: Exported, target: str, program: Path, folder: Path, bound: int) -> Times:
    if target == "avr":
        from ccgen.cost.avr import cycles

        return cycles(exported, program, folder)
    from ccgen.cost.emulator import CORES as EMULATED
    from ccgen.cost.emulator import Program

    times, seen = count(exported, Program(program, EMULATED[target]))
    if seen > bound:
        raise CheckError(f"{target}: {seen} bytes of stack seen, more than the bound of {bound}")
    return times
