"""Conversions of words to signed numbers, whatever the compiler makes of its own."""

import ctypes

import pytest
from hypothesis import given
from hypothesis import strategies as st
from runtime_c import load

LOWER_HALF, UPPER_HALF = 1, 2
words = st.integers(0, 2**64 - 1)


def signed(what: int, word: int) -> int:
    function = load().probe_signed
    function.restype = ctypes.c_int64
    return int(function(what, ctypes.c_uint64(word)))


@pytest.mark.parametrize("bits", [16, 32, 64])
def test_the_ends_of_a_type_and_what_lies_beside_them_are_converted(bits):
    top = 2 ** (bits - 1)
    for value in (0, 1, -1, 2, -2, top - 2, top - 1, 1 - top, -top):
        assert signed(bits, value % 2**bits) == value


@given(words, st.sampled_from([16, 32, 64]))
def test_any_word_keeps_its_bits(word, bits):
    word %= 2**bits
    assert signed(bits, word) == word - (2**bits if word >= 2 ** (bits - 1) else 0)


@given(words)
def test_halves_of_a_word_are_signed_numbers_of_16_bits(word):
    word %= 2**32
    halves = memoryview(word.to_bytes(4, "little")).cast("h")
    assert [signed(LOWER_HALF, word), signed(UPPER_HALF, word)] == list(halves)
