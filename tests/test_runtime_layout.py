"""Signals of every number of bytes, the impossible ones too (undefined behaviour ends the run)."""

import ctypes

import pytest
from runtime_c import load


def read_signed(data: bytes, width: int) -> int:
    return int(load().ccgen_get_signed(ctypes.c_char_p(data), ctypes.c_uint8(width)))


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_a_signal_is_read_back_as_it_was_written(width):
    top = 2 ** (8 * width - 1)
    for value in (0, 1, -1, top - 1, 1 - top, -top):
        data = ctypes.create_string_buffer(8)
        load().ccgen_put_signed(data, ctypes.c_uint8(width), ctypes.c_int32(value))
        assert data.raw == value.to_bytes(width, "little", signed=True) + bytes(8 - width)
        assert read_signed(data.raw, width) == value
    assert load().ccgen_no_reading(ctypes.c_uint8(width)) == -top


@pytest.mark.parametrize("width", [0, 5, 8, 255])
def test_a_signal_of_an_impossible_width_is_zero(width):
    assert read_signed(b"\xff" * 255, width) == 0
    assert load().ccgen_no_reading(ctypes.c_uint8(width)) == 0
