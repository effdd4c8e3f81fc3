"""What is sent for a verification: shapes, corners, and counts over the full declared range."""

import numpy as np
from numpy.typing import NDArray

from ccgen.sensing.counts import corner_counts, counts, random_counts
from ccgen.shapes import Shapes, fit_library
from ccgen.targets.exported import Exported

Integers = NDArray[np.int64]


def bus_counts(exported: Exported, snapshots: int, seed: int) -> Integers:
    """Snapshots to send over a bus: the shape library, the corners, and random ones that lack some.

    Args:
        exported: the folder.
        snapshots: how many; the shapes and the corners come first.
        seed: of the random counts.

    Returns:
        Shape (snapshots, n).
    """
    axes = [group.around() for group in exported.model.groups]
    fixed = np.concatenate([shape_counts(exported), corner_counts(axes)])[:snapshots]
    drawn = random_counts(axes, snapshots - len(fixed), seed)
    none = -(1 << (8 * exported.layout.count_bytes - 1))
    return np.concatenate([fixed, without_readings(drawn, none, seed)])


def without_readings(counts: Integers, none: int, seed: int) -> Integers:
    """Counts of which one snapshot of four has lost a reading, and one of twelve a second.

    Args:
        counts: shape (k, n).
        none: what says that there is no reading.
        seed: of the choice.
    """
    random = np.random.default_rng([seed, *b"lost"])
    rows, lost = np.arange(len(counts)), counts.copy()
    for share in (4, 3):
        rows = rows[random.integers(0, share, len(rows)) == 0]
        lost[rows, random.integers(0, counts.shape[1], len(rows))] = none
    return lost


def shape_counts(exported: Exported) -> Integers:
    """Counts of the shape library, the v axis bent by each shape's mirror image.

    An axis that is not estimated does not bend; sections stretch from their shortest to longest.
    """
    joint, angles = exported.joint, fit_library(exported.joint).angles
    bends = {"u": angles, "v": -angles[::-1]}
    u, v = (bends[axis] if axis in joint.axes else np.zeros_like(angles) for axis in bends)
    low, high = joint.geometry.elongation or (0.0, 0.0)
    stretch = np.linspace(low, high, len(angles))[:, None]
    h = np.broadcast_to(stretch, (len(angles), len(joint.geometry.sections)))
    around = [group.around() for group in exported.model.groups]
    return counts(joint, around, Shapes(u, v, h, ("cases",) * len(angles)))
