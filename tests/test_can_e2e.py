"""End-to-end protection against the standard's check values and an independent implementation."""

import e2e.p01
import e2e.p05
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccgen.e2e import P01, P05, ProtectionError, crc8_j1850, crc16_ccitt_false

CHECK = b"123456789"
data_ids = st.integers(0, 0xFFFF)
classic = st.binary(min_size=2, max_size=8)
fd = st.binary(min_size=3, max_size=64)


def test_checksums_give_the_catalogued_check_values():
    assert crc8_j1850(CHECK) == 0x4B
    assert crc16_ccitt_false(CHECK) == 0x29B1


@given(data_ids, st.integers(0, 14), classic)
def test_p01_equals_autosar_e2e(data_id, counter, data):
    """The nibble beside the counter is payload: it stays, and the checksum covers it."""
    protected = P01.protect(data_id, counter, data)
    oracle = bytearray(data)
    oracle[1] = (data[1] & 0xF0) | counter
    e2e.p01.e2e_p01_protect(oracle, data_id, increment_counter=False)
    assert protected == oracle
    assert e2e.p01.e2e_p01_check(bytearray(protected), data_id)


@given(data_ids, st.integers(0, 255), fd)
def test_p05_equals_autosar_e2e(data_id, counter, data):
    protected = P05.protect(data_id, counter, data)
    oracle = bytearray(data)
    oracle[2] = counter
    e2e.p05.e2e_p05_protect(oracle, data_id, increment_counter=False)
    assert protected == oracle
    assert e2e.p05.e2e_p05_check(bytearray(protected), data_id)


@pytest.mark.parametrize("profile", [P01, P05])
@given(data_id=data_ids, counter=st.integers(0, 14), data=fd)
def test_a_protected_frame_gives_its_counter_and_payload_back(profile, data_id, counter, data):
    protected = profile.protect(data_id, counter, data)
    assert profile.check(data_id, protected) == counter
    assert protected[profile.header_bytes :] == data[profile.header_bytes :]


@pytest.mark.parametrize("profile", [P01, P05])
@given(data=st.binary(min_size=8, max_size=8), bit=st.integers(0, 63))
def test_every_single_bit_error_is_found(profile, data, bit):
    protected = bytearray(profile.protect(0x123, 5, data))
    protected[bit // 8] ^= 1 << bit % 8
    with pytest.raises(ProtectionError) as found:
        profile.check(0x123, protected)
    assert found.value.kind == "crc"


@given(
    data=st.binary(min_size=8, max_size=8), difference=st.integers(1, 255), byte=st.integers(0, 1)
)
def test_p01_finds_every_identifier_that_differs_in_one_byte(data, difference, byte):
    protected = P01.protect(0x123, 5, data)
    with pytest.raises(ProtectionError):
        P01.check(0x123 ^ difference << 8 * byte, protected)


@given(data=st.binary(min_size=8, max_size=8), other=data_ids.filter(lambda i: i != 0x123))
def test_p05_finds_every_other_identifier(data, other):
    protected = P05.protect(0x123, 5, data)
    with pytest.raises(ProtectionError):
        P05.check(other, protected)


def test_counter_fifteen_does_not_exist_in_p01():
    frame = bytearray(8)
    frame[1] = 15
    e2e.p01.e2e_p01_protect(frame, 0x300, increment_counter=False)
    with pytest.raises(ProtectionError, match="no counter 15") as found:
        P01.check(0x300, frame)
    assert found.value.kind == "format"


@pytest.mark.parametrize(("profile", "size"), [(P01, 1), (P05, 2)])
def test_a_frame_shorter_than_its_header_is_found(profile, size):
    with pytest.raises(ProtectionError) as found:
        profile.check(0, bytes(size))
    assert found.value.kind == "format"
    with pytest.raises(ValueError, match="cannot hold a header"):
        profile.protect(0, 0, bytes(size))


@pytest.mark.parametrize(("data_id", "counter"), [(-1, 0), (0x10000, 0), (0, -1), (0, 15)])
def test_what_p01_cannot_carry_is_refused(data_id, counter):
    with pytest.raises(ValueError, match="is not within"):
        P01.protect(data_id, counter, bytes(8))
