"""How much of a bus a joint takes: its frames, each as long as stuffing can make it."""

from ccgen.can.layout import HEALTH_MS, FrameLayout, FrameSpec, Kind

_CLASSIC_BITS = {False: 34, True: 54}
"""Stuffed bits of a classic frame beside its data, standard and extended: SOF to CRC."""

_FD_BITS = {False: 22, True: 41}
"""Stuffed bits of a CAN FD frame beside its data: SOF to DLC."""

_FD_CHECK_BITS = {False: 27, True: 32}
"""Stuff count, CRC and their fixed stuff bits: 17 bits of CRC, beyond 16 bytes of data 21."""

_OF_A_SNAPSHOT: tuple[Kind, ...] = ("lengths", "angles", "tip", "status")

_TAIL_BITS = 13
"""Never stuffed: CRC delimiter, acknowledgement, end of frame, and the gap to the next frame."""


def frame_bits(layout: FrameLayout, frame: FrameSpec) -> int:
    """Bits that a frame of the joint takes at most, the gap behind it included (ISO 11898-1).

    A run of five equal bits is broken by a stuff bit, which may open the next run: at worst one
    after the first five bits and one after every four more.
    """
    overhead = _FD_BITS if layout.fd else _CLASSIC_BITS
    stuffed = overhead[layout.extended] + 8 * frame.length
    check = _FD_CHECK_BITS[frame.length > 16] if layout.fd else 0
    return stuffed + (stuffed - 1) // 4 + check + _TAIL_BITS


def snapshot_us(layout: FrameLayout, bitrate: int) -> float:
    """Time on the bus of one snapshot and its answer at worst, microseconds.

    On CAN FD without the faster bit rate for data, which adapters set by themselves.

    Args:
        layout: the joint's frames.
        bitrate: bits per second.
    """
    return sum(_kind_us(layout, kind, bitrate) for kind in _OF_A_SNAPSHOT)


def load_percent(layout: FrameLayout, bitrate: int) -> float:
    """Share of the time that the joint's frames take at worst, per cent; over 100 does not fit.

    A snapshot and its answer every cycle, HEALTH as often as it comes, COMMAND never.
    """
    health = _kind_us(layout, "health", bitrate) / (1000.0 * HEALTH_MS)
    return 100.0 * (snapshot_us(layout, bitrate) / layout.cycle_us + health)


def _kind_us(layout: FrameLayout, kind: Kind, bitrate: int) -> float:
    """Time of all frames of a kind that are sent, microseconds."""
    sent = (frame for frame in layout.used_frames if frame.kind == kind)
    return sum(frame_bits(layout, frame) for frame in sent) * 1e6 / bitrate
