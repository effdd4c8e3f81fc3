"""Proven bounds of integer poses beside the worst that a search finds.

Random states and corners first; then the worst are changed a segment at a time, and what is worse
still is kept.
"""

import sys
from pathlib import Path

import numpy as np

import ccgen
from ccgen import kinematics as kin
from ccgen.fixedpoint.pose import PoseModel

EXAMPLES = Path(__file__).parents[2] / "examples"
STATES = int(sys.argv[1]) if len(sys.argv) > 1 else 200_000
BLOCK = 50_000
KEPT, CLIMBS = 500, 300


def errors(poses: PoseModel, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Distances of the tip to double precision, metres."""
    task = poses.task
    _, position = poses.pose(u, v)
    angles = [x * 2.0**-bits for x, bits in zip((u, v), task.fraction_bits, strict=True)]
    expected = kin.tip_pose(*angles, task.segment_length)[:, :3, 3]
    return np.asarray(np.linalg.norm(position * 2.0**-poses.position_bits - expected, axis=1))


def main() -> None:
    """Print a line for each example joint."""
    random = np.random.default_rng(1)
    print(f"{STATES:,} states and {CLIMBS} rounds of climbing")
    for name in ("shoulder", "spine"):
        poses = ccgen.fit(ccgen.load(EXAMPLES / f"{name}.toml")).poses
        task = poses.task
        ends = [int(min(task.largest, task.angle * 2.0**bits)) for bits in task.fraction_bits]
        worst = np.zeros(0)
        states = np.zeros((2, 0, task.segments), dtype=np.int64)
        for block in range(-(-STATES // BLOCK)):
            drawn = np.stack([random.integers(-e, e + 1, (BLOCK, task.segments)) for e in ends])
            if block % 3 == 1:
                drawn = np.stack([random.choice([-e, 0, e], (BLOCK, task.segments)) for e in ends])
            elif block % 3 == 2:
                drawn = np.repeat(drawn[:, :, :1], task.segments, axis=2)
            found = errors(poses, *drawn)
            order = np.argsort(np.concatenate([worst, found]))[::-1][:KEPT]
            worst = np.concatenate([worst, found])[order]
            states = np.concatenate([states, drawn], axis=1)[:, order]
        before = worst.max()
        for _ in range(CLIMBS):
            trial = states.copy()
            rows, place = np.arange(KEPT), random.integers(0, task.segments, KEPT)
            for axis, end in enumerate(ends):
                trial[axis, rows, place] = random.integers(-end, end + 1, KEPT)
            found = errors(poses, *trial)
            better = found > worst
            worst[better], states[:, better] = found[better], trial[:, better]
        bound = poses.bounds.position
        print(
            f"{name}: proven {bound:.3g} m, {bound / task.length:.2g} of the length; met "
            f"{before:.3g} m, after climbing {worst.max():.3g} m: {bound / worst.max():.1f} times"
        )
        assert worst.max() <= bound


if __name__ == "__main__":
    main()
