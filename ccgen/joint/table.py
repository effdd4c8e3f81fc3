"""What all tables of a user's file have in common."""

from typing import Annotated, TypeVar

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

T = TypeVar("T")

ONE, EACH = "<one>", "<each>"
"""Steps of pydantic's locations that are no keys of the file."""


class Table(BaseModel):
    """A table whose keys are all known and whose values are not converted."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


Metres = Annotated[float, Field(ge=1e-6, le=1e3)]


def _which(value: object) -> str:
    """Tell a list of values from one value."""
    return EACH if isinstance(value, list) else ONE


OneOrEach = Annotated[
    Annotated[T, Tag(ONE)] | Annotated[list[T], Tag(EACH), Field(min_length=1, max_length=16)],
    Discriminator(_which),
]
"""One value for all sensors, or a list with one for each."""


def _which_pair(value: object) -> str:
    return EACH if isinstance(value, list) and any(isinstance(x, list) for x in value) else ONE


PairOrEach = Annotated[
    Annotated[T, Tag(ONE)] | Annotated[list[T], Tag(EACH), Field(min_length=1, max_length=16)],
    Discriminator(_which_pair),
]
"""One pair for all sensors, or a list with one for each."""
