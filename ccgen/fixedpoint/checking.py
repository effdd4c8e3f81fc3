"""From sound readings to the integer check: weights, thresholds, and what is told of faults.

Residuals are rounded to integers first; thresholds, margins and everything that is told then follow
from the rounded ones, so that the stated rate of false alarms is that of the integer check.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation.consistency.alarms import thresholds
from ccgen.estimation.consistency.faults import Faults, faults
from ccgen.estimation.consistency.residuals import residual_matrix
from ccgen.estimation.consistency.sound import SoundReadings
from ccgen.fixedpoint.consistency import GroupCheck, RoundedResiduals, rounded_residuals
from ccgen.fixedpoint.model import Floats, Integers


@dataclass(frozen=True, eq=False)
class Transducers:
    """What turns the lengths of n sensors into differences of counts.

    Attributes:
        metres_per_count: shape (n,), of either sign.
        span: the largest |count - zero| in range, shape (n,).
        precision: bits of counts and weights, 16 or 32.
    """

    metres_per_count: Floats
    span: Integers
    precision: int


@dataclass(frozen=True, eq=False)
class CheckedGroup:
    """The check of one group of sensors, and the faults that it sees."""

    check: GroupCheck
    faults: Faults


def checked_groups(
    sound: SoundReadings, groups: Sequence[slice], transducers: Transducers, rate: float
) -> list[CheckedGroup]:
    """Checks of the groups that see a fault no larger than the largest reading of its sensor.

    Groups that do not are left out, and take no part of the false alarms.

    Args:
        sound: readings of a sound joint, with noise at every sensor.
        groups: sensors that are held against each other.
        transducers: of all sensors.
        rate: of false alarms, of snapshots, all sensors together.
    """
    kept = [group for group in groups if group.stop - group.start > 1]
    while kept:
        found = _checked(sound, kept, transducers, rate)
        useful = [
            one for one in found if detects(one.faults, sound.lengths[:, one.check.own]).any()
        ]
        if len(useful) == len(found):
            return found
        kept = [one.check.own for one in useful]
    return []


def detects(told: Faults, lengths: Floats) -> NDArray[np.bool_]:
    """Of which sensors a fault is seen that is no larger than the largest reading; shape (n,)."""
    return np.asarray(told.detectable <= np.abs(lengths).max(axis=0))


def _checked(
    sound: SoundReadings, groups: Sequence[slice], transducers: Transducers, rate: float
) -> list[CheckedGroup]:
    exact = residual_matrix(sound, groups)
    rounded = [_rounded(exact[group, group], transducers, group) for group in groups]
    members = np.concatenate([np.arange(group.start, group.stop) for group in groups])
    limits = thresholds(_blocks(rounded), sound.of(members), rate)
    parts = np.split(limits, np.cumsum([len(one.weights) for one in rounded])[:-1])
    return [
        _group(group, one, limit, sound.of(group), transducers.precision)
        for group, one, limit in zip(groups, rounded, parts, strict=True)
    ]


def _rounded(matrix: Floats, transducers: Transducers, group: slice) -> RoundedResiduals:
    step, span = transducers.metres_per_count[group], transducers.span[group]
    return rounded_residuals(matrix, step, span, transducers.precision)


def _blocks(rounded: Sequence[RoundedResiduals]) -> Floats:
    """The groups' matrices along the diagonal of one."""
    total = sum(len(one.weights) for one in rounded)
    matrix, start = np.zeros((total, total)), 0
    for one in rounded:
        end = start + len(one.weights)
        matrix[start:end, start:end] = one.matrix
        start = end
    return matrix


def _group(
    group: slice, rounded: RoundedResiduals, limits: Floats, sound: SoundReadings, precision: int
) -> CheckedGroup:
    told = faults(rounded.matrix, limits, sound)
    check = GroupCheck(
        first=group.start,
        precision=precision,
        weights=rounded.weights,
        threshold=rounded.steps(limits, precision),
        margin=rounded.steps(told.margin, precision),
    )
    return CheckedGroup(check, told)
