"""Bit timing of the ports for CAN controllers: from a clock and a bit rate."""

import ctypes
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st
from runtime_c import PORTS, UNDEFINED, compile_c, next_build

BXCAN = (1024, 1, 16, 1, 8, 4)
NOMINAL = (512, 1, 256, 1, 128, 128)
DATA = (32, 1, 32, 1, 16, 16)
TIGHT = (4, 1, 6, 2, 3, 1)
CLOCKS = tuple(1_000_000 * f for f in (8, 16, 20, 24, 30, 36, 40, 42, 45, 48, 54, 64, 80, 84, 170))
RATES = (10_000, 83_333, 125_000, 250_000, 500_000, 800_000, 1_000_000, 2_000_000, 5_000_000)


class Limits(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_uint16)
        for name in ["prescaler", "s1_min", "s1_max", "s2_min", "s2_max", "j"]
    ]


class Timing(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint16) for name in ("prescaler", "segment1", "segment2", "jump")]


@cache
def library() -> ctypes.CDLL:
    flags = (f"-I{PORTS / 'can'}", "-shared", "-fPIC", "-O1", *UNDEFINED)
    built = ctypes.CDLL(
        str(compile_c([PORTS / "can" / "can_timing.c"], flags, target=next_build()))
    )
    built.can_timing_find.restype = ctypes.c_bool
    return built


def find(clock_hz, bitrate, limits):
    """The timing, or None."""
    timing = Timing()
    found = library().can_timing_find(
        ctypes.c_uint32(clock_hz), ctypes.c_uint32(bitrate), ctypes.byref(Limits(*limits)),
        ctypes.byref(timing),
    )  # fmt: skip
    return timing if found else None


def every(clock_hz, bitrate, limits):
    """All that the limits allow, (how far the sample point is off, prescaler), by trial."""
    prescaler_most, s1_min, s1_max, s2_min, s2_max, _ = limits
    wanted = 750 if bitrate > 800_000 else 800 if bitrate > 500_000 else 875
    for prescaler in range(1, prescaler_most + 1):
        quanta, rest = divmod(clock_hz, bitrate * prescaler)
        for segment2 in range(s2_min, s2_max + 1) if not rest and quanta >= 4 else ():
            segment1 = quanta - 1 - segment2
            sampled = 1000 * (1 + segment1) // quanta
            if s1_min <= segment1 <= s1_max and 700 <= sampled <= 900:
                yield abs(sampled - wanted), prescaler, segment1, segment2


@given(
    st.sampled_from(CLOCKS), st.sampled_from(RATES), st.sampled_from((BXCAN, NOMINAL, DATA, TIGHT))
)
def test_a_timing_is_as_near_to_the_sample_point_as_any(clock_hz, bitrate, limits):
    timing, all_ = find(clock_hz, bitrate, limits), list(every(clock_hz, bitrate, limits))
    if timing is None:
        assert not all_
        return
    quanta = 1 + timing.segment1 + timing.segment2
    assert quanta * timing.prescaler * bitrate == clock_hz
    off = {(p, s1, s2): value for value, p, s1, s2 in all_}
    found = off[timing.prescaler, timing.segment1, timing.segment2]
    assert found == min(off.values())
    assert timing.prescaler == min(p for (p, *_), value in off.items() if value == found)
    assert timing.jump == min(timing.segment2, limits[-1])


@pytest.mark.parametrize(
    ("clock_hz", "bitrate", "limits", "expected"),
    [
        (8_000_000, 500_000, BXCAN, (1, 13, 2, 2)),  # the tables of CiA 301 and of vendors
        (16_000_000, 1_000_000, BXCAN, (1, 11, 4, 4)),
        (42_000_000, 500_000, BXCAN, (6, 11, 2, 2)),
        (80_000_000, 1_000_000, NOMINAL, (1, 59, 20, 20)),
        (80_000_000, 5_000_000, DATA, (1, 11, 4, 4)),
        (20_000_000, 500_000, TIGHT, (4, 6, 3, 1)),  # the largest prescaler and second segment
    ],
)
def test_known_timings(clock_hz, bitrate, limits, expected):
    timing = find(clock_hz, bitrate, limits)
    assert (timing.prescaler, timing.segment1, timing.segment2, timing.jump) == expected


@pytest.mark.parametrize(
    ("clock_hz", "bitrate"),
    [(0, 500_000), (8_000_000, 0), (8_000_000, 83_333), (3_000_000, 1_000_000), (7, 8)],
)
def test_a_bit_rate_that_the_clock_does_not_give_is_refused(clock_hz, bitrate):
    assert find(clock_hz, bitrate, BXCAN) is None


def test_a_bit_that_would_be_sampled_too_early_is_refused():
    assert find(2_500_000, 500_000, TIGHT) is None  # 5 quanta of which 2 come last: at 60 %
