"""The integer reference model with fallbacks and checks: from counts over time to angles.

For each snapshot, in this order:

1. A sensor whose count is no reading (`AxisModel.missing`) is absent.
2. Each checked group of sensors takes its verdict, where none of its sensors is absent by 1
   (`ccgen.fixedpoint.consistency`), and moves its state (`ccgen.fixedpoint.watch`). A sensor that
   is left out by the new state is absent too.
3. Each output axis is served with what its sensors leave (`ccgen.fixedpoint.fallback`).

An axis is lost where all its values are "no reading"; it is degraded where one of its sensors is
absent, or its group alarms; else it is good. Suspected is the sensor that a group leaves out; while
it leaves none out, the one that the snapshot's verdict names.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.fixedpoint.consistency import NOBODY, GroupCheck
from ccgen.fixedpoint.fallback import Fallbacks, served
from ccgen.fixedpoint.model import FixedPointModel, Integers
from ccgen.fixedpoint.watch import Watch
from ccgen.joint.specification import OUTPUT_AXES

GOOD, DEGRADED, LOST = 0, 1, 2
"""States of an output axis."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Followed:
    """What K snapshots of n sensors leave.

    Attributes:
        values: of all axes, one after the other, shape (K, rows).
        suspected: shape (K, n).
        states: `GOOD`, `DEGRADED` or `LOST` of each axis, shape (K, axes).
        watches: states of the groups after the last snapshot.
    """

    values: Integers
    suspected: Flags
    states: Integers
    watches: tuple[Watch, ...]

    def mask(self, axes: Sequence[str]) -> Integers:
        """States as the C tells them, two bits an axis from u on; shape (K,).

        Args:
            axes: the model's, in their order.
        """
        places = np.array([4 ** OUTPUT_AXES.index(axis) for axis in axes], dtype=np.int64)
        return np.asarray(self.states @ places)


@dataclass(frozen=True, eq=False)
class GuardedModel:
    """A fixed-point model, what serves while sensors are absent, and what watches them.

    Attributes:
        model: all output axes, in formats that their fallbacks share.
        fallbacks: by output axis; empty without fallbacks.
        groups: checks of sensors; empty without checks.
    """

    model: FixedPointModel
    fallbacks: Mapping[str, Fallbacks]
    groups: tuple[GroupCheck, ...]

    @property
    def flash_bytes(self) -> int:
        """Bytes of all fallback rows in flash."""
        return sum(own.flash_bytes(self.model.precision) for own in self.fallbacks.values())

    def start(self) -> tuple[Watch, ...]:
        """States of the groups before the first snapshot."""
        return tuple(Watch() for _ in self.groups)

    def estimate(
        self, counts: ArrayLike, absent: ArrayLike, zero: ArrayLike | None = None
    ) -> Integers:
        """Values of all axes from a mask, without any state.

        Args:
            counts: shape (K, n), in the joint's order; what stands at an absent sensor is not read.
            absent: shape (K, n).
            zero: shape (n,) or (K, n); the model's own by default.

        Returns:
            Shape (K, rows of all axes); the most negative value where an axis is lost.
        """
        distances, gone = self._differences(counts, zero), np.asarray(absent, dtype=np.bool_)
        parts = []
        for name, axis in self.model.axes.items():
            rows = self.fallbacks[name].rows if name in self.fallbacks else ()
            parts.append(served(axis, rows, distances[:, axis.part], gone[:, axis.part]))
        return np.concatenate(parts, axis=1)

    def missing(self, counts: ArrayLike, zero: ArrayLike | None = None) -> Flags:
        """Which counts are no readings, shape (K, n)."""
        values = np.asarray(counts, dtype=np.int64)
        zeros = self._zero(zero)
        gone = np.zeros(values.shape, dtype=np.bool_)
        for axis in self.model.axes.values():
            gone[:, axis.part] |= axis.missing(values[:, axis.part], zeros[..., axis.part])
        return gone

    def follow(
        self,
        counts: ArrayLike,
        zero: ArrayLike | None = None,
        watches: Sequence[Watch] | None = None,
    ) -> Followed:
        """Estimate snapshots one after the other.

        Args:
            counts: shape (K, n), in the joint's order of sensors.
            zero: shape (n,) or (K, n); the model's own by default.
            watches: states of the groups before; of the start by default.
        """
        values = np.asarray(counts, dtype=np.int64)
        absent = self.missing(values, zero)
        suspected, alarmed = np.zeros_like(absent), np.zeros_like(absent)
        distances, gone = self._differences(values, zero), absent.copy()
        before = self.start() if watches is None else tuple(watches)
        after = []
        for group, watch in zip(self.groups, before, strict=True):
            own = group.own
            track = _watched(group, watch, distances[:, own], absent[:, own])
            gone[:, own] |= track.out
            suspected[:, own] = track.suspected
            alarmed[:, own] = track.alarm[:, None]
            after.append(track.watch)
        estimated = self.estimate(values, gone, zero)
        states = self._states(estimated, gone, alarmed)
        return Followed(estimated, suspected, states, tuple(after))

    def _states(self, values: Integers, gone: Flags, alarmed: Flags) -> Integers:
        states, start = [], 0
        for axis in self.model.axes.values():
            lost = values[:, start] == -axis.angle_limit - 1
            unsure = (gone | alarmed)[:, axis.part].any(axis=1)
            states.append(np.where(lost, LOST, np.where(unsure, DEGRADED, GOOD)))
            start += axis.segments
        return np.stack(states, axis=1).astype(np.int64)

    def _differences(self, counts: ArrayLike, zero: ArrayLike | None) -> Integers:
        return np.asarray(np.asarray(counts, dtype=np.int64) - self._zero(zero))

    def _zero(self, zero: ArrayLike | None) -> Integers:
        return self.model.readings.zero if zero is None else np.asarray(zero, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class _Track:
    """A group over K snapshots: who is left out and suspected, (K, n), and when it alarms, (K,)."""

    out: Flags
    suspected: Flags
    alarm: Flags
    watch: Watch


def _watched(group: GroupCheck, watch: Watch, differences: Integers, absent: Flags) -> _Track:
    complete: Flags = np.asarray(~absent.any(axis=1))
    alarm, named = group.verdicts(np.where(complete[:, None], differences, 0))
    alarm &= complete
    named = np.where(complete, named, NOBODY)
    out, suspected = np.zeros_like(absent), np.zeros_like(absent)
    verdicts = zip(complete.tolist(), alarm.tolist(), named.tolist(), strict=True)
    for k, verdict in enumerate(verdicts):
        watch = watch.after(*verdict)
        if watch.out:
            out[k, watch.sensor] = suspected[k, watch.sensor] = True
        elif verdict[2] != NOBODY:
            suspected[k, verdict[2]] = True
    return _Track(out, suspected, alarm, watch)
