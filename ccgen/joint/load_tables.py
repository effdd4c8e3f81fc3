"""Tables of loads as pydantic models: [loads] of a joint file, and a file of stated loads.

As in `ccgen.joint.tables`, bounds stand beside the words that tell them; what concerns several
keys at once is checked in `ccgen.joint.load_files`.
"""

from typing import Annotated

from pydantic import Field, field_validator

from ccgen.joint.table import Table, far_from_zero

MOST_PARTS = 10_000
MOST_CONTACTS = 64

_Stiffness = Annotated[float, Field(ge=1e-12, le=1e12)]
_Part = Annotated[float, Field(ge=1e-6, le=1e6)]
_Load = Annotated[float, Field(ge=-1e6, le=1e6)]
_Share = Annotated[float, Field(ge=-0.5, le=2.0)]
_Whole = Annotated[float, Field(ge=-5760.0, le=5760.0)]
"""Degrees of the whole joint: 90 for each of 64 segments."""
_Size = Annotated[float, Field(ge=0.0, le=1e6)]

_SizeRange = Annotated[list[_Size], Field(min_length=2, max_length=2)]
_Plane = Annotated[list[_Load], Field(min_length=2, max_length=2)]
_Space = Annotated[list[_Load], Field(min_length=3, max_length=3)]


class StiffnessTable(Table):
    """What a joint resists with."""

    stiffness: _Stiffness | None = Field(
        default=None,
        description="the bending stiffness in N m^2, from 1e-12 to 1e12",
        examples=[0.4],
    )
    stiffness_profile: list[_Part] = Field(
        default=[1.0],
        min_length=1,
        max_length=MOST_PARTS,
        description="the relative stiffness of equal parts from the base, from 1e-6 to 1e6 each",
        examples=[[2.0, 1.0, 1.0, 2.5]],
    )


class LoadsTable(StiffnessTable):
    """[loads]: ranges, lowest value first."""

    samples: int = Field(
        default=300,
        ge=1,
        le=10_000,
        description="how many shapes to draw, from 1 to 10000",
        examples=[300],
    )
    stiffness_tolerance: Annotated[float, far_from_zero(1e-9)] = Field(
        default=0.0,
        ge=0.0,
        le=1.0,
        description="the share by which each part's stiffness varies, 0 or from 1e-9 to 1",
        examples=[0.1],
    )
    actuation: Annotated[list[_Whole], Field(min_length=2, max_length=2)] = Field(
        default=[0.0, 0.0],
        description="the least and the most degrees by which actuators alone bend the whole joint",
        examples=[[-90.0, 90.0]],
    )
    mass: _Size = Field(
        default=0.0, description="the joint's mass in kg, 0 or more", examples=[0.4]
    )
    mounting: Annotated[float, Field(ge=0.0, le=180.0)] | None = Field(
        default=None,
        description='"any", or the degrees between gravity and the unbent axis, from 0 to 180',
        examples=["any"],
    )
    payload: _SizeRange = Field(
        default=[0.0, 0.0],
        description="the least and the most mass at the tip in kg, 0 or more",
        examples=[[0.0, 0.25]],
    )
    tip_force: _SizeRange = Field(
        default=[0.0, 0.0],
        description="the least and the most force across the tip in N, 0 or more",
        examples=[[0.0, 6.0]],
    )
    tip_moment: _SizeRange = Field(
        default=[0.0, 0.0],
        description="the least and the most moment at the tip in N m, 0 or more",
        examples=[[0.0, 0.2]],
    )
    contact: _SizeRange = Field(
        default=[0.0, 0.0],
        description="the least and the most force of a contact in N, 0 or more",
        examples=[[0.0, 6.0]],
    )
    contact_from: float = Field(
        default=0.0,
        ge=0.0,
        le=1e3,
        description="metres from the base beyond which the joint is touched, 0 or more",
        examples=[0.05],
    )
    elongation: Annotated[
        list[Annotated[_Share, far_from_zero(1e-6)]], Field(min_length=2, max_length=2)
    ] = Field(
        default=[0.0, 0.0],
        description="the least and the most elongation as a share of the length, from -0.5 to 2, "
        "each 0 or at least 1e-6 away from it",
        examples=[[0.0, 0.03]],
    )

    @field_validator("mounting", mode="before")
    @classmethod
    def _any(cls, value: object) -> object:
        return None if value == "any" else value


class ContactTable(Table):
    """One of the contacts of a file of loads."""

    at: float = Field(
        ge=0.0, le=1e3, description="metres along the joint from the base", examples=[0.1]
    )
    force: _Space = Field(
        description="the force in N along x, y and z of the base", examples=[[2.0, 0.0, 0.0]]
    )


class StatedLoadsTable(StiffnessTable):
    """A file of loads under which a joint has one shape."""

    actuation_u: _Whole = Field(
        default=0.0,
        description="degrees by which actuators alone bend the whole joint in u",
        examples=[20.0],
    )
    actuation_v: _Whole = Field(
        default=0.0,
        description="degrees by which actuators alone bend the whole joint in v",
        examples=[20.0],
    )
    tip_force: _Space = Field(
        default=[0.0, 0.0, 0.0],
        description="the force at the tip in N along x, y and z of the base",
        examples=[[1.0, 0.0, 0.0]],
    )
    tip_moment: _Plane = Field(
        default=[0.0, 0.0],
        description="the moment at the tip in N m about x and y",
        examples=[[0.0, 0.1]],
    )
    distributed: _Space = Field(
        default=[0.0, 0.0, 0.0],
        description="the force along the joint in N/m along x, y and z of the base",
        examples=[[0.0, 0.0, -4.0]],
    )
    contacts: list[ContactTable] = Field(
        default=[],
        max_length=MOST_CONTACTS,
        description=f"at most {MOST_CONTACTS} tables with at and force",
        examples=["[[contacts]]"],
    )
    elongation: list[_Share] = Field(
        default=[],
        description="the elongation of each section, share of its length, from -0.5 to 2",
        examples=[[0.02]],
    )

    @field_validator("elongation", mode="before")
    @classmethod
    def _of_one_section(cls, value: object) -> object:
        return [value] if isinstance(value, int | float) else value
