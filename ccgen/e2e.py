"""AUTOSAR end-to-end protection, profiles 1 and 5: checksum, counter and data ID of a frame.

Profile 1 (classic CAN): byte 0 is a CRC-8, the low nibble of byte 1 a counter 0..14; the data ID
enters the checksum with both bytes, low byte first, ahead of byte 1. Profile 5 (CAN FD): bytes 0
and 1 are a CRC-16, little-endian, byte 2 is a counter 0..255; the data ID follows the last byte.
The data ID itself is never sent: a frame under a wrong identifier fails its checksum.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Bytes = bytes | bytearray


class ProtectionError(ValueError):
    """A received frame that must not be used; `kind` tells checksum from form."""

    def __init__(self, kind: Literal["crc", "format"], message: str) -> None:
        super().__init__(message)
        self.kind = kind


def _table(polynomial: int, bits: int) -> tuple[int, ...]:
    """Remainders of every byte, most significant bit first."""
    top, mask = 1 << (bits - 1), (1 << bits) - 1
    table = []
    for byte in range(256):
        remainder = byte << (bits - 8)
        for _ in range(8):
            remainder = (remainder << 1) ^ (polynomial if remainder & top else 0)
        table.append(remainder & mask)
    return tuple(table)


_CRC8 = _table(0x1D, 8)
_CRC16 = _table(0x1021, 16)


def crc8_j1850(data: Bytes, start: int = 0xFF, xor: int = 0xFF) -> int:
    """CRC-8 SAE J1850 (polynomial 0x1D); the standalone check value is 0x4B."""
    table, crc = _CRC8, start
    for byte in data:
        crc = table[crc ^ byte]
    return crc ^ xor


def crc16_ccitt_false(data: Bytes, start: int = 0xFFFF) -> int:
    """CRC-16 CCITT-FALSE (polynomial 0x1021, not reflected); the check value is 0x29B1."""
    table, crc = _CRC16, start
    for byte in data:
        crc = ((crc << 8) & 0xFF00) ^ table[(crc >> 8) ^ byte]
    return crc


@dataclass(frozen=True)
class Profile:
    """One profile: where checksum and counter lie and what the checksum covers."""

    name: str
    crc_bytes: int
    counter_mask: int
    counter_modulus: int
    checksum: Callable[[int, Bytes], int]

    @property
    def header_bytes(self) -> int:
        """Bytes ahead of the payload: the checksum, then one byte with the counter."""
        return self.crc_bytes + 1

    def protect(self, data_id: int, counter: int, data: Bytes) -> bytes:
        """Return the frame's data with its header filled in.

        Args:
            data_id: 0..65535.
            counter: 0..`counter_modulus` - 1.
            data: the whole frame; checksum and counter in it are replaced. The high nibble beside
                the counter of P01 is payload and stays.

        Raises:
            ValueError: data ID or counter out of range, or a frame shorter than its header.
        """
        if not 0 <= data_id <= 0xFFFF:
            raise ValueError(f"data ID {data_id} is not within 0..65535")
        if not 0 <= counter < self.counter_modulus:
            raise ValueError(f"counter {counter} is not within 0..{self.counter_modulus - 1}")
        if len(data) < self.header_bytes:
            raise ValueError(f"{len(data)} bytes cannot hold a header of {self.header_bytes}")
        beside = data[self.crc_bytes] & ~self.counter_mask
        covered = bytes((beside | counter,)) + data[self.header_bytes :]
        return self.checksum(data_id, covered).to_bytes(self.crc_bytes, "little") + covered

    def check(self, data_id: int, data: Bytes) -> int:
        """Return the counter of a received frame whose checksum holds.

        Raises:
            ProtectionError: of kind "crc", or "format" for a frame too short for a header or a
                counter that the profile does not use.
        """
        if len(data) < self.header_bytes:
            raise ProtectionError("format", f"{len(data)} bytes hold no {self.name} header")
        sent = int.from_bytes(data[: self.crc_bytes], "little")
        if sent != self.checksum(data_id, data[self.crc_bytes :]):
            raise ProtectionError("crc", f"{self.name} checksum {sent:#x} does not hold")
        counter = data[self.crc_bytes] & self.counter_mask
        if counter >= self.counter_modulus:
            raise ProtectionError("format", f"{self.name} has no counter {counter}")
        return counter


def p01_key(data_id: int) -> int:
    """What the checksum of P01 takes from the data ID: the CRC of its bytes, which come first."""
    return _CRC8[_CRC8[data_id & 0xFF] ^ (data_id >> 8)]


def _p01_checksum(data_id: int, covered: Bytes) -> int:
    return crc8_j1850(covered, start=p01_key(data_id), xor=0x00)


def _p05_checksum(data_id: int, covered: Bytes) -> int:
    return crc16_ccitt_false(data_id.to_bytes(2, "little"), crc16_ccitt_false(covered))


P01 = Profile("P01", 1, 0x0F, 15, _p01_checksum)
P05 = Profile("P05", 2, 0xFF, 256, _p05_checksum)
