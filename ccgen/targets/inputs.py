"""What is sent for a verification: shapes, corners, and counts over the full declared range."""

import numpy as np
from numpy.typing import NDArray

from ccgen.sensing.counts import corner_counts, counts, random_counts
from ccgen.shapes import fit_library, unstretched
from ccgen.targets.exported import Exported

Integers = NDArray[np.int64]


def bus_counts(exported: Exported, snapshots: int, seed: int) -> Integers:
    """Snapshots to send over a bus: the shape library, the corners, and random counts.

    Args:
        exported: the folder.
        snapshots: how many; the shapes and the corners come first.
        seed: of the random counts.

    Returns:
        Shape (snapshots, n).
    """
    axes = [group.around() for group in exported.model.groups]
    fixed = np.concatenate([shape_counts(exported), corner_counts(axes)])[:snapshots]
    return np.concatenate([fixed, random_counts(axes, snapshots - len(fixed), seed)])


def shape_counts(exported: Exported) -> Integers:
    """Counts of the shape library, the v axis bent by each shape's mirror image."""
    angles = fit_library(exported.joint).angles
    return counts(exported.joint, exported.model.groups, unstretched(angles, -angles[::-1]))
