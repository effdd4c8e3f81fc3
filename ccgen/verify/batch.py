"""Compares batches that need not cross a bus: angles, poses and Jacobians."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen import kinematics
from ccgen.fixedpoint.pose import pose_inputs
from ccgen.sensing.counts import corner_counts, random_counts
from ccgen.targets.exported import Exported
from ccgen.targets.inputs import shape_counts, without_readings
from ccgen.targets.library import JointLibrary
from ccgen.verify.compare import integer_jacobians, states_of, tip_jacobians
from ccgen.verify.plan import Plan, Progress
from ccgen.verify.run import Run

Integers = NDArray[np.int64]

BLOCK = 1024
"""Snapshots that share a zero."""

POSES = 512
"""Shapes whose poses and Jacobians are compared, half of them from the library."""

TITLE = "batch, shared library"


@dataclass(frozen=True)
class _Excess:
    """A quantity's largest error, and its bound."""

    name: str
    error: float
    bound: float


def compare_batches(exported: Exported, library: JointLibrary, plan: Plan, report: Progress) -> Run:
    """Compare counts and zeros over the full declared range, then poses and Jacobians."""
    total = plan.batch_snapshots(exported.model.values)
    compared = wrong = degraded = 0
    started = time.monotonic()
    for block, first in enumerate(range(0, total, BLOCK)):
        size = min(BLOCK, total - first)
        one = _compared(exported, library, plan.seed + block, size)
        wrong, degraded = wrong + one.wrong, degraded + one.degraded
        compared += size * exported.model.values
        report(TITLE, first + size, total)
    seconds = time.monotonic() - started
    shapes = _pose_angles(exported)
    errors = _kinematic_errors(exported, library, shapes)
    right = exported.poses.chain(*pose_inputs(exported.model, shapes))
    other = (library.integer_poses(shapes) != right).any(axis=-1)
    moved = library.integer_jacobians(shapes) != integer_jacobians(exported, shapes)
    others = [other.ravel(), moved.any(axis=(1, 2))]
    words = _function_words(exported, library, shapes)
    return Run(
        target="host",
        transport="batch",
        snapshots=total,
        compared_values=compared,
        mismatches=wrong,
        lost_frames=0,
        rate_hz=total / seconds,
        degraded_snapshots=degraded,
        compared_poses=sum(one.size for one in others),
        pose_mismatches=sum(int(np.count_nonzero(one)) for one in others),
        compared_functions=words.size,
        function_mismatches=int(np.count_nonzero(words)),
        pose_max_error_m=errors[0].error if errors else None,
        pose_bound_m=errors[0].bound if errors else None,
        note="; ".join(
            f"{e.name} off by {e.error:.3g}, bound {e.bound:.3g}"
            for e in errors[1:]
            if not e.error <= e.bound
        ),
    )


@dataclass(frozen=True)
class _Block:
    """Values that differ in a block, and snapshots of which some axis is degraded or lost."""

    wrong: int
    degraded: int


def _compared(exported: Exported, library: JointLibrary, seed: int, size: int) -> _Block:
    """A block whose zero is a corner or drawn over the whole range, and which loses readings.

    A snapshot whose states differ counts as wrong in all its values.
    """
    groups = exported.model.groups
    accepted = [group.zeros for group in groups]
    corners = corner_counts(accepted)
    zeros = np.concatenate([corners, random_counts(accepted, len(corners), seed)])
    zero = zeros[seed % len(zeros)]
    parts = np.split(zero, np.cumsum([group.sensors for group in groups])[:-1])
    around = [group.around(part) for group, part in zip(groups, parts, strict=True)]
    drawn = random_counts(around, size, seed + 1)
    counts = np.concatenate([corner_counts(around), drawn])[:size]
    counts = without_readings(counts, -(2 ** (exported.model.precision - 1)), seed)
    angles, results = library.estimate(counts, zero)
    followed = exported.guarded.follow(counts, zero)
    states = followed.mask(tuple(exported.model.axes))
    other = results != states
    angles[other] = ~followed.values[other]
    wrong = int(np.count_nonzero(angles != followed.values))
    return _Block(wrong, int(np.count_nonzero(states)))


def _kinematic_errors(exported: Exported, library: JointLibrary, angles: Integers) -> list[_Excess]:
    """Largest errors against double precision: positions first, then rotations and Jacobians.

    None where the folder has no kinematics in floating point.
    """
    bounds = exported.pose_bounds
    if bounds is None:
        return []
    poses = kinematics.chain(*states_of(exported, angles))
    poses = np.concatenate([poses, poses[:, -1:]], axis=1)
    positions, rotations = library.poses(angles)
    error = library.jacobians(angles) - tip_jacobians(exported, angles)
    return [
        _Excess("position", _largest(positions - poses[..., :3, 3], (-1,)), bounds.position),
        _Excess("rotation", _largest(rotations - poses[..., :3, :3], (-2, -1)), bounds.rotation),
        _Excess("linear Jacobian", _largest(error[:, :3], (1,)), bounds.linear),
        _Excess("angular Jacobian", _largest(error[:, 3:], (1,)), bounds.angular),
    ]


def _function_words(
    exported: Exported, library: JointLibrary, angles: Integers
) -> NDArray[np.bool_]:
    """Which results of the user's own functions differ; shape (k, words)."""
    if not exported.functions:
        return np.zeros((0, 0), dtype=np.bool_)
    found = library.functions(angles, exported.functions.words)
    return np.asarray(found != exported.functions.evaluate(exported.model, angles))


def _pose_angles(exported: Exported) -> Integers:
    """Shapes of the library, and angles drawn over the whole format."""
    shapes = exported.model.estimate(shape_counts(exported))[: POSES // 2]
    limit = next(iter(exported.model.axes.values())).angle_limit
    random = np.random.default_rng(0)
    drawn = random.integers(-limit, limit, (POSES - len(shapes), shapes.shape[1]), endpoint=True)
    return np.concatenate([shapes, drawn])


def _largest(difference: NDArray[np.float64], axes: tuple[int, ...]) -> float:
    return float(np.sqrt(np.sum(np.square(difference), axis=axes)).max())
