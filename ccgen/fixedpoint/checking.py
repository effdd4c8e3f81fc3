"""From sound readings to the integer check: weights, thresholds, and what is told of faults.

Parity values and residuals are rounded to integers first; thresholds, margins and everything that
is told then follow from the rounded ones, so that the stated rate of false alarms is that of the
integer check.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation.consistency.alarms import thresholds
from ccgen.estimation.consistency.box import boxed
from ccgen.estimation.consistency.faults import Faults, faults
from ccgen.estimation.consistency.residuals import Parity, parity
from ccgen.estimation.consistency.sound import SoundReadings
from ccgen.fixedpoint.consistency import GroupCheck, RoundedParity, rounded_parity
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
    members = np.concatenate([np.arange(group.start, group.stop) for group in groups])
    ends = np.cumsum([group.stop - group.start for group in groups])[:-1]

    def limits_of(matrices: Sequence[Floats]) -> list[Floats]:
        return np.split(thresholds(_blocks(matrices), sound.of(members), rate), ends)

    exact = [parity(sound.of(group)) for group in groups]
    about = limits_of([one.alarming for one in exact])
    rounded = [
        _rounded(boxed(one, limits), limits, transducers, group)
        for one, limits, group in zip(exact, about, groups, strict=True)
    ]
    final = limits_of([one.alarming for one in rounded])
    return [
        _group(group, one, limits, sound.of(group), transducers.precision)
        for group, one, limits in zip(groups, rounded, final, strict=True)
    ]


def _rounded(
    exact: Parity, limits: Floats, transducers: Transducers, group: slice
) -> RoundedParity:
    step, span = transducers.metres_per_count[group], transducers.span[group]
    return rounded_parity(exact, limits, step, span, transducers.precision)


def _blocks(matrices: Sequence[Floats]) -> Floats:
    """The groups' matrices along the diagonal of one."""
    total = sum(len(one) for one in matrices)
    matrix, start = np.zeros((total, total)), 0
    for one in matrices:
        end = start + len(one)
        matrix[start:end, start:end] = one
        start = end
    return matrix


def _group(
    group: slice, rounded: RoundedParity, limits: Floats, sound: SoundReadings, precision: int
) -> CheckedGroup:
    threshold = rounded.thresholds(limits)
    told = faults(rounded.alarming, rounded.naming, threshold / rounded.steps_per_unit, sound)
    check = GroupCheck(
        first=group.start,
        precision=precision,
        weights=rounded.weights,
        kept=rounded.kept,
        quiet_bits=rounded.quiet_bits,
        directions=rounded.directions,
        threshold=threshold,
        margin=rounded.steps(told.margin),
    )
    return CheckedGroup(check, told)
