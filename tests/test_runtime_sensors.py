"""Which counts of a sensor are readings, and which zeros it accepts."""

import ctypes
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from runtime_c import UNDEFINED, compile_c

FUNCTIONS = """
#include "ccgen/sensors{bits}.h"
int missing{bits}(const ccgen_sensors{bits}_t *s, const int{bits}_t *z, const int{bits}_t *c);
int complete{bits}(const ccgen_sensors{bits}_t *s, const int{bits}_t *z, const int{bits}_t *c);
int outside{bits}(const int{bits}_t *a, const int{bits}_t *b, const int{bits}_t *v, uint8_t n);
int missing{bits}(const ccgen_sensors{bits}_t *s, const int{bits}_t *z, const int{bits}_t *c) {{
    return ccgen_sensors{bits}_missing(s, z, c);
}}
int complete{bits}(const ccgen_sensors{bits}_t *s, const int{bits}_t *z, const int{bits}_t *c) {{
    return ccgen_sensors{bits}_complete(s, z, c) ? 1 : 0;
}}
int outside{bits}(const int{bits}_t *a, const int{bits}_t *b, const int{bits}_t *v, uint8_t n) {{
    const ccgen_range{bits}_t range = {{a, b}};
    return ccgen_outside{bits}(&range, v, n);
}}
"""
TABLES = (
    "minimum", "maximum", "zero", "difference_minimum", "difference_maximum", "zero_minimum",
    "zero_maximum",
)  # fmt: skip


class Sensors(ctypes.Structure):
    """`ccgen_sensors16_t` and `ccgen_sensors32_t`."""

    _fields_ = (("sensors", ctypes.c_uint8), *((name, ctypes.c_void_p) for name in TABLES))


@cache
def library() -> ctypes.CDLL:
    with TemporaryDirectory() as folder:
        source = Path(folder) / "sensors.c"
        source.write_text(FUNCTIONS.format(bits=16) + FUNCTIONS.format(bits=32))
        return ctypes.CDLL(str(compile_c([source], ("-shared", "-fPIC", "-O1", *UNDEFINED))))


class Table:
    """Sensors of which each has limits of its own, and what C says of their counts."""

    def __init__(self, bits: int, sensors: int, relative: bool) -> None:
        self.bits, self.sensors = bits, sensors
        self.kind = (ctypes.c_int16 if bits == 16 else ctypes.c_int32) * sensors
        self.zero = [10 * j - 70 for j in range(sensors)]
        self.lowest, self.highest = 1 - 2 ** (bits - 1), 2 ** (bits - 1) - 1
        limits = (ctypes.c_int32 * sensors) if bits == 16 else self.kind
        below, above = [-100 - j for j in range(sensors)], [200 + j for j in range(sensors)]
        self.below, self.above = below, above
        self.held = {
            "minimum": self.kind(*[self.lowest] * sensors),
            "maximum": self.kind(*[self.highest] * sensors),
        }
        if relative:
            self.held["difference_minimum"] = limits(*below)
            self.held["difference_maximum"] = limits(*above)
        self.table = Sensors(sensors=sensors)
        for name, values in self.held.items():
            setattr(self.table, name, ctypes.addressof(values))

    def missing(self, counts: list[int]) -> int:
        """The mask, which `complete` must agree with."""
        arguments = (ctypes.byref(self.table), self.kind(*self.zero), self.kind(*counts))
        mask = int(getattr(library(), f"missing{self.bits}")(*arguments))
        complete = getattr(library(), f"complete{self.bits}")(*arguments)
        assert complete == int(mask == 0)
        return mask


@pytest.mark.parametrize("bits", [16, 32])
@pytest.mark.parametrize("sensors", [1, 2, 7, 8, 9, 16])
def test_a_count_farther_from_its_zero_than_its_limits_is_no_reading(bits, sensors):
    table = Table(bits, sensors, relative=True)
    assert table.missing(table.zero) == 0
    for j in range(sensors):
        for difference, missing in (
            (table.below[j], False), (table.below[j] - 1, True),
            (table.above[j], False), (table.above[j] + 1, True),
        ):  # fmt: skip
            counts = list(table.zero)
            counts[j] += difference
            assert table.missing(counts) == (1 << j if missing else 0)


@pytest.mark.parametrize("bits", [16, 32])
@pytest.mark.parametrize("sensors", [1, 8, 9, 16])
def test_without_such_limits_every_count_in_range_is_a_reading(bits, sensors):
    table = Table(bits, sensors, relative=False)
    for j in range(sensors):
        for count, missing in (
            (table.lowest, False),
            (table.lowest - 1, True),
            (table.highest, False),
        ):
            counts = list(table.zero)
            counts[j] = count
            assert table.missing(counts) == (1 << j if missing else 0)


@pytest.mark.parametrize("bits", [16, 32])
def test_ends_of_a_range_are_readings_and_what_lies_beside_them_is_none(bits):
    table = Table(bits, 3, relative=False)
    table.held["minimum"][:], table.held["maximum"][:] = [-5, -600, 7], [5, -500, 9]
    for j, (low, high) in enumerate(((-5, 5), (-600, -500), (7, 9))):
        for count, missing in ((low, 0), (low - 1, 1), (high, 0), (high + 1, 1)):
            counts = [0, -550, 8]
            counts[j] = count
            assert table.missing(counts) == missing << j


@pytest.mark.parametrize("bits", [16, 32])
def test_the_difference_of_any_two_counts_is_told_from_its_limits(bits):
    """A difference has one bit more than a count."""
    table = Table(bits, 1, relative=True)
    for zero, count in ((table.lowest, table.highest), (table.highest, table.lowest)):
        table.zero = [zero]
        assert table.missing([count]) == 1


@pytest.mark.parametrize("bits", [16, 32])
def test_values_outside_their_ranges_are_told_one_by_one(bits):
    kind = (ctypes.c_int16 if bits == 16 else ctypes.c_int32) * 16
    minimum, maximum = [j - 20 for j in range(16)], [j + 20 for j in range(16)]
    outside = getattr(library(), f"outside{bits}")
    for j in range(16):
        for value, mask in (
            (minimum[j], 0), (minimum[j] - 1, 1 << j), (maximum[j], 0), (maximum[j] + 1, 1 << j)
        ):  # fmt: skip
            values = [0] * 16
            values[j] = value
            assert outside(kind(*minimum), kind(*maximum), kind(*values), 16) == mask
            assert outside(kind(*minimum), kind(*maximum), kind(*values), j) == 0
