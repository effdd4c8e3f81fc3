"""From the bytes of a user's TOML file to its keys and values."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ccgen.errors import InputError

_LARGEST_FILE = 1_000_000


@dataclass(frozen=True)
class Kind:
    """What a file is, for messages."""

    name: str
    """As in "joint file"."""
    hint: str
    """How to come by one that works."""
    line: str
    """One that may stand in it."""


def read(path: Path, kind: Kind) -> str:
    """Return the text of a file.

    Raises:
        InputError: in one line the file, what is wrong, what would be right.
    """
    return decoded(read_bytes(path, kind), str(path))


def read_bytes(path: Path, kind: Kind) -> bytes:
    """Return the bytes of a file, which may be a pipe: it is read once.

    Raises:
        InputError: as `read`.
    """
    try:
        with path.open("rb") as file:
            data = file.read(_LARGEST_FILE + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; {kind.hint}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a directory; name a {kind.name} in it") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > _LARGEST_FILE:
        raise InputError(f"{path}: more than {_LARGEST_FILE} bytes are no {kind.name}; {kind.hint}")
    return data


def parse(text: str, source: str, kind: Kind) -> dict[str, Any]:
    """Return the keys and values of a file that is not empty.

    Args:
        text: what the file holds.
        source: names it in messages.
        kind: of the file.

    Raises:
        InputError: as `read`, with the line.
    """
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{source}: is nested too deeply; {kind.hint}") from None
    except ValueError as error:
        raise InputError(f"{source}: {_syntax_problem(str(error), text, kind.line)}") from None
    if not document:
        raise InputError(f"{source}: is empty; {kind.hint}")
    return document


def document(data: bytes) -> dict[str, Any]:
    """Return the keys and values of a file that has been checked."""
    return tomllib.loads(data.decode("utf-8-sig", "surrogateescape"))


def decoded(data: bytes, source: str) -> str:
    """Return the text that the bytes of a file are.

    Raises:
        InputError: as `read`, with the line.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{source}: line {line}: byte 0x{data[error.start]:02x} is not UTF-8; "
            "save the file as UTF-8 text"
        ) from None


def _syntax_problem(message: str, text: str, line: str) -> str:
    """Return the line and what tomllib says of it; it names no line at the end of the file."""
    what, _, where = message.removesuffix(")").rpartition(" (at ")
    found = re.fullmatch(r"line (\d+), column (\d+)", where)
    if found:
        place = f"line {found[1]}, column {found[2]}"
    else:
        place = f"line {len(text.rstrip().splitlines())} (the last)"
    what = what or message.partition(";")[0]
    return f"{place}: {what[0].lower()}{what[1:]}; write TOML, such as {line}"
