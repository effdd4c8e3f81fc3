"""Snapshots to measure a folder with: sound ones, and such as its checks have to examine."""

from dataclasses import dataclass

import numpy as np

from ccgen.fixedpoint.consistency import NOBODY
from ccgen.sensing.counts import corner_counts, random_counts
from ccgen.targets.exported import Exported
from ccgen.targets.inputs import Integers, shape_counts

SHAPES = 2
CORNERS = 2
DRAWN = 1

_SOUND = 4
_SHARES = (1, 2, 4, 8)
"""Of the way from the straight joint to a shape: one in so many."""
_POOL = 64
"""Drawn snapshots of which the one is taken that most groups of sensors contradict."""


@dataclass(frozen=True, eq=False)
class Snapshots:
    """Counts to measure with.

    Attributes:
        whole: sent through the node, shape (k, n); where sensors are checked, all of them quiet.
        examined: which the sensors of as many groups as can be contradict, shape (m, n); none
            where no sensors are checked.
    """

    whole: Integers
    examined: Integers

    @property
    def all(self) -> Integers:
        """First the whole ones, then the examined."""
        return np.concatenate([self.whole, self.examined])


def snapshots(exported: Exported) -> Snapshots:
    """Shapes, corners of the ranges, drawn; of checked sensors, sound ones and contradictions."""
    axes = [group.around() for group in exported.model.groups]
    shapes, corners = shape_counts(exported), corner_counts(axes)
    if not exported.guarded.groups:
        whole = [
            shapes[:: max(1, len(shapes) // SHAPES)][:SHAPES],
            corners[:: max(1, len(corners) - 1)][:CORNERS],
            random_counts(axes, DRAWN, 0),
        ]
        return Snapshots(np.concatenate(whole), corners[:0])
    pools = (corners, random_counts(axes, _POOL, 0), _slips(exported))
    return Snapshots(
        _sound(exported, shapes), np.stack([_contradicted(exported, pool) for pool in pools])
    )


def _sound(exported: Exported, shapes: Integers) -> Integers:
    """Of snapshots on the way from the straight joint to its shapes, some that are quiet."""
    zero = exported.model.readings.zero
    moved = [zero + (shapes - zero) // share for share in _SHARES]
    counts = np.concatenate([*moved, zero[None, :]])
    quiet = np.ones(len(counts), dtype=np.bool_)
    for group in exported.guarded.groups:
        quiet &= group.quiet((counts - zero)[:, group.own])
    found = counts[quiet]
    return np.asarray(found[:: -(-len(found) // _SOUND)])


def _slips(exported: Exported) -> Integers:
    """The straight joint with one sensor of every group at an end of its range."""
    readings = exported.model.readings
    rows = []
    for place in range(max(group.sensors for group in exported.guarded.groups)):
        slipped = [group.first + place % group.sensors for group in exported.guarded.groups]
        for end in (readings.minimum, readings.maximum):
            row = readings.zero.copy()
            row[slipped] = end[slipped]
            rows.append(row)
    return np.stack(rows)


def _contradicted(exported: Exported, pool: Integers) -> Integers:
    """The snapshot in which most groups alarm, and of these name most sensors."""
    groups = exported.guarded.groups
    differences = pool - exported.model.readings.zero
    rank = np.zeros(len(pool), dtype=np.int64)
    for group in groups:
        alarm, named = group.verdicts(differences[:, group.own])
        rank += (len(groups) + 1) * alarm + (named != NOBODY)
    return np.asarray(pool[rank.argmax()])
