"""Which signal lies where in which frame: the Python mirror of `ccgen/layout.h`.

A joint owns consecutive identifiers from `base_id`: the LENGTHS frames that sensors send, the
ANGLES frames that the node answers with (u, v, then h), one TIP, one STATUS, one HEALTH and one
COMMAND frame. A frame has 8 bytes, on CAN FD as many as it needs (12, 16, 20, 24, 32, 48 or 64),
and opens with the header of an end-to-end profile: P01 on classic CAN (CRC-8, 4-bit counter), P05
on CAN FD (CRC-16, 8-bit counter). Signals follow the header without gaps, little-endian; bytes left
over are zero. The most negative value of a signed signal means: no reading. What a joint does not
publish, or obey, keeps its identifier.

Every sending of the sensors has a number, which LENGTHS, ANGLES and TIP carry: on CAN FD the
counter; on classic CAN `turn * 15 + counter`, where the turn lies in the nibble that P01 leaves to
the payload, or the counter alone where senders cannot set it. STATUS and HEALTH frames count
themselves; the counter of a COMMAND is its sender's.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol

from ccgen.errors import InputError
from ccgen.joint import Geometry, Joint
from ccgen.joint.frames import (
    SINGLE_FRAMES,
    frame_bytes,
    frame_length,
    frames_for,
    header_bytes,
    values_per_frame,
)
from ccgen.joint.specification import OUTPUT_AXES, PUBLISHED

Kind = Literal["lengths", "angles", "tip", "status", "health", "command"]
Quantity = Literal[
    "crc", "counter", "turn", "length", "angle_u", "angle_v", "elongation", "tip",
    "sample_counter", "missing_sensors", "faults", "age", "fingerprint", "suspected_sensors",
    "axis_state", "zero_state", "command_number", "command_result", "command", "command_snapshots",
]  # fmt: skip

FAULT_MEANINGS = {
    "CRC": "a LENGTHS frame had a wrong check value; it was ignored",
    "FORMAT": "a LENGTHS frame had a wrong kind, length or counter; it was ignored",
    "REPEATED": "a LENGTHS frame was there already; it was ignored",
    "REORDERED": "a LENGTHS frame was older than the newest snapshot; it was ignored",
    "LOST": "a snapshot stayed incomplete, or numbers were skipped",
    "LATE": "a snapshot's frames spread over more than the window; it was dropped",
    "MISSING": "a sensor's count was out of its range",
    "STALE": "no complete snapshot for more than three cycles",
}
"""What the bits of the STATUS frame's `faults` say, bit 0 first."""

FAULTS = tuple(FAULT_MEANINGS)
"""Names of those bits."""

AXIS_STATES = ("good", "degraded", "lost", "not estimated")
"""What the two bits of an axis in HEALTH say, from 0."""

ZERO_STATES = ("of the model", "captured", "restored")
"""Whose zeros the node estimates with, as HEALTH says it, from 0."""
ZERO_OF_THE_MODEL = 0

COMMANDS = {
    1: "capture the zero from the next snapshots",
    2: "back to the zero of the model",
    3: "back to the zero that was restored last",
}
"""What COMMAND asks for."""

RESULT_MEANINGS = {
    "NONE": "no command yet",
    "DONE": "done",
    "BUSY": "capturing",
    "SILENCE": "no complete snapshot for a second; nothing changed",
    "MOVING": "the joint moved; nothing changed",
    "RANGE": "a reading is too near an end of its range for a zero; nothing changed",
    "UNKNOWN": "no such command, or no snapshots; nothing changed",
    "NOTHING": "no zero was restored that could be gone back to; nothing changed",
}
"""What became of the last command, as HEALTH says it, from 0."""

HEALTH_MS = 100
"""Longest time between two HEALTH frames, milliseconds."""

WINDOW_CYCLES = 100
"""Widest window of a snapshot in cycles: a frame may be late by half the numbers, and a window must
fit into the rest of them."""

WINDOW_CYCLES_WITHOUT_TURN = 6
"""The same where the number is the counter of P01 alone."""

_V_BIT = 8
"""Bit of `missing_sensors` where the paper's v sensors begin; the u sensors begin at bit 0."""

LENGTH = "length_"
"""Beginning of the signals of LENGTHS frames; the sensor's name follows."""

LARGEST_ID = {False: 0x7FF, True: 0x1FFFFFFF}
_LARGEST_TIP = 2**15 - 1


@dataclass(frozen=True)
class Signal:
    """One signal: `start` and `bits` count from the least significant bit of byte 0."""

    name: str
    start: int
    bits: int
    signed: bool
    quantity: Quantity

    @property
    def no_reading(self) -> int:
        """The raw value that says there is no reading; signed signals only."""
        return -(1 << (self.bits - 1))

    @property
    def raw_range(self) -> tuple[int, int]:
        """Lowest and highest raw value that its bits hold."""
        lowest = self.no_reading if self.signed else 0
        return lowest, lowest + (1 << self.bits) - 1


@dataclass(frozen=True)
class FrameSpec:
    """One frame of the joint, `length` bytes; `data_id` enters its checksum without being sent."""

    id: int
    name: str
    kind: Kind
    length: int
    signals: tuple[Signal, ...]

    @property
    def data_id(self) -> int:
        """The E2E data ID: the low 16 bits of the identifier."""
        return self.id & 0xFFFF

    @property
    def payload(self) -> tuple[Signal, ...]:
        """The signals that are not of the header."""
        return tuple(s for s in self.signals if s.quantity not in ("crc", "counter", "turn"))


@dataclass(frozen=True)
class FrameLayout:
    """Where every signal of a joint lies on the bus; mirrors the C struct `ccgen_layout_t`."""

    name: str
    base_id: int
    extended: bool
    fd: bool
    sensors: tuple[str, ...]
    """Names in the order of the counts."""
    rows: tuple[int, int, int]
    """Values of u, v and h: segments or sections, 0 for an axis that is not estimated."""
    count_bytes: int
    angle_bytes: int
    cycle_ms: int
    tip_fraction_bits: int
    turn: bool = True
    publish: tuple[str, ...] = PUBLISHED
    rate_switch: bool = False
    commands: bool = False
    own_sets: bool = False
    """Whether the sensors are the paper's two sets, which the missing sensors are told by."""

    @property
    def values(self) -> int:
        """Values of all axes, one after the other in the ANGLES frames."""
        return sum(self.rows)

    @property
    def missing_bits(self) -> tuple[int, ...]:
        """Bit of each sensor in `missing_sensors`."""
        if not self.own_sets:
            return tuple(range(len(self.sensors)))
        u = sum(name.startswith("u") for name in self.sensors)
        return tuple(j if j < u else _V_BIT + j - u for j in range(len(self.sensors)))

    def sensors_in(self, mask: int) -> tuple[str, ...]:
        """Names of the sensors in a mask such as `missing_sensors`."""
        named = zip(self.sensors, self.missing_bits, strict=True)
        return tuple(name for name, bit in named if mask >> bit & 1)

    @property
    def frame_bytes(self) -> int:
        """Length of LENGTHS and ANGLES frames, but for the last of each."""
        return frame_bytes(self.fd)

    @property
    def header_bytes(self) -> int:
        """Bytes of the end-to-end header: 2 for P01, 3 for P05."""
        return header_bytes(self.fd)

    @property
    def counter_modulus(self) -> int:
        """Values that the header's counter takes: 15 for P01, 256 for P05."""
        return 256 if self.fd else 15

    @property
    def has_turn(self) -> bool:
        """Whether numbers have a turn beside the counter of P01."""
        return self.turn and not self.fd

    @property
    def numbers(self) -> int:
        """How many numbers there are: 256 on CAN FD, else 240, or 15 without the turn."""
        return 16 * self.counter_modulus if self.has_turn else self.counter_modulus

    @property
    def latest_cycles(self) -> int:
        """Cycles after its sending in which a frame must have arrived: fewer than these."""
        return (self.numbers + 1) // 2

    @property
    def seen_cycles(self) -> int:
        """Cycles after its sending in which a number must not come round."""
        return self.latest_cycles + self.window_cycles

    @property
    def spare_numbers(self) -> int:
        """How far the numbers of a sender may run ahead of the cycles, in any `seen_cycles`."""
        return self.numbers - self.seen_cycles

    @property
    def window_cycles(self) -> int:
        """Widest window that a node may have, in cycles."""
        return WINDOW_CYCLES if self.fd or self.turn else WINDOW_CYCLES_WITHOUT_TURN

    @property
    def window_max_us(self) -> int:
        """Widest window that a node may have, microseconds."""
        return self.window_cycles * self.cycle_us

    @property
    def cycle_us(self) -> int:
        """Period of snapshots, and the longest time between two STATUS frames, microseconds."""
        return 1000 * self.cycle_ms

    @property
    def window_us(self) -> int:
        """Time within which all frames of one snapshot must arrive, microseconds."""
        return self.cycle_us

    @property
    def counts_per_frame(self) -> int:
        """Sensor counts that fit a LENGTHS frame."""
        return values_per_frame(self.fd, self.count_bytes)

    @property
    def angles_per_frame(self) -> int:
        """Angles that fit an ANGLES frame."""
        return values_per_frame(self.fd, self.angle_bytes)

    @property
    def lengths_frames(self) -> int:
        """LENGTHS frames of a snapshot."""
        return frames_for(len(self.sensors), self.fd, self.count_bytes)

    @property
    def angles_frames(self) -> int:
        """ANGLES frames of a snapshot."""
        return frames_for(self.values, self.fd, self.angle_bytes)

    @property
    def numbered_frames(self) -> int:
        """Frames of an answer that carry the number of their snapshot: angles and tip."""
        return self.angles_frames * self.publishes("angles") + self.publishes("tip")

    @property
    def answer_frames(self) -> int:
        """Frames with which a node answers one snapshot: angles, tip and status."""
        return self.numbered_frames + self.publishes("status")

    @property
    def last_id(self) -> int:
        """The highest identifier of the joint, that of its COMMAND frame."""
        return self.base_id + self.lengths_frames + self.angles_frames + SINGLE_FRAMES - 1

    @cached_property
    def frames(self) -> tuple[FrameSpec, ...]:
        """Every frame in the order of the identifiers, with those that are left out."""
        return tuple(self._frames())

    @property
    def used_frames(self) -> tuple[FrameSpec, ...]:
        """The frames that are met on the bus."""
        return tuple(frame for frame in self.frames if self._uses(frame.kind))

    def publishes(self, kind: Kind) -> bool:
        """Return whether the node sends frames of this kind."""
        return kind in self.publish

    def _uses(self, kind: Kind) -> bool:
        return kind == "lengths" or self.publishes(kind) or (kind == "command" and self.commands)

    def frames_of(self, kind: Kind) -> tuple[FrameSpec, ...]:
        """Return the frames of one kind in the order of the identifiers."""
        return tuple(frame for frame in self.frames if frame.kind == kind)

    def _frames(self) -> Iterator[FrameSpec]:
        next_id = self.base_id
        lists: tuple[tuple[Kind, list[tuple[str, Quantity]], int, int], ...] = (
            ("lengths", _lengths(self), self.count_bytes, self.counts_per_frame),
            ("angles", _angles(self), self.angle_bytes, self.angles_per_frame),
        )
        for kind, values, size, share in lists:
            for k, first in enumerate(range(0, len(values), share)):
                payload = ((*value, 8 * size, True) for value in values[first : first + share])
                yield self._frame(next_id, kind, f"_{k}", payload)
                next_id += 1
        yield self._frame(next_id, "tip", "", ((f"tip_{x}", "tip", 16, True) for x in "xyz"))
        yield self._frame(next_id + 1, "status", "", _STATUS)
        yield self._frame(next_id + 2, "health", "", _HEALTH)
        yield self._frame(next_id + 3, "command", "", _COMMAND)

    def _frame(
        self, frame_id: int, kind: Kind, suffix: str, payload: Iterable["_Field"]
    ) -> FrameSpec:
        name = f"{self.name.upper()}_{kind.upper()}{suffix}"
        header = _P05_HEADER if self.fd else _P01_HEADER
        if self.has_turn and kind in ("lengths", "angles", "tip"):
            header = (*header, _TURN)
        values = tuple(_packed(8 * self.header_bytes, payload))
        length = frame_length(self.fd, sum(s.bits for s in values) // 8)
        return FrameSpec(frame_id, name, kind, length, (*header, *values))


_Field = tuple[str, Quantity, int, bool]

_Header = tuple[Signal, ...]

_P01_HEADER: _Header = (
    Signal("crc", 0, 8, False, "crc"),
    Signal("counter", 8, 4, False, "counter"),
)
_P05_HEADER: _Header = (
    Signal("crc", 0, 16, False, "crc"),
    Signal("counter", 16, 8, False, "counter"),
)
_TURN = Signal("turn", 12, 4, False, "turn")
_STATUS: tuple[_Field, ...] = (
    ("sample_counter", "sample_counter", 16, False),
    ("missing_sensors", "missing_sensors", 16, False),
    ("faults", "faults", 8, False),
    ("age", "age", 8, False),
)
_HEALTH: tuple[_Field, ...] = (
    ("fingerprint", "fingerprint", 16, False),
    ("suspected_sensors", "suspected_sensors", 16, False),
    *((f"axis_{axis}", "axis_state", 2, False) for axis in OUTPUT_AXES),
    ("zero", "zero_state", 2, False),
    ("last_command", "command_number", 4, False),
    ("result", "command_result", 4, False),
)
_COMMAND: tuple[_Field, ...] = (
    ("number", "command_number", 4, False),
    ("command", "command", 4, False),
    ("snapshots", "command_snapshots", 8, False),
)


def _lengths(layout: FrameLayout) -> list[tuple[str, Quantity]]:
    return [(f"{LENGTH}{name}", "length") for name in layout.sensors]


def _angles(layout: FrameLayout) -> list[tuple[str, Quantity]]:
    axes: tuple[tuple[str, Quantity], ...] = (
        ("angle_u", "angle_u"),
        ("angle_v", "angle_v"),
        ("elongation_h", "elongation"),
    )
    return [
        (f"{name}{i}", quantity)
        for (name, quantity), rows in zip(axes, layout.rows, strict=True)
        for i in range(rows)
    ]


def _packed(start: int, fields: Iterable[_Field]) -> Iterator[Signal]:
    for name, quantity, bits, signed in fields:
        yield Signal(name, start, bits, signed, quantity)
        start += bits


class CountRanges(Protocol):
    """The counts' ranges of all sensors, both ends included."""

    @property
    def minimum(self) -> Iterable[int]:
        """Lowest count per sensor."""

    @property
    def maximum(self) -> Iterable[int]:
        """Highest count per sensor."""


def layout_for(joint: Joint, ranges: CountRanges) -> FrameLayout:
    """Lay out the frames of a joint whose sensors count within `ranges`.

    Raises:
        InputError: the identifiers from `can.base_id` on exceed what the bus has.
    """
    layout = FrameLayout(
        name=joint.name,
        base_id=joint.can.base_id,
        extended=joint.can.extended,
        fd=joint.can.fd,
        sensors=tuple(sensor.name for sensor in joint.sensors),
        rows=_rows(joint),
        count_bytes=_count_bytes(joint.precision, ranges),
        angle_bytes=joint.precision // 8,
        cycle_ms=joint.can.cycle_ms,
        tip_fraction_bits=tip_fraction_bits(longest(joint.geometry)),
        turn=joint.can.turn,
        publish=joint.can.publish,
        rate_switch=joint.can.rate_switch,
        commands=joint.can.commands,
        own_sets=has_own_sets(joint),
    )
    largest = LARGEST_ID[layout.extended]
    if layout.last_id > largest:
        highest_base = largest - (layout.last_id - layout.base_id)
        raise InputError(
            f"{joint.source}: can.base_id: {layout.last_id - layout.base_id + 1} frames from "
            f"{layout.base_id:#x} on exceed the last identifier {largest:#x}; "
            f"at most {highest_base:#x} would fit"
        )
    return layout


def has_own_sets(joint: Joint) -> bool:
    """Whether the sensors are the paper's sets, of which each axis reads its own."""
    return (joint.u is not None or joint.v is not None) and not joint.couples


def _rows(joint: Joint) -> tuple[int, int, int]:
    u, v, h = (
        joint.rows(axis).stop - joint.rows(axis).start if axis in joint.axes else 0
        for axis in OUTPUT_AXES
    )
    return u, v, h


def longest(geometry: Geometry) -> float:
    """Length of the joint at its largest elongation, metres."""
    return geometry.length * (1.0 + max(0.0, *(geometry.elongation or (0.0, 0.0))))


def tip_fraction_bits(length: float) -> int:
    """Largest f for which a joint of this length (m) keeps |tip| * 2^f within int16, 0 to 30."""
    return max(f for f in range(31) if f == 0 or length * 2.0**f <= _LARGEST_TIP)


def _count_bytes(precision: int, ranges: CountRanges) -> int:
    """Bytes that hold every count and, as one value more, "no reading"."""
    if precision == 16:
        return 2
    largest = 2**23 - 1
    ends = zip(ranges.minimum, ranges.maximum, strict=True)
    return 3 if all(-largest <= low and high <= largest for low, high in ends) else 4
