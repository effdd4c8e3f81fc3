"""How much of a bus a joint takes: its frames, each as long as stuffing can make it."""

from ccgen.can.layout import HEALTH_MS, FrameLayout

_CLASSIC_BITS = {False: 34, True: 54}
"""Stuffed bits of a classic frame beside its data, standard and extended: SOF to CRC."""

_FD_BITS = {False: 22, True: 41}
"""Stuffed bits of a CAN FD frame beside its data: SOF to DLC."""

_FD_CHECK_BITS = 32
"""Stuff count, 21-bit CRC and their fixed stuff bits, for more than 16 bytes of data."""

_TAIL_BITS = 13
"""Never stuffed: CRC delimiter, acknowledgement, end of frame, and the gap to the next frame."""


def frame_bits(layout: FrameLayout) -> int:
    """Bits that one frame of the joint takes at most, the gap behind it included (ISO 11898-1).

    A run of five equal bits is broken by a stuff bit, which may open the next run: at worst one
    after the first five bits and one after every four more.
    """
    overhead = _FD_BITS if layout.fd else _CLASSIC_BITS
    stuffed = overhead[layout.extended] + 8 * layout.frame_bytes
    check = _FD_CHECK_BITS if layout.fd else 0
    return stuffed + (stuffed - 1) // 4 + check + _TAIL_BITS


def snapshot_us(layout: FrameLayout, bitrate: int) -> float:
    """Time on the bus of one snapshot and its answer at worst, microseconds.

    On CAN FD without the faster bit rate for data, which adapters set by themselves.

    Args:
        layout: the joint's frames.
        bitrate: bits per second.
    """
    return (layout.lengths_frames + layout.answer_frames) * _frame_us(layout, bitrate)


def load_percent(layout: FrameLayout, bitrate: int) -> float:
    """Share of the time that the joint's frames take at worst, per cent; over 100 does not fit.

    A snapshot and its answer every cycle, HEALTH as often as it comes, COMMAND never.
    """
    health = _frame_us(layout, bitrate) / (1000.0 * HEALTH_MS) if layout.publishes("health") else 0
    return 100.0 * (snapshot_us(layout, bitrate) / layout.cycle_us + health)


def _frame_us(layout: FrameLayout, bitrate: int) -> float:
    return frame_bits(layout) * 1e6 / bitrate
