"""The batch firmware: many snapshots estimated on the target, compared by checksums.

A block of snapshots crosses the UART as one checksum. If it is not the reference model's, every
angle of the block counts as a mismatch. Besides, tip poses of drawn angles: those in floating point
cross as the bits of their positions, and a checksum covers the bits of the whole poses; those in
integers, and their tip Jacobians, cross as checksums, and if one is not the reference model's, all
that it covers count as wrong. A folder without kinematics in floating point has the latter alone.
"""

import math
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import ToolError
from ccgen.export.vectors import checksum, draws, outcome
from ccgen.targets.compiler import LEVEL
from ccgen.targets.cores import core_named, require_tools
from ccgen.targets.emulator import run_to_end
from ccgen.targets.exported import Exported
from ccgen.targets.firmware import compile_firmware
from ccgen.verify.compare import integer_jacobians, integer_tips, pose_positions
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run

BLOCK = 256
"""Snapshots a checksum."""

POSES = 64
"""Tip poses that are computed on the target."""

_SILENCE = 300.0
"""Seconds without a line: one block takes seconds on the slowest core of a busy machine."""


@dataclass
class Printed:
    """What the firmware printed.

    Attributes:
        vectors: angles compared by the built-in self-test and mismatches, then poses and
            mismatches, if it ran.
        checksums: of the blocks, by seed.
        tips: position of each tip, metres.
        poses: checksum of the bits of all poses in floating point.
        integers: checksum of all poses in integers.
        jacobians: checksum of all tip Jacobians in integers.
        functions: checksum of all that the user's own functions give.
        ended: whether the last line came.
        seconds: that the firmware ran.
    """

    vectors: tuple[int, int, int, int] = (0, 0, 0, 0)
    checksums: dict[int, int] = field(default_factory=dict)
    tips: list[tuple[float, ...]] = field(default_factory=list)
    poses: int | None = None
    integers: int | None = None
    jacobians: int | None = None
    functions: int | None = None
    ended: bool = False
    seconds: float = 0.0

    def take(self, line: str) -> None:
        """Add a line."""
        kind, *digits = line.split(" ")
        try:
            words = [int(word, 16) for word in digits]
            if kind == "vectors":
                angles, wrong, poses, wrong_poses = words
                self.vectors = (angles, wrong, poses, wrong_poses)
            elif kind == "angles":
                seed, self.checksums[seed] = words[0], words[1]
            elif kind == "tip":
                x, y, z = np.array(words, dtype=np.uint32).view(np.float32).tolist()
                self.tips.append((x, y, z))
            elif kind == "poses":
                (self.poses,) = words
            elif kind == "integers":
                (self.integers,) = words
            elif kind == "jacobians":
                (self.jacobians,) = words
            elif kind == "functions":
                (self.functions,) = words
            elif kind == "end":
                self.ended = True
            else:
                raise ValueError
        except (ValueError, IndexError) as error:
            raise ToolError(f"the firmware printed {line!r}, which is none of its lines") from error


def run_batch(
    exported: Exported, target: str, plan: Plan, report: Progress, options: Sequence[str] = (LEVEL,)
) -> Printed:
    """Compile the batch firmware and run it in the target's emulator.

    Args:
        exported: the folder.
        target: one of `MICROCONTROLLERS`.
        plan: extent.
        report: of progress.
        options: the compiler's, such as the level of optimisation.

    Raises:
        ToolError: something is missing, or the firmware does not compile or run.
    """
    core = core_named(target)
    require_tools(core)
    blocks = _blocks(exported, plan)
    extent = (
        f"-DBATCH_SEED={plan.seed & 0xFFFFFFFF}u", f"-DBATCH_BLOCKS={blocks}u",
        f"-DBATCH_SNAPSHOTS={BLOCK}u", f"-DBATCH_POSES={POSES}u",
        f"-DBATCH_VECTORS={int(core.constants_in_flash)}",
    )  # fmt: skip
    printed = Printed()

    def on_line(line: str) -> None:
        printed.take(line)
        report(f"{target}, batch", len(printed.checksums), blocks)

    with tempfile.TemporaryDirectory() as name:
        out = Path(name)
        program = compile_firmware(exported.directory, core, "batch", out, (*options, *extent))
        command = core.emulate(program, exported.directory / "ports", out)
        begin = time.perf_counter()
        run_to_end(command, _SILENCE, on_line)
        printed.seconds = time.perf_counter() - begin
    if not printed.ended:
        raise ToolError(f"{command[0]}: the firmware ended before its last line")
    return printed


def compare_batch(exported: Exported, target: str, plan: Plan, printed: Printed) -> Run:
    """Compare what the batch firmware printed with the reference models.

    Args:
        exported, target, plan: as for `run_batch`.
        printed: by the firmware.
    """
    blocks = _blocks(exported, plan)
    angles = BLOCK * exported.model.values
    right = {seed: outcome(exported.guarded, seed, BLOCK) for seed in _seeds(plan, blocks)}
    wrong = sum(printed.checksums.get(seed) != one.checksum for seed, one in right.items())
    compared, mismatches, poses, pose_mismatches = printed.vectors
    shapes = pose_angles(exported, plan.seed)
    compared_words = POSES * exported.functions.words
    right_words = exported.functions.evaluate(exported.model, shapes)
    words_differ = compared_words and printed.functions != checksum(right_words)
    differ = [
        printed.integers != checksum(integer_tips(exported, shapes)),
        printed.jacobians != checksum(integer_jacobians(exported, shapes)),
    ]
    bounds = exported.pose_bounds
    return Run(
        target=target,
        transport="batch",
        snapshots=blocks * BLOCK,
        compared_values=blocks * angles + compared,
        mismatches=wrong * angles + mismatches,
        lost_frames=0,
        rate_hz=blocks * BLOCK / printed.seconds,
        degraded_snapshots=sum(one.degraded for one in right.values()),
        compared_poses=poses + len(differ) * POSES,
        pose_mismatches=pose_mismatches + POSES * sum(differ),
        compared_functions=compared_words,
        function_mismatches=compared_words if words_differ else 0,
        pose_max_error_m=None if bounds is None else _farthest(exported, printed, shapes),
        pose_bound_m=None if bounds is None else bounds.position,
    )


def _farthest(exported: Exported, printed: Printed, shapes: NDArray[np.int64]) -> float:
    """Largest distance of a tip in floating point from double precision, metres."""
    tips = np.array(printed.tips, dtype=np.float64).reshape(-1, 3)
    return float(np.linalg.norm(tips - pose_positions(exported, shapes), axis=-1).max())


def pose_angles(exported: Exported, seed: int) -> NDArray[np.int64]:
    """Angles that the firmware draws for its poses, over the full range of their type.

    Returns:
        Shape (POSES, values), u, v, then h.
    """
    model = exported.model
    drawn = draws(seed & 0xFFFFFFFF, POSES * model.values).astype(np.int64)
    signed = (drawn ^ 2**31) - 2**31
    return (signed >> (32 - model.precision)).reshape(POSES, model.values)


def _blocks(exported: Exported, plan: Plan) -> int:
    return math.ceil(plan.batch_snapshots(exported.model.values) / BLOCK)


def _seeds(plan: Plan, blocks: int) -> list[int]:
    return [(plan.seed + block) & 0xFFFFFFFF for block in range(blocks)]
