"""End-to-end protection in C against the catalogued check values and `autosar-e2e`."""

import ctypes

import e2e.p01
import e2e.p05
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runtime_c import UNDEFINED, load

P01, P05 = 0, 1
ARGUMENT, FORMAT, CRC = -1, -3, -4
CHECK = b"123456789"

data_ids = st.integers(0, 0xFFFF)
classic = st.binary(min_size=2, max_size=8)
fd = st.binary(min_size=3, max_size=64)


TABLES = (256, 16)


def library(entries: int = 256) -> ctypes.CDLL:
    """The runtime with tables of so many entries."""
    return load(("-O1", *UNDEFINED, *((f"-DCCGEN_CRC_TABLE={entries}",) if entries == 16 else ())))


def protect(profile: int, data_id: int, counter: int, data: bytes, entries: int = 256) -> bytes:
    c, buffer = library(entries), ctypes.create_string_buffer(data, len(data))
    key = c.ccgen_e2e_key(profile, ctypes.c_uint16(data_id))
    assert c.ccgen_e2e_protect(profile, key, counter, buffer, len(data)) == 0
    return buffer.raw


def check(profile: int, data_id: int, data: bytes, entries: int = 256) -> int:
    c = library(entries)
    key = c.ccgen_e2e_key(profile, ctypes.c_uint16(data_id))
    return c.ccgen_e2e_check(profile, key, bytes(data), len(data))


def test_crc8_gives_its_check_value():
    """P01 covers the ID's two bytes, then bytes 1 and on: here the digits 1 to 9."""
    data_id = CHECK[0] | CHECK[1] << 8
    protected = protect(P01, data_id, CHECK[2] & 0x0F, b"\0" + CHECK[2:])
    assert protected[1:] == CHECK[2:]
    # 0x37 with start and xor 0 is the catalogued 0x4B with start and xor 0xFF: the register of
    # an all-ones start drowns in the message by linearity.
    start_of_ones = 0xFF
    for _ in range(8 * len(CHECK)):
        start_of_ones = (start_of_ones << 1 ^ (0x1D if start_of_ones & 0x80 else 0)) & 0xFF
    assert protected[0] ^ start_of_ones ^ 0xFF == 0x4B


def test_crc16_gives_its_check_value():
    """P05 covers bytes 2 and on, then the ID's two bytes."""
    data_id = CHECK[7] | CHECK[8] << 8
    protected = protect(P05, data_id, CHECK[0], b"\0\0\0" + CHECK[1:7])
    assert protected[2:] == CHECK[:7]
    assert int.from_bytes(protected[:2], "little") == 0x29B1


@pytest.mark.parametrize("entries", TABLES)
@given(data_ids, st.integers(0, 14), classic)
def test_p01_equals_autosar_e2e(entries, data_id, counter, data):
    oracle = bytearray(data)
    oracle[1] = oracle[1] & 0xF0 | counter
    e2e.p01.e2e_p01_protect(oracle, data_id, increment_counter=False)
    assert protect(P01, data_id, counter, data, entries) == oracle
    assert check(P01, data_id, oracle, entries) == counter


@pytest.mark.parametrize("entries", TABLES)
@given(data_ids, st.integers(0, 255), fd)
def test_p05_equals_autosar_e2e(entries, data_id, counter, data):
    oracle = bytearray(data)
    oracle[2] = counter
    e2e.p05.e2e_p05_protect(oracle, data_id, increment_counter=False)
    assert protect(P05, data_id, counter, data, entries) == oracle
    assert check(P05, data_id, oracle, entries) == counter


@pytest.mark.parametrize("entries", TABLES)
@pytest.mark.parametrize(("profile", "length"), [(P01, 3), (P05, 4)])
def test_every_remainder_of_a_byte_is_right(profile, length, entries):
    """A table's entries all have their turn."""
    for byte in range(256):
        data = bytes(length - 1) + bytes((byte,))
        oracle = bytearray(data)
        if profile == P01:
            e2e.p01.e2e_p01_protect(oracle, 0x1234, increment_counter=False)
        else:
            e2e.p05.e2e_p05_protect(oracle, 0x1234, increment_counter=False)
        assert protect(profile, 0x1234, 0, data, entries) == oracle


@given(st.sampled_from([P01, P05]), data_ids, st.integers(0, 14), fd, st.data())
def test_every_single_bit_error_is_found(profile, data_id, counter, data, draw):
    protected = bytearray(protect(profile, data_id, counter, data))
    bit = draw.draw(st.integers(0, 8 * len(data) - 1))
    protected[bit // 8] ^= 1 << bit % 8
    assert check(profile, data_id, protected) == CRC


@given(st.sampled_from([P01, P05]), data_ids, st.integers(1, 255), st.sampled_from([0, 8]), fd)
def test_a_frame_under_another_identifier_is_refused(profile, sent, difference, shift, data):
    """Certain where the identifiers differ in one byte, as those of one joint do."""
    protected = protect(profile, sent, 3, data)
    assert check(profile, sent, protected) == 3
    assert check(profile, sent ^ difference << shift, protected) == CRC


def test_p01_counter_15_is_malformed():
    frame = bytearray(b"\0\x0f\1\2\3\4\5\6")
    e2e.p01.e2e_p01_protect(frame, 0x300, increment_counter=False)
    assert frame[1] & 0x0F == 15
    assert check(P01, 0x300, frame) == FORMAT


@pytest.mark.parametrize(("profile", "header", "modulus"), [(P01, 2, 15), (P05, 3, 256)])
def test_arguments_are_checked_and_nothing_is_written(profile, header, modulus):
    c = load()
    assert c.ccgen_e2e_counter_modulus(profile) == modulus
    data = ctypes.create_string_buffer(b"\xaa" * 8, 8)
    assert c.ccgen_e2e_protect(profile, 1, 0, None, 8) == ARGUMENT
    assert c.ccgen_e2e_check(profile, 1, None, 8) == ARGUMENT
    assert c.ccgen_e2e_protect(profile, 1, 0, data, header - 1) == FORMAT
    assert c.ccgen_e2e_check(profile, 1, data, header - 1) == FORMAT
    if profile == P01:
        assert c.ccgen_e2e_protect(profile, 1, 15, data, 8) == ARGUMENT
    assert data.raw == b"\xaa" * 8
