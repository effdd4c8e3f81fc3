"""What turns each sensor's length into counts: the keys of a transducer, checked together."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ccgen.joint.messages import KeyProblemError, missing_key
from ccgen.joint.sensor_tables import TransducerTable
from ccgen.joint.specification import Transducer, count_limits

DEFAULT_BITS = 16


@dataclass(frozen=True)
class Stated:
    """The value of one key for one sensor, and where it stands; None where nothing states it."""

    value: Any
    place: str


Lookup = Callable[[str], Stated]
"""Answers for every key of the transducer table."""


def transducer(stated: Lookup, precision: int) -> Transducer:
    """Return the transducer of one sensor.

    Args:
        stated: what the file says of it.
        precision: bits of counts in the firmware, 16 or 32.

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    signed = stated("signed").value is not False
    bits = _bits(stated, signed, precision)
    metres_per_count = stated("metres_per_count").value
    if metres_per_count is None:
        raise KeyProblemError(
            missing_key(
                "sensors.transducer.metres_per_count",
                TransducerTable.model_fields["metres_per_count"],
            )
        )
    zero, limits = stated("zero"), stated("range")
    low, high = count_limits(bits, signed)
    if zero.value is not None and not low <= zero.value <= high:
        raise KeyProblemError(
            f"{zero.place}: {zero.value} is no count of {_counter(bits, signed)}; "
            f"write a count from {low} to {high}"
        )
    if limits.value is not None:
        _check_range(limits, bits, signed, zero.value)
    return Transducer(
        bits=bits,
        signed=signed,
        metres_per_count=metres_per_count,
        noise=stated("noise").value,
        zero=zero.value,
        range=None if limits.value is None else (limits.value[0], limits.value[1]),
        gain_tolerance=stated("gain_tolerance").value or 0.0,
    )


def _bits(stated: Lookup, signed: bool, precision: int) -> int:
    bits = stated("bits")
    width = DEFAULT_BITS if bits.value is None else bits.value
    most = precision if signed else precision - 1
    if width > most:
        place, advice = bits.place, f"at most {most}"
        if bits.value is None:
            place, advice = stated("signed").place, f"bits = {most} or fewer"
        raise KeyProblemError(
            f"{place}: {_counter(width, signed)} do not fit precision = {precision}; "
            f"write {advice}" + (", or precision = 32" if precision == 16 else "")
        )
    return int(width)


def _counter(bits: int, signed: bool) -> str:
    return f"{bits} bits" if signed else f"{bits} bits without sign"


def _check_range(limits: Stated, bits: int, signed: bool, zero: int | None) -> None:
    low, high = limits.value
    lowest, highest = count_limits(bits, signed)
    said = f"{limits.place}: range [{low}, {high}]"
    if low > high:
        raise KeyProblemError(f"{said} is reversed; write [{high}, {low}]")
    if low == high:
        raise KeyProblemError(
            f"{said} holds one count only; write the lowest and the highest count"
        )
    if low < lowest or high > highest:
        no_reading = ", whose lowest count means no reading" if signed else ""
        raise KeyProblemError(
            f"{said} exceeds {_counter(bits, signed)}{no_reading}; "
            f"write counts from {lowest} to {highest}"
        )
    if zero is not None and not low <= zero <= high:
        raise KeyProblemError(
            f"{said} leaves out {zero}, the zero; "
            f"write a lowest count of {zero} or less and a highest of {zero} or more"
        )
    if zero is None and signed and not low <= 0 <= high:
        raise KeyProblemError(
            f"{said} leaves out 0, the count of the straight joint; "
            "write a lowest count of 0 or less and a highest of 0 or more, or state the zero"
        )
