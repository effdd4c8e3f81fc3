"""Faults of sensors, put into counts: stuck, lost, or off by a length, from some moment on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.digits import at_least
from ccgen.errors import ArgumentError
from ccgen.joint import Joint
from ccgen.joint.specification import count_limits

Integers = NDArray[np.int64]

Kind = Literal["stuck", "lost", "offset"]

_FORM = "SENSOR=stuck@SECONDS, SENSOR=lost@SECONDS or SENSOR=offset:METRES@SECONDS"

_FARTHEST = 2.0**33
"""Counts, more than any transducer has."""


@dataclass(frozen=True)
class InjectedFault:
    """A fault of one sensor.

    Attributes:
        text: as it was asked for.
        sensor: number in the joint's list.
        kind: "stuck" at the count that it had, "lost" without a reading, "offset" off by a length.
        start: when it begins, seconds from the first snapshot.
        counts: by which it is off.
    """

    text: str
    sensor: int
    kind: Kind
    start: float
    counts: int = 0


def read_fault(text: str, joint: Joint) -> InjectedFault:
    """Read a fault, such as "u2=offset:0.0005@3".

    Raises:
        ArgumentError: another form, a sensor that the joint does not have, an offset that no
            count shows.
    """
    name, told, rest = text.partition("=")
    what, timed, when = rest.rpartition("@")
    if not (told and timed):
        raise _refused(text, f"is not of the form {_FORM}")
    kind, _, length = what.partition(":")
    names = [sensor.name for sensor in joint.sensors]
    if name not in names:
        raise _refused(text, f"no sensor is called {name!r}; give one of {', '.join(names)}")
    if kind not in ("stuck", "lost", "offset") or (kind == "offset") != (":" in what):
        raise _refused(text, f"{what!r} is no fault; write {_FORM}")
    start = _number(text, when, "seconds")
    if start < 0.0:
        raise _refused(text, f"begins {-start:g} s before the first snapshot; give seconds from 0")
    sensor = names.index(name)
    counts = 0
    if kind == "offset":
        step = joint.sensors[sensor].metres_per_count
        off = _number(text, length, "metres") / step
        if abs(off) < 0.5:
            least = at_least(abs(step) / 2.0)
            raise _refused(text, f"is less than half a count; give at least {least} m")
        counts = round(max(-_FARTHEST, min(off, _FARTHEST)))
    return InjectedFault(text, sensor, cast("Kind", kind), start, counts)


def with_faults(
    joint: Joint,
    counts: ArrayLike,
    times: ArrayLike,
    faults: Sequence[InjectedFault],
    no_reading: int,
) -> Integers:
    """Counts as faulty sensors give them; of one sensor, what begins later acts on what is there.

    Args:
        joint: its sensors.
        counts: shape (k, n), in the joint's order.
        times: of the snapshots, shape (k,), seconds from the first, never running back.
        faults: what breaks.
        no_reading: count that stands for none, the most negative one that a frame holds.

    Raises:
        ArgumentError: a fault begins after the last snapshot.
    """
    found, when = np.array(counts, dtype=np.int64), np.asarray(times, dtype=np.float64)
    for fault in sorted(faults, key=lambda fault: fault.start):
        first = int(np.searchsorted(when, fault.start))
        if first == len(when):
            raise _refused(fault.text, f"begins after the last snapshot, at {when[-1]:.6g} s")
        column = found[first:, fault.sensor]
        if fault.kind == "lost":
            column[:] = no_reading
        elif fault.kind == "stuck":
            column[:] = column[0]
        else:
            sensor = joint.sensors[fault.sensor]
            low, high = count_limits(sensor.bits, sensor.signed)
            low, high = max(low, no_reading + 1), min(high, -no_reading - 1)
            there = column != no_reading
            column[there] = np.clip(column[there] + fault.counts, low, high)
    return found


def _number(text: str, word: str, unit: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _refused(text, f"{word!r} is no number of {unit}; write {_FORM}")
    return value


def _refused(text: str, problem: str) -> ArgumentError:
    return ArgumentError(f"{text}: {problem}", "fault")
