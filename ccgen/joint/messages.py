"""From what pydantic found to one line that names the key, what is wrong and what is right."""

import datetime
import difflib
import json
import math
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel, ValidationError

from ccgen.joint.table import EACH, NEAR_ZERO, ONE

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo
    from pydantic_core import ErrorDetails

_LONGEST_VALUE = 40
_Location = tuple[int | str, ...]


class KeyProblemError(Exception):
    """What is wrong at a key: "KEY: what is wrong; what would be right"."""


def first_problem(error: ValidationError, root: type[BaseModel]) -> str:
    """Return "KEY: what is wrong; what would be right" for the first problem.

    An unknown key comes first: where one is misspelt, that it is missing is no news.

    Args:
        error: what pydantic found.
        root: the table of the whole file.
    """
    problems = error.errors(include_url=False)
    unknown = [problem for problem in problems if problem["type"] == "extra_forbidden"]
    problem = (unknown or problems)[0]
    if problem["type"] == "extra_forbidden":
        return _unknown_key(problem["loc"], root)
    field = _field(problem["loc"], root)
    if problem["type"] == "missing":
        return missing_key(dotted(problem["loc"]), field)
    return _wrong_value(problem, field)


def dotted(location: _Location) -> str:
    """Return a key as the user would say it: `sensors.spans[1]`; choices of types are no keys."""
    path = ""
    for part in location:
        if part in (ONE, EACH):
            continue
        path += f"[{part}]" if isinstance(part, int) else f".{_printable(part)}"
    return path.removeprefix(".")


def missing_key(key: str, field: "FieldInfo") -> str:
    """Return the message for a key that must be there and is not."""
    return f"{key}: missing; write {_example(key, field)} ({field.description})"


def toml_value(value: object) -> str:
    """Return a value as it may stand in the file, on one line; nothing for tables with keys."""
    if isinstance(value, dict) or (isinstance(value, list) and _hold_keys(value)):
        return ""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    text = json.dumps(value, default=str)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 4] + " ..."


def _hold_keys(values: list[Any]) -> bool:
    return any(isinstance(value, dict) and value for value in values)


def _wrong_value(problem: "ErrorDetails", field: "FieldInfo") -> str:
    key = dotted(problem["loc"])
    value = toml_value(problem["input"])
    if problem["type"] == "literal_error":
        known = re.findall(r"'([^']+)'", problem["ctx"]["expected"])
        near = difflib.get_close_matches(str(problem["input"]), known, n=1)
        if near:
            return f'{key}: {value} is unknown; did you mean "{near[0]}"?'
    what = f"{value} {_complaint(problem['type'], problem['input'])}".strip()
    return f"{key}: {what}; write {field.description}, such as {_example(key, field)}"


def _complaint(kind: str, value: Any) -> str:
    if kind in ("literal_error", "multiple_of"):
        return "is unknown" if isinstance(value, str | int) else f"is {_type_name(value)}"
    if kind == "finite_number":
        return "is not finite"
    if kind in ("too_short", "too_long"):
        items = len(value)
        return f"has {items} item{'' if items == 1 else 's'}"
    if kind == NEAR_ZERO:
        return "is too near to 0"
    if kind.startswith("greater_than"):
        return "is too small"
    if kind.startswith("less_than") or _overflows(kind, value):
        return "is too large"
    return f"is {_type_name(value)}"


def _overflows(kind: str, value: Any) -> bool:
    """Return whether an integer stands where a float may, beyond what a float holds."""
    return kind == "float_type" and isinstance(value, int) and not isinstance(value, bool)


def _type_name(value: object) -> str:
    names: list[tuple[type, str]] = [
        (bool, "a boolean"),
        (int, "an integer"),
        (float, "a decimal number"),
        (str, "a string"),
        (list, "a list"),
        (dict, "a table"),
    ]
    return next((name for kind, name in names if isinstance(value, kind)), "a date or time")


def _unknown_key(location: _Location, root: type[BaseModel]) -> str:
    key, name = dotted(location), str(location[-1])
    here = _table(location[:-1], root)
    near = difflib.get_close_matches(name, here.model_fields, n=1)
    if near:
        return f"{key}: unknown key; did you mean {near[0]}?"
    homes = [home for home, table in _tables(root) if name in table.model_fields]
    if homes:
        return f"{key}: unknown key here; write it in {homes[0]}"
    return f"{key}: unknown key; the known ones are {', '.join(here.model_fields)}"


def _tables(model: type[BaseModel], above: str = "") -> Iterator[tuple[str, type[BaseModel]]]:
    """Yield every table below `model` under the header that it has in the file."""
    for name, field in model.model_fields.items():
        inner = _inner(field)
        if inner is not None:
            path = f"{above}{name}"
            yield (f"[{path}]" if inner is field.annotation else f"[[{path}]]"), inner
            yield from _tables(inner, f"{path}.")


def _inner(field: "FieldInfo") -> type[BaseModel] | None:
    """Return the table that a field holds, or holds a list of."""
    for kind in (field.annotation, *get_args(field.annotation)):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return kind
    return None


def _table(location: _Location, root: type[BaseModel]) -> type[BaseModel]:
    """Return the innermost table on the way to `location`."""
    here = root
    for part in location:
        field = here.model_fields.get(str(part))
        here = (_inner(field) if field is not None else None) or here
    return here


def _field(location: _Location, root: type[BaseModel]) -> "FieldInfo":
    """Return the field of the innermost key on the way to `location`."""
    here = root
    field = here.model_fields[str(location[0])]
    for part in location[1:]:
        here = _inner(field) or here
        field = here.model_fields.get(str(part), field)
    return field


def _example(key: str, field: "FieldInfo") -> str:
    value: Any = (field.examples or [""])[0]
    if isinstance(value, str) and value.startswith("["):
        return value
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {toml_value(x)}" for name, x in value.items()) + " }"
    return f"{key.rpartition('.')[2].partition('[')[0]} = {toml_value(value)}"


def _printable(key: str) -> str:
    """Return a key as it is where it is a bare TOML key, else quoted on one line."""
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else json.dumps(key)
