"""The tables of length sensors as pydantic models: [sensors] with the paper's sets, [[sensor]].

As in `ccgen.joint.tables`, bounds stand beside the words that tell them; what concerns several
keys at once is checked in `ccgen.joint.sensors`, `ccgen.joint.listed` and their helpers.
"""

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from ccgen.joint.table import Metres, OneOrEach, PairOrEach, Table, far_from_zero

MOST_SENSORS_OF_AXIS = 8
"""Sensors of one of the paper's sets."""
MOST_SENSORS = 16
"""Sensors of a joint: a mask of 16 bits holds them."""

_Bits = Annotated[int, Field(ge=2, le=32)]
Step = Annotated[float, Field(ge=-1.0, le=1.0), far_from_zero(1e-12, or_zero=False)]
_Noise = Annotated[float, Field(ge=0.0, le=1e3), far_from_zero(1e-12)]
_Count = Annotated[int, Field(ge=-(2**31), le=2**32)]
_Pair = Annotated[list[_Count], Field(min_length=2, max_length=2)]
_Tolerance = Annotated[float, Field(ge=0.0, le=1.0), far_from_zero(1e-9)]
_Border = Annotated[float, Field(ge=0.0, le=1e3)]
_Borders = Annotated[list[_Border], Field(min_length=2, max_length=2)]
_Segments = Annotated[list[int], Field(min_length=2, max_length=2)]


class _Said(NamedTuple):
    """What messages say of a key that stands in more than one table."""

    text: str
    examples: list[Any]


_BITS = _Said(
    "the width of a count, from 2 to 16 bits (32 with precision = 32)",
    [16],
)
_SIGNED = _Said(
    "true, or false where counts run from 0",
    [False],
)
_STEP = _Said(
    "the length of one count in metres, from 1e-12 to 1, negative where the count "
    "falls as the sensor lengthens",
    [2.0e-6],
)
_NOISE = _Said(
    "one standard deviation of the length in metres, 0 or from 1e-12 to 1000",
    [2.0e-5],
)
_ZERO = _Said("the count of the straight joint", [2048])
_RANGE = _Said(
    "the lowest and the highest count",
    [[-20000, 20000]],
)
_TOLERANCE = _Said(
    "one standard deviation of the gain as a share of it, 0 or from 1e-9 to 1",
    [0.02],
)
_RADIUS = _Said(
    "the tendons' distance from the neutral axis in metres, from 1e-6 to 1000",
    [0.05],
)


class TransducerTable(Table):
    """[sensors.transducer]; every key may instead stand in the table of one axis or sensor."""

    bits: OneOrEach[_Bits] | None = Field(
        default=None, description=_BITS.text, examples=_BITS.examples
    )
    signed: OneOrEach[bool] | None = Field(
        default=None, description=_SIGNED.text, examples=_SIGNED.examples
    )
    metres_per_count: OneOrEach[Step] | None = Field(
        default=None, description=_STEP.text, examples=_STEP.examples
    )
    noise: OneOrEach[_Noise] | None = Field(
        default=None, description=_NOISE.text, examples=_NOISE.examples
    )
    zero: OneOrEach[_Count] | None = Field(
        default=None, description=_ZERO.text, examples=_ZERO.examples
    )
    range: PairOrEach[_Pair] | None = Field(
        default=None, description=_RANGE.text, examples=_RANGE.examples
    )
    gain_tolerance: OneOrEach[_Tolerance] | None = Field(
        default=None, description=_TOLERANCE.text, examples=_TOLERANCE.examples
    )


class AxisTable(Table):
    """[sensors.u] or [sensors.v]: the keys that differ on that axis."""

    placement: Literal["single", "end-to-end", "heuristic"] | None = Field(
        default=None,
        description='"single", "end-to-end" or "heuristic", or list the spans instead',
        examples=["heuristic"],
    )
    spans: list[_Segments] | None = Field(
        default=None,
        min_length=1,
        max_length=MOST_SENSORS_OF_AXIS,
        description=f"1 to {MOST_SENSORS_OF_AXIS} spans [first, last] of segments counted from 0",
        examples=[[[0, 4], [3, 8], [7, 11]]],
    )
    spans_m: list[_Borders] | None = Field(
        default=None,
        min_length=1,
        max_length=MOST_SENSORS_OF_AXIS,
        description=f"1 to {MOST_SENSORS_OF_AXIS} spans [from, to] in metres along the joint",
        examples=[[[0.0, 0.1], [0.06, 0.24]]],
    )
    count: int | None = Field(
        default=None,
        ge=1,
        le=MOST_SENSORS_OF_AXIS,
        description=f"the number of sensors of an axis, from 1 to {MOST_SENSORS_OF_AXIS}",
        examples=[3],
    )
    radius: OneOrEach[Metres] | None = Field(
        default=None, description=_RADIUS.text, examples=_RADIUS.examples
    )
    transducer: TransducerTable = Field(
        default=TransducerTable(),
        description="a table of its own",
        examples=["[sensors.transducer]"],
    )


class SensorsTable(AxisTable):
    """[sensors]: for both axes, with what differs on one of them in `u` and `v`."""

    u: AxisTable = Field(
        default=AxisTable(), description="a table of its own", examples=["[sensors.u]"]
    )
    v: AxisTable = Field(
        default=AxisTable(), description="a table of its own", examples=["[sensors.v]"]
    )


class SensorTable(Table):
    """One of [[sensor]]: a sensor anywhere around the joint."""

    name: str = Field(description="a C identifier of at most 20 characters", examples=["near_left"])
    span: _Segments | None = Field(
        default=None,
        description="the first and the last segment, counted from 0",
        examples=[[0, 5]],
    )
    span_m: _Borders | None = Field(
        default=None,
        description="where the span begins and ends along the joint, in metres",
        examples=[[0.0, 0.12]],
    )
    angle: float = Field(
        ge=-360.0,
        le=360.0,
        description="degrees around the neutral axis from +x, counter-clockwise seen from the tip, "
        "from -360 to 360",
        examples=[180.0],
    )
    radius: Metres = Field(description=_RADIUS.text, examples=_RADIUS.examples)
    bits: _Bits | None = Field(default=None, description=_BITS.text, examples=_BITS.examples)
    signed: bool | None = Field(default=None, description=_SIGNED.text, examples=_SIGNED.examples)
    metres_per_count: Step | None = Field(
        default=None, description=_STEP.text, examples=_STEP.examples
    )
    noise: _Noise | None = Field(default=None, description=_NOISE.text, examples=_NOISE.examples)
    zero: _Count | None = Field(default=None, description=_ZERO.text, examples=_ZERO.examples)
    range: _Pair | None = Field(default=None, description=_RANGE.text, examples=_RANGE.examples)
    gain_tolerance: _Tolerance | None = Field(
        default=None, description=_TOLERANCE.text, examples=_TOLERANCE.examples
    )
