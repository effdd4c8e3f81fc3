"""The lists that hold a joint's counts in its C: one for each of the paper's sets, or one alone."""

from dataclasses import dataclass

from ccgen.can.layout import FrameLayout, has_own_sets
from ccgen.joint import AXES, Joint


@dataclass(frozen=True)
class Field:
    """One list of `NAME_counts_t`.

    Attributes:
        field: its name in C.
        macro: ending of the constant that tells its length.
        tables: beginning of the names of its tables.
        first: number of its first sensor.
        sensors: how many there are.
        bit: of the first sensor in a mask of missing sensors.
    """

    field: str
    macro: str
    tables: str
    first: int
    sensors: int
    bit: int

    @property
    def part(self) -> slice:
        """The part of the joint's list of sensors."""
        return slice(self.first, self.first + self.sensors)


def fields_of(joint: Joint, layout: FrameLayout) -> list[Field]:
    """The lists of counts, in the order of the joint's sensors."""
    if not has_own_sets(joint):
        return [Field("sensor", "SENSORS", "all", 0, len(joint.sensors), 0)]
    found = []
    for axis in AXES:
        if axis in joint.axes:
            own = joint.own(axis)
            bit = layout.missing_bits[own.start]
            macro = f"SENSORS_{axis.upper()}"
            found.append(Field(axis, macro, axis, own.start, own.stop - own.start, bit))
    return found
