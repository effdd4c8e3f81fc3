"""The tables of a joint file as pydantic models: types, bounds and defaults of every key.

A field's `description` completes "write ..." in messages and its first example is what such a
message shows, so both stand beside the bounds they explain. What concerns several keys at once is
checked in `ccgen.joint.file` and in the modules that it calls, such as `ccgen.joint.geometry`.
"""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from ccgen.joint.load_tables import LoadsTable
from ccgen.joint.sensor_tables import MOST_SENSORS, SensorsTable, SensorTable
from ccgen.joint.table import Metres, Table, far_from_zero

MOST_SEGMENTS = 64
MOST_RECORDINGS = 100

LEAST_RANGE = 1e-6
"""Degrees of a segment: a joint that bends less is straight, and its shapes differ by rounding."""

Samples = Annotated[int, Field(ge=1, le=1000)]
Share = Annotated[float, Field(ge=-0.5, le=2.0)]
"""Elongation, share of the length."""


class GeometryTable(Table):
    """[geometry]."""

    segments: int = Field(
        ge=1,
        le=MOST_SEGMENTS,
        description=f"a whole number from 1 to {MOST_SEGMENTS}",
        examples=[12],
    )
    length: Metres = Field(
        description="the joint's length in metres, from 1e-6 to 1000", examples=[0.24]
    )
    range_of_motion: Annotated[float, Field(ge=LEAST_RANGE, le=90.0)] | None = Field(
        default=None,
        description=f"degrees per segment and axis, from {LEAST_RANGE:g} to 90",
        examples=[3.0],
    )
    total_range_of_motion: (
        Annotated[float, Field(ge=LEAST_RANGE, le=90.0 * MOST_SEGMENTS)] | None
    ) = Field(
        default=None,
        description=f"degrees of the whole joint and axis, from {LEAST_RANGE:g} to 90 a segment",
        examples=[36.0],
    )
    sections: list[Annotated[int, Field(ge=1)]] | None = Field(
        default=None,
        min_length=1,
        max_length=MOST_SEGMENTS,
        description="the segments of each part that elongates by itself",
        examples=[[6, 6]],
    )
    elongation: list[Share] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="the lowest and the highest share of the length, from -0.5 to 2",
        examples=[[0.0, 0.05]],
    )


Weight = Annotated[float, Field(ge=0.0, le=1e6), far_from_zero(1e-6)] | None


_WEIGHT = "a number, 0 or from 1e-6 to 1e6"


class WeightTable(Table):
    """`weight` of [shapes]: how much each source counts as a whole."""

    cases: Weight = Field(default=None, description=_WEIGHT, examples=[0.0])
    loads: Weight = Field(default=None, description=_WEIGHT, examples=[0.05])
    recordings: Weight = Field(default=None, description=_WEIGHT, examples=[1.0])


class ShapesTable(Table):
    """[shapes]."""

    cases: list[Literal["end-force", "uniform", "s-shape", "constant-curvature"]] = Field(
        default=["end-force", "uniform", "s-shape", "constant-curvature"],
        description='of "end-force", "uniform", "s-shape", "constant-curvature"',
        examples=[["end-force", "uniform"]],
    )
    # Equation 6 defines i = 1 ... s for any s >= 1; a thousand is a thousandth of the range.
    fit_samples: Samples = Field(
        default=30, description="amplitudes per load case, from 1 to 1000", examples=[30]
    )
    score_samples: Samples = Field(
        default=10, description="amplitudes per load case, from 1 to 1000", examples=[10]
    )
    weight: WeightTable = Field(
        default=WeightTable(),
        description="a weight for each source of shapes, which counts as a whole",
        examples=[{"cases": 0.0, "loads": 0.05, "recordings": 1.0}],
    )


Interval = Annotated[list[float], Field(min_length=2, max_length=2)]


class RecordingTable(Table):
    """One of [[recordings]]."""

    file: str = Field(
        min_length=1,
        description="the path of a CSV file, relative to the joint file",
        examples=["run1.csv"],
    )
    counts: str | None = Field(
        default=None,
        min_length=1,
        description="the path of a CSV file or CAN log that holds the counts, where file does not",
        examples=["run1.blf"],
    )
    dbc: str | None = Field(
        default=None,
        min_length=1,
        description="the path of the DBC file that describes the CAN log",
        examples=["finger.dbc"],
    )
    use: Literal["fit", "score"] = Field(
        default="fit", description='"fit" or "score"', examples=["fit"]
    )
    stations: dict[str, Annotated[float, Field(ge=0.0, le=1e3)]] = Field(
        default={},
        description="metres from the base along the neutral axis, for each body or marker",
        examples=[{"mid": 0.12, "tip": 0.24}],
    )
    straight: Interval | None = Field(
        default=None,
        description="the seconds from which to which the joint was straight",
        examples=[[0.0, 2.0]],
    )
    zero_from: Interval | None = Field(
        default=None,
        description="the seconds from which to which the reference sets the sensors' zeros",
        examples=[[0.0, 1.0]],
    )
    base: list[str] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="two markers, whose chord is the base frame",
        examples=[["m0", "m1"]],
    )
    position_noise: float | None = Field(
        default=None,
        ge=1e-9,
        le=1.0,
        description="one standard deviation of a coordinate in metres, from 1e-9 to 1",
        examples=[2.0e-4],
    )
    orientation_noise: float | None = Field(
        default=None,
        ge=1e-9,
        le=90.0,
        description="one standard deviation about an axis in degrees, from 1e-9 to 90",
        examples=[0.5],
    )
    delay: float | None = Field(
        default=None,
        description='seconds by which the sensors lag, or "estimate"',
        examples=[0.05],
    )
    rows: list[Annotated[int, Field(ge=0)]] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="the first and the last row to use, counted from 0 behind the header",
        examples=[[0, 999]],
    )

    @field_validator("delay", mode="before")
    @classmethod
    def _estimated(cls, value: object) -> object:
        return None if value == "estimate" else value


class EstimatorTable(Table):
    """[estimator]."""

    method: Literal["direct", "equal", "wam", "noise-aware"] = Field(
        default="wam",
        description='"direct", "equal", "wam" or "noise-aware"',
        examples=["wam"],
    )
    axes: list[Literal["u", "v", "h"]] | None = Field(
        default=None,
        min_length=1,
        max_length=3,
        description='one or more of "u", "v", "h"',
        examples=[["u", "v"]],
    )
    fallback: bool = Field(default=True, description="true or false", examples=[True])
    check: bool = Field(default=True, description="true or false", examples=[True])
    false_alarms: float = Field(
        default=1e-6,
        ge=1e-9,
        le=0.1,
        description="a share of the snapshots, from 1e-9 to 0.1",
        examples=[1e-6],
    )


class FixedPointTable(Table):
    """[fixed_point]."""

    precision: int = Field(
        default=16, ge=16, le=32, multiple_of=16, description="16 or 32", examples=[16]
    )


class KinematicsTable(Table):
    """[kinematics]."""

    float: bool = Field(default=True, description="true or false", examples=[False])


class CanTable(Table):
    """[can]."""

    base_id: int = Field(
        default=0x300,
        ge=0,
        le=0x1FFFFFFF,
        description="an identifier of 11 bits, or of 29 with extended = true",
        examples=[0x300],
    )
    extended: bool = Field(default=False, description="true or false", examples=[False])
    fd: bool = Field(default=False, description="true or false", examples=[False])
    bitrate: int = Field(
        default=1_000_000,
        ge=10_000,
        le=1_000_000,
        description="bits per second of the arbitration, from 10_000 to 1_000_000",
        examples=[1_000_000],
    )
    cycle_ms: int = Field(
        default=10, ge=1, le=1000, description="milliseconds, from 1 to 1000", examples=[10]
    )
    turn: bool = Field(default=True, description="true or false", examples=[True])
    publish: list[Literal["angles", "tip", "status", "health"]] = Field(
        default=["angles", "tip", "status", "health"],
        max_length=4,
        description='a list of "angles", "tip", "status", "health"',
        examples=[["angles", "status"]],
    )
    rate_switch: bool = Field(default=False, description="true or false", examples=[False])
    commands: bool = Field(default=False, description="true or false", examples=[False])


class JointTable(Table):
    """The whole file."""

    name: str = Field(description="a C identifier of at most 20 characters", examples=["shoulder"])
    calibration: str | None = Field(
        default=None,
        min_length=1,
        description="the path of a calibration file, relative to the joint file",
        examples=["shoulder.calibration.toml"],
    )
    geometry: GeometryTable = Field(
        description="a table with segments, length and range_of_motion", examples=["[geometry]"]
    )
    sensors: SensorsTable = Field(
        default=SensorsTable(), description="a table with radius and more", examples=["[sensors]"]
    )
    sensor: list[SensorTable] = Field(
        default=[],
        max_length=MOST_SENSORS,
        description=f"at most {MOST_SENSORS} tables",
        examples=["[[sensor]]"],
    )
    shapes: ShapesTable = Field(default=ShapesTable(), description="a table", examples=["[shapes]"])
    loads: LoadsTable = Field(default=LoadsTable(), description="a table", examples=["[loads]"])
    recordings: list[RecordingTable] = Field(
        default=[],
        max_length=MOST_RECORDINGS,
        description=f"at most {MOST_RECORDINGS} tables",
        examples=["[[recordings]]"],
    )
    estimator: EstimatorTable = Field(
        default=EstimatorTable(), description="a table", examples=["[estimator]"]
    )
    fixed_point: FixedPointTable = Field(
        default=FixedPointTable(), description="a table", examples=["[fixed_point]"]
    )
    kinematics: KinematicsTable = Field(
        default=KinematicsTable(), description="a table", examples=["[kinematics]"]
    )
    can: CanTable = Field(default=CanTable(), description="a table", examples=["[can]"])
