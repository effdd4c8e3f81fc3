"""What all tables of a user's file have in common."""

from typing import Annotated, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

T = TypeVar("T")

ONE, EACH = "<one>", "<each>"
"""Steps of pydantic's locations that are no keys of the file."""


class Table(BaseModel):
    """A table whose keys are all known and whose values are not converted."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


Metres = Annotated[float, Field(ge=1e-6, le=1e3)]


NEAR_ZERO = "near_zero"
"""What pydantic calls a number that `far_from_zero` refuses."""


def far_from_zero(least: float, or_zero: bool = True) -> AfterValidator:
    """Refuse numbers so near to 0 that squares and quotients of them leave a double's range.

    Args:
        least: smallest size of a number.
        or_zero: whether 0 itself may stand there.
    """

    def check(value: float) -> float:
        if abs(value) < least and not (or_zero and value == 0.0):
            raise PydanticCustomError(NEAR_ZERO, "is too near to 0")
        return value

    return AfterValidator(check)


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
