"""A lower bound on the objective of any placement, from the number of sensors alone.

Estimates from n readings have rank n. A square block of the score shapes, n + 1 shapes by n + 1
segments, is estimated by a singular matrix; the smallest sum of absolute changes that makes a
matrix B singular is 1 / max |B^-1| (its distance to singularity in the norm from l-infinity to
l1). Disjoint blocks add up. Sensor noise only raises the mean absolute error.

The bound forgets that readings are means over spans and that the weights are fitted, so it is
far from tight; but it is proven.
"""

import numpy as np

from ccgen.placement.objective import Floats, ObjectiveModel


def lower_bound(model: ObjectiveModel, sensors: int) -> float:
    """Objective in % of the range of motion below which no placement of so many sensors gets."""
    weighted = model.score_shapes * model.score_weights[:, None]
    size = sensors + 1
    strips = model.segments // size
    total = 0.0
    for rows in _independent_groups(weighted, size):
        for strip in range(strips):
            # Segments far apart differ most.
            total += _distance_to_singular(weighted[rows][:, strip::strips][:, :size])
    return total


def _independent_groups(shapes: Floats, size: int) -> list[list[int]]:
    """Groups of shapes, each as independent as those left allow."""
    left = list(range(len(shapes)))
    groups = []
    while len(left) >= size:
        chosen = _independent(shapes[left], size)
        groups.append([left[index] for index in chosen])
        left = [index for k, index in enumerate(left) if k not in chosen]
    return groups


def _independent(shapes: Floats, size: int) -> list[int]:
    """Numbers of `size` shapes, each the farthest from the span of those before it."""
    from scipy.linalg import qr

    _, order = qr(shapes.T, mode="r", pivoting=True)
    return [int(index) for index in order[:size]]


def _distance_to_singular(block: Floats) -> float:
    """Smallest sum of absolute changes of the entries that makes a square matrix singular."""
    if np.linalg.cond(block) > 1e13:
        return 0.0
    return float(1.0 / np.abs(np.linalg.inv(block)).max())
