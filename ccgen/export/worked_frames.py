"""LENGTHS frames worked out in full, for those who write a sender from the folder's README."""

from collections.abc import Sequence
from dataclasses import dataclass

from ccgen.can.layout import FrameLayout, FrameSpec
from ccgen.e2e import P01, P05

WORKED_NUMBER = 17
"""Number of the snapshot that is worked out: the second turn on classic CAN, counter 2."""

_STEP = 10
_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)
"""Bytes of a frame by its DLC."""


@dataclass(frozen=True)
class WorkedSnapshot:
    """A snapshot in full: its number, counts by sensor, and identifier and data by frame.

    Attributes:
        line: the first frame as SLCAN has it, without the CR at the end.
    """

    number: int
    turn: int
    counter: int
    counts: tuple[int, ...]
    frames: tuple[tuple[str, str], ...]
    line: str


def worked_snapshot(layout: FrameLayout, zeros: Sequence[int]) -> WorkedSnapshot:
    """Pack and protect the frames of one snapshot: each sensor 10 counts farther from its zero.

    Args:
        layout: of the joint.
        zeros: count of each sensor at the straight joint.
    """
    number = WORKED_NUMBER if layout.numbers > WORKED_NUMBER else WORKED_NUMBER % layout.numbers
    turn, counter = divmod(number, layout.counter_modulus)
    counts = tuple(zero + _STEP * (j + 1) for j, zero in enumerate(zeros))
    waiting = iter(counts)
    frames, lines = [], []
    for frame in layout.frames_of("lengths"):
        profile = P05 if layout.fd else P01
        data = _packed(layout, frame, turn, [next(waiting) for _ in frame.payload])
        sent = profile.protect(frame.data_id, counter, data)
        frames.append((f"0x{frame.id:03X}", sent.hex(" ")))
        lines.append(_slcan_line(layout, frame, sent))
    return WorkedSnapshot(number, turn, counter, counts, tuple(frames), lines[0])


def _packed(layout: FrameLayout, frame: FrameSpec, turn: int, counts: Sequence[int]) -> bytes:
    value = turn << 12 if layout.has_turn else 0
    for signal, count in zip(frame.payload, counts, strict=True):
        value |= (count % (1 << signal.bits)) << signal.start
    return value.to_bytes(frame.length, "little")


def _slcan_line(layout: FrameLayout, frame: FrameSpec, data: bytes) -> str:
    letter = ("b" if layout.rate_switch else "d") if layout.fd else "t"
    identifier = f"{frame.id:08X}" if layout.extended else f"{frame.id:03X}"
    start = letter.upper() if layout.extended else letter
    return f"{start}{identifier}{_LENGTHS.index(frame.length):X}{data.hex().upper()}"
