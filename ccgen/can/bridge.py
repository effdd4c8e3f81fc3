"""Simulated lengths to a node and its estimates back, compared with the true shape."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import can
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.can.codec import Codec
from ccgen.can.exchange import Answer, Exchange, Pace, exchange, fresh_start
from ccgen.can.fingerprint import fingerprint
from ccgen.can.layout import FAULTS, longest, tip_fraction_bits
from ccgen.errors import InputError
from ccgen.fixedpoint import FixedPointModel
from ccgen.joint import AXES, Joint
from ccgen.sensing.counts import counts as counts_at
from ccgen.sensing.motion import joint_motion
from ccgen.shapes import ShapeLibrary, Shapes

Floats = NDArray[np.float64]

_ROUND_SECONDS = 10.0
"""Time that one round of a simulated motion takes."""


@dataclass(frozen=True, eq=False)
class Stream:
    """What is sent: k snapshots at a rate, and the shapes behind them.

    Attributes:
        joint, model: of the exported folder.
        source: name of the motion.
        rate_hz: snapshots a second.
        shapes: true states.
        counts: shape (k, n).
    """

    joint: Joint
    model: FixedPointModel
    source: str
    rate_hz: float
    shapes: Shapes
    counts: NDArray[np.int64]

    @property
    def tip_fraction_bits(self) -> int:
        """A tip coordinate of 1 m is 2^tip_fraction_bits on the bus."""
        return tip_fraction_bits(longest(self.joint.geometry))

    def true_values(self, index: int | NDArray[np.bool_]) -> dict[str, Floats]:
        """True values of snapshots by axis, shape (..., m): radians, shares of lengths."""
        return {axis: getattr(self.shapes, axis)[index] for axis in self.model.axes}

    def estimated_values(self, raw: ArrayLike) -> dict[str, Floats]:
        """Raw values of answers by axis, shape (..., m): radians, shares of lengths."""
        parts = self.model.split(np.asarray(raw, dtype=np.int64))
        return {axis: self.model.axis(axis).radians(part) for axis, part in parts.items()}

    def off_percent(self, raw: ArrayLike, index: int | NDArray[np.bool_]) -> dict[str, Floats]:
        """How far each value of answers is off by axis: % of range (eq. 12); "h": of the length."""
        estimated, true = self.estimated_values(raw), self.true_values(index)
        units = dict.fromkeys(AXES, self.joint.geometry.range_of_motion) | {"h": 1.0}
        return {
            axis: 100.0 / units[axis] * np.abs(estimated[axis] - true[axis]) for axis in estimated
        }

    def error_percent_rom(self, answer: Answer) -> dict[str, float]:
        """Mean absolute error of an answer's values by axis, as of `off_percent`."""
        off = self.off_percent(answer.angles, answer.index)
        return {axis: float(own.mean()) for axis, own in off.items()}


def simulated_stream(
    joint: Joint,
    model: FixedPointModel,
    library: ShapeLibrary,
    source: str,
    seconds: float,
    rate_hz: float,
) -> Stream:
    """Prepare the snapshots of a simulated motion.

    Args:
        joint, model: of the exported folder.
        library: shapes of the joint.
        source: one of `ccgen.sensing.motion.SOURCES`.
        seconds: how long the stream lasts; at least one snapshot is sent.
        rate_hz: snapshots a second.
    """
    count, period = max(1, round(seconds * rate_hz)), max(1, round(_ROUND_SECONDS * rate_hz))
    shapes = joint_motion(joint, source, library, count, period)
    counts = counts_at(joint, [group.around() for group in model.groups], shapes)
    return Stream(joint, model, source, rate_hz, shapes, counts)


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
        mismatches: angles that differ from the integer reference model.
        faults: names of the faults that the node reported.
        error_percent_rom: per axis, over the answered snapshots; None without any.
        gone: as of `Exchange`.
        stranger: what tells that the node is of another model; empty where it is not.
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
    gone: str = ""
    stranger: str = ""

    @property
    def passed(self) -> bool:
        """Whether every frame came and every angle is the reference model's."""
        whole = self.answered > 0 and self.lost_frames == 0
        complete = whole and not self.gone and not self.stranger
        return complete and self.mismatches == 0

    def record(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def bridge(
    bus: can.BusABC,
    codec: Codec,
    stream: Stream,
    transport: str,
    on_answer: Callable[[Answer], None] | None = None,
) -> Summary:
    """Send a stream at its rate and sum up what came back.

    A sender that ran before on this bus may have been another: see `fresh_start`.

    Raises:
        InputError: the joint does not publish its angles.
    """
    if not codec.layout.publishes("angles"):
        raise InputError(
            f'{stream.joint.source}: can.publish: leaves out "angles", which bridge compares; '
            "publish them"
        )
    pace = fresh_start(codec.layout, Pace(rate_hz=stream.rate_hz))
    result = exchange(bus, codec, stream.counts, pace, on_answer)
    own = fingerprint(stream.model, codec.layout) & 0xFFFF
    return _summary(stream, transport, result, own)


def _summary(stream: Stream, transport: str, result: Exchange, own: int) -> Summary:
    answered = result.complete
    wanted = stream.model.estimate(stream.counts[answered])
    return Summary(
        source=stream.source,
        transport=transport,
        snapshots=result.snapshots,
        answered=int(np.count_nonzero(answered)),
        rate_hz=result.rate_hz,
        lost_frames=result.lost_frames,
        corrupted=result.corrupted,
        unexpected=result.unexpected,
        mismatches=int(np.count_nonzero(result.angles[answered] != wanted)),
        faults=tuple(name for bit, name in enumerate(FAULTS) if result.faults >> bit & 1),
        error_percent_rom=_errors(stream, result) if answered.any() else None,
        gone=result.gone,
        stranger=result.stranger(own),
    )


def _errors(stream: Stream, result: Exchange) -> dict[str, AxisError]:
    off = stream.off_percent(result.angles[result.complete], result.complete)
    return {axis: AxisError(float(own.mean()), float(own.max())) for axis, own in off.items()}
