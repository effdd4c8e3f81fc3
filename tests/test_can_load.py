"""How long frames can be on the wire, against a bit stream that is stuffed bit by bit."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccgen.can.layout import FrameLayout
from ccgen.can.load import frame_bits, load_percent, snapshot_us

LAYOUT = FrameLayout(
    name="joint",
    base_id=0x300,
    extended=False,
    fd=False,
    sensors=("u0", "u1", "u2", "v0", "v1", "v2"),
    rows=(12, 12, 0),
    count_bytes=2,
    angle_bytes=2,
    cycle_ms=10,
    tip_fraction_bits=17,
)


def stuff_bits(bits):
    """Bits of the other value that a sender puts behind every five equal ones."""
    inserted, run, last = 0, 0, None
    for bit in bits:
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5:
            inserted, run, last = inserted + 1, 1, 1 - bit
    return inserted


def worst(length):
    """Five equal bits, then four of the other value in turn with four of the first."""
    return [max(k - 1, 0) // 4 % 2 for k in range(length)]


@pytest.mark.parametrize(
    ("extended", "fd", "kind", "stuffed", "fixed"),
    [
        (False, False, "lengths", 98, 13), (True, False, "lengths", 118, 13),
        (False, True, "lengths", 22 + 8 * 16, 40), (True, True, "lengths", 41 + 8 * 16, 40),
        (False, True, "angles", 22 + 8 * 64, 45), (True, True, "angles", 41 + 8 * 64, 45),
        (False, True, "status", 22 + 8 * 12, 40),
    ],
)  # fmt: skip
def test_a_frame_is_as_long_as_the_worst_bits_make_it(extended, fd, kind, stuffed, fixed):
    """On CAN FD 6 counts take 16 bytes, 24 angles 64, a status 12."""
    layout = replace(LAYOUT, extended=extended, fd=fd)
    frame = layout.frames_of(kind)[0]
    assert frame_bits(layout, frame) == stuffed + stuff_bits(worst(stuffed)) + fixed


@given(bits=st.lists(st.integers(0, 1), min_size=98, max_size=98))
def test_no_bits_make_a_standard_frame_longer(bits):
    assert 98 + stuff_bits(bits) + 13 <= frame_bits(LAYOUT, LAYOUT.frames[0]) == 135


def test_a_snapshot_takes_the_frames_there_and_back():
    assert snapshot_us(LAYOUT, 500_000) == 12 * 270.0
    assert snapshot_us(replace(LAYOUT, publish=("angles",)), 500_000) == 10 * 270.0


def test_on_can_fd_a_snapshot_takes_each_frame_as_long_as_it_is():
    layout = replace(LAYOUT, fd=True, publish=("angles", "status"))
    bits = [frame_bits(layout, layout.frames[k]) for k in (0, 1, 3)]
    assert [frame.kind for frame in layout.frames[:4]] == ["lengths", "angles", "tip", "status"]
    assert snapshot_us(layout, 1_000_000) == sum(bits)


def test_health_adds_a_frame_every_tenth_of_a_second():
    without = replace(LAYOUT, publish=("angles", "tip", "status"), commands=True)
    assert load_percent(without, 1_000_000) == pytest.approx(16.2)
    assert load_percent(replace(without, cycle_ms=1), 1_000_000) == pytest.approx(162.0)
    assert load_percent(LAYOUT, 1_000_000) == pytest.approx(16.2 + 0.135)
