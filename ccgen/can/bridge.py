"""Lengths to a node and its estimates back, compared with the model and with the true shape."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import reduce
from operator import or_
from typing import Any

import can
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.can.codec import Codec
from ccgen.can.exchange import Answer, Exchange, Pace, exchange, fresh_start
from ccgen.can.fingerprint import fingerprint
from ccgen.can.layout import FAULTS, FrameLayout, longest, tip_fraction_bits
from ccgen.can.logs import Log
from ccgen.can.reference import followed_by
from ccgen.can.replay import Replay
from ccgen.errors import InputError
from ccgen.fixedpoint import FixedPointModel
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.joint import AXES, Joint
from ccgen.sensing.counts import counts as counts_at
from ccgen.sensing.injected import InjectedFault, with_faults
from ccgen.sensing.motion import joint_motion
from ccgen.shapes import ShapeLibrary, Shapes

Floats = NDArray[np.float64]

_ROUND_SECONDS = 10.0
"""Time that one round of a simulated motion takes."""


@dataclass(frozen=True, eq=False)
class Stream:
    """What is sent: k snapshots at a rate, and the shapes behind them.

    Attributes:
        joint, guarded: of the exported folder.
        source: name of the motion, or the file that is sent again.
        rate_hz: snapshots a second; None for as fast as answers come, or at `times`.
        shapes: true states; None where nobody knows them.
        counts: shape (k, n).
        times: when snapshots are sent, seconds from the first, shape (k,); None for `rate_hz`.
        first: number of the first snapshot; None for one that the bus has not just seen.
        faults: of sensors, that were put into the counts.
    """

    joint: Joint
    guarded: GuardedModel
    source: str
    rate_hz: float | None
    shapes: Shapes | None
    counts: NDArray[np.int64]
    times: Floats | None = None
    first: int | None = None
    faults: tuple[str, ...] = ()

    @property
    def model(self) -> FixedPointModel:
        """The axes of the integer reference model."""
        return self.guarded.model

    @property
    def tip_fraction_bits(self) -> int:
        """A tip coordinate of 1 m is 2^tip_fraction_bits on the bus."""
        return tip_fraction_bits(longest(self.joint.geometry))

    def true_values(self, index: int | NDArray[np.bool_]) -> dict[str, Floats]:
        """True values of snapshots by axis, shape (..., m): radians, shares of lengths.

        Empty where nobody knows them.
        """
        if self.shapes is None:
            return {}
        return {axis: getattr(self.shapes, axis)[index] for axis in self.model.axes}

    def estimated_values(self, raw: ArrayLike) -> dict[str, Floats]:
        """Raw values of answers by axis, shape (..., m): radians, shares of lengths.

        NaN where there is no reading.
        """
        found, lost = {}, -(2 ** (self.model.precision - 1))
        for axis, part in self.model.split(np.asarray(raw, dtype=np.int64)).items():
            found[axis] = np.where(part == lost, np.nan, self.model.axis(axis).radians(part))
        return found

    def off_percent(self, raw: ArrayLike, index: int | NDArray[np.bool_]) -> dict[str, Floats]:
        """How far each value of answers is off by axis: % of range (eq. 12); "h": of the length."""
        estimated, true = self.estimated_values(raw), self.true_values(index)
        units = dict.fromkeys(AXES, self.joint.geometry.range_of_motion) | {"h": 1.0}
        return {axis: 100.0 / units[axis] * np.abs(estimated[axis] - true[axis]) for axis in true}

    def error_percent_rom(self, answer: Answer) -> dict[str, float]:
        """Mean absolute error of an answer's values by axis, as of `off_percent`.

        Without axes that are lost.
        """
        off = self.off_percent(answer.angles, answer.index)
        return {axis: float(own.mean()) for axis, own in off.items() if not np.isnan(own).any()}


def simulated_stream(
    joint: Joint,
    guarded: GuardedModel,
    library: ShapeLibrary | None,
    source: str,
    seconds: float,
    rate_hz: float,
) -> Stream:
    """Prepare the snapshots of a simulated motion.

    Args:
        joint, guarded: of the exported folder.
        library: shapes of the joint; None for its loads.
        source: one of `ccgen.sensing.motion.SOURCES`, or its `LOADS`.
        seconds: how long the stream lasts; at least one snapshot is sent.
        rate_hz: snapshots a second.
    """
    count, period = max(1, round(seconds * rate_hz)), max(1, round(_ROUND_SECONDS * rate_hz))
    shapes = joint_motion(joint, source, library, count, period)
    counts = counts_at(joint, [group.around() for group in guarded.model.groups], shapes)
    return Stream(joint, guarded, source, rate_hz, shapes, counts)


def faulty_stream(
    stream: Stream, times: ArrayLike, faults: Sequence[InjectedFault], layout: FrameLayout
) -> Stream:
    """The stream while sensors fail; of what is sent then, the model is asked too.

    Args:
        stream: as it would be sent.
        times: of its snapshots, shape (k,), seconds from the first.
        faults: of sensors.
        layout: of its frames.

    Raises:
        ArgumentError: as of `with_faults`.
    """
    none = -(1 << (8 * layout.count_bytes - 1))
    counts = with_faults(stream.joint, stream.counts, times, faults, none)
    return replace(stream, counts=counts, faults=tuple(fault.text for fault in faults))


def replayed_stream(
    joint: Joint, guarded: GuardedModel, source: str, replay: Replay, in_time: bool
) -> Stream:
    """Prepare the snapshots of a file.

    Args:
        joint, guarded: of the exported folder.
        source: how the file is told.
        replay: what it holds.
        in_time: whether they are sent at the file's times; else as fast as answers come.
    """
    times = replay.times if in_time else None
    return Stream(joint, guarded, source, None, None, replay.counts, times, replay.first)


@dataclass(frozen=True)
class AxisError:
    """Error of the estimate against the true state, % of range; of "h" % of the length."""

    mean: float
    worst: float


@dataclass(frozen=True)
class Summary:
    """What a bridged stream came to.

    Attributes:
        source, transport: what was sent, and how.
        snapshots: sent.
        answered: of which all angles and the tip came back.
        rate_hz: answered snapshots a second.
        lost_frames, corrupted, unexpected: as of `Exchange`.
        mismatches: angles that differ from the integer reference model; 0 with another zero.
        faults: names of the faults that the node reported.
        error_percent_rom: per axis, over the answered snapshots with an estimate of it; None
            without any, or without true shapes.
        degraded_snapshots: answered ones in which some axis is degraded or lost; as mismatches.
        missing, suspected: names of the sensors that the node ever reported so.
        gone: as of `Exchange`.
        stranger: what tells that the node is of another model; empty where it is not.
        other_zero: "captured" or "restored" where the node did not work with the zero of the model:
            no frame tells that zero, so that its answers cannot be held against the model.
        injected: faults that were put into the counts.
        left_out_before: names of the sensors that the node's checks had left out before the first
            snapshot, by its answers; the reference model starts so too.
    """

    source: str
    transport: str
    snapshots: int
    answered: int
    rate_hz: float
    lost_frames: int
    corrupted: int
    unexpected: int
    mismatches: int
    faults: tuple[str, ...]
    error_percent_rom: dict[str, AxisError] | None
    degraded_snapshots: int = 0
    missing: tuple[str, ...] = ()
    suspected: tuple[str, ...] = ()
    gone: str = ""
    stranger: str = ""
    other_zero: str = ""
    injected: tuple[str, ...] = ()
    left_out_before: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every frame came and every angle is the reference model's."""
        whole = self.answered > 0 and self.lost_frames == 0
        known = not self.gone and not self.stranger and not self.other_zero
        return whole and known and self.mismatches == 0

    def record(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def bridge(
    bus: can.BusABC,
    codec: Codec,
    stream: Stream,
    transport: str,
    on_answer: Callable[[Answer], None] | None = None,
    log: Log | None = None,
) -> Summary:
    """Send a stream at its rate and sum up what came back.

    A sender that ran before on this bus may have been another: see `fresh_start`. What is sent
    again has the numbers that it had, after silence for the widest window that a node may have.

    Args:
        bus: the host's end.
        codec: of the joint.
        stream: what is sent.
        transport: how the bus is told.
        on_answer, log: as of `exchange`.

    Raises:
        InputError: the joint does not publish its angles.
    """
    if not codec.layout.publishes("angles"):
        raise InputError(
            f'{stream.joint.source}: can.publish: leaves out "angles", which bridge compares; '
            "publish them"
        )
    result = exchange(bus, codec, stream.counts, _pace(stream, codec.layout), on_answer, log)
    own = fingerprint(stream.guarded, codec.layout) & 0xFFFF
    return _summary(stream, transport, result, codec.layout, own)


def _pace(stream: Stream, layout: FrameLayout) -> Pace:
    times = None if stream.times is None else stream.times.tolist()
    pace = fresh_start(layout, Pace(rate_hz=stream.rate_hz, times=times))
    return pace if stream.first is None else replace(pace, first=stream.first % layout.numbers)


def _summary(
    stream: Stream, transport: str, result: Exchange, layout: FrameLayout, own: int
) -> Summary:
    answered = result.complete
    compared = np.zeros_like(answered) if result.other_zero else answered
    followed, before = followed_by(stream.guarded, stream.counts, result.angles, compared)
    wanted = followed.values[compared]
    missing = reduce(or_, (status.missing_sensors for status in result.statuses), 0)
    suspected = reduce(or_, (health.suspected_sensors for health in result.healths), 0)
    return Summary(
        source=stream.source,
        transport=transport,
        snapshots=result.snapshots,
        answered=int(np.count_nonzero(answered)),
        rate_hz=result.rate_hz,
        lost_frames=result.lost_frames,
        corrupted=result.corrupted,
        unexpected=result.unexpected,
        mismatches=int(np.count_nonzero(result.angles[compared] != wanted)),
        faults=tuple(name for bit, name in enumerate(FAULTS) if result.faults >> bit & 1),
        error_percent_rom=_errors(stream, result) if compared.any() and stream.shapes else None,
        degraded_snapshots=int(np.count_nonzero(followed.states[compared].any(axis=1))),
        missing=layout.sensors_in(missing),
        suspected=layout.sensors_in(suspected),
        gone=result.gone,
        stranger=result.stranger(own),
        other_zero=result.other_zero,
        injected=stream.faults,
        left_out_before=tuple(stream.joint.sensors[j].name for j in before),
    )


def _errors(stream: Stream, result: Exchange) -> dict[str, AxisError]:
    off = stream.off_percent(result.angles[result.complete], result.complete)
    known = {axis: own[~np.isnan(own)] for axis, own in off.items()}
    return {
        axis: AxisError(float(own.mean()), float(own.max()))
        for axis, own in known.items()
        if own.size
    }
