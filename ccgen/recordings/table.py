"""A table of numbers from a CSV file, gzip too: a header, a row a sample, an empty cell no value.

The whole file is read before anything is made of it, and everything that is wrong with it is one
line that names the file, the line and the column.
"""

import csv
import gzip
import hashlib
import io
import math
import zlib
from array import array
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError

Floats = NDArray[np.float64]

LARGEST_TEXT = 256 * 2**20
"""Most bytes of a table, unpacked: some 300,000 rows of 100 columns."""

MOST_COLUMNS = 1000

_GZIP = b"\x1f\x8b"
_SHOWN = 20  # characters of a wrong cell in a message


@dataclass(frozen=True, eq=False)
class Table:
    """What a file holds, before anyone asks what it means."""

    source: str
    """The file as the user named it: for messages."""
    sha256: str
    """Of the file's bytes as they lie on the disk, hexadecimal."""
    names: tuple[str, ...]
    """The columns' names, each once."""
    values: Floats
    """Shape (N, columns), as written; NaN where a cell is empty."""
    lines: NDArray[np.int64]
    """The line of the file that each row ends on, shape (N,), counted from 1."""

    def column(self, name: str) -> Floats:
        """Return one column, shape (N,).

        Raises:
            KeyError: no column of that name.
        """
        try:
            return self.values[:, self.names.index(name)]
        except ValueError:
            raise KeyError(name) from None

    def where(self, row: int, name: str | None = None) -> str:
        """Return how a message names a row, and a cell of it: "run.csv: line 7, column u0"."""
        column = "" if name is None else f", column {name}"
        return f"{self.source}: line {self.lines[row]}{column}"

    def rows(self, first: int, last: int) -> "Table":
        """Return rows `first` to `last`, both included, counted from 0 behind the header."""
        part = slice(first, last + 1)
        return Table(self.source, self.sha256, self.names, self.values[part], self.lines[part])


def read_table(path: Path, source: str | None = None) -> Table:
    """Read a CSV file, packed with gzip or not.

    Args:
        path: where the file is.
        source: how messages name it; as `path` unless given.

    Raises:
        InputError: the file is missing, cut off, no text, too large, ragged, or holds what is no
            number.
    """
    source = str(path) if source is None else source
    data = read_bytes(path, source)
    text = _decoded(_unpacked(data, source), source)
    names, rows = _parsed(text, source)
    return Table(
        source, hashlib.sha256(data).hexdigest(), names, rows.values(len(names)), rows.line_numbers
    )


def read_bytes(path: Path, source: str, most: int = LARGEST_TEXT) -> bytes:
    """Return the bytes of a file that a recording names.

    Args:
        path: where it is.
        source: how messages name it.
        most: bytes that it may have.

    Raises:
        InputError: it is missing, a directory, cannot be read, or is too large.
    """
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(
            f"{source}: no such file; a path in [[recordings]] is relative to the joint file"
        ) from None
    except IsADirectoryError:
        raise InputError(f"{source}: is a directory; name a file in it") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{source}: cannot be read: {reason}") from None
    if len(data) > most:
        raise InputError(_too_large(source))
    return data


def _too_large(source: str) -> str:
    return (
        f"{source}: more than {LARGEST_TEXT >> 20} MiB of text; "
        "cut it into several recordings, or keep every tenth row"
    )


def _unpacked(data: bytes, source: str) -> bytes:
    if not data.startswith(_GZIP):
        return data
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as packed:
            text = packed.read(LARGEST_TEXT + 1)
    except EOFError:
        raise InputError(f"{source}: the gzip file is cut off; copy it again, whole") from None
    except (OSError, zlib.error) as error:
        raise InputError(
            f"{source}: the gzip file is damaged ({str(error).lower()}); copy it again, whole"
        ) from None
    if len(text) > LARGEST_TEXT:
        raise InputError(_too_large(source))
    return text


def _decoded(data: bytes, source: str) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(f"{source}: is UTF-16; save it as UTF-8 text")
    nul = data.find(0)
    if nul >= 0:
        raise InputError(
            f"{source}: line {data.count(10, 0, nul) + 1}: a zero byte, this is no text; "
            "name a CSV file"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{source}: line {line}: byte 0x{data[error.start]:02x} is not UTF-8; "
            "save the file as UTF-8 text"
        ) from None


class _Rows:
    """The rows read so far: numbers in one flat buffer, and the line of each."""

    def __init__(self) -> None:
        self._numbers = array("d")
        self._lines = array("q")

    def append(self, numbers: list[float], line: int) -> None:
        self._numbers.extend(numbers)
        self._lines.append(line)

    def values(self, columns: int) -> Floats:
        return np.array(self._numbers, dtype=np.float64).reshape(-1, columns)

    @property
    def line_numbers(self) -> NDArray[np.int64]:
        return np.array(self._lines, dtype=np.int64)


def _parsed(text: str, source: str) -> tuple[tuple[str, ...], _Rows]:
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    rows = _Rows()
    names: tuple[str, ...] = ()
    try:
        for cells in reader:
            if not cells:
                continue
            if not names:
                names = _header(cells, source)
                continue
            if len(cells) != len(names):
                raise InputError(
                    f"{source}: line {reader.line_num}: {_counted(len(cells), 'cell')} under "
                    f"{_counted(len(names), 'column')}; write one cell a column, empty where there "
                    "is no value"
                )
            rows.append(
                _numbers(cells, names, f"{source}: line {reader.line_num}"), reader.line_num
            )
    except csv.Error as error:
        raise InputError(
            f"{source}: line {reader.line_num}: {error}; write comma-separated numbers"
        ) from None
    if not names:
        raise InputError(f"{source}: is empty; write a header and a row a sample")
    return names, rows


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _header(cells: list[str], source: str) -> tuple[str, ...]:
    names = tuple(cell.strip() for cell in cells)
    if len(names) == 1 and (";" in names[0] or "\t" in names[0]):
        separator = "semicolons" if ";" in names[0] else "tabs"
        raise InputError(
            f"{source}: line 1: the columns are separated by {separator}; "
            "write commas between columns and decimal points in numbers"
        )
    if all(_is_number(name) for name in names):
        raise InputError(
            f"{source}: line 1 holds numbers, not names; write a header such as t,count_u0"
        )
    if names[0].startswith("#"):
        raise InputError(f"{source}: line 1 is a comment; remove it, the first line names columns")
    if len(names) > MOST_COLUMNS:
        raise InputError(f"{source}: {len(names)} columns; write at most {MOST_COLUMNS}")
    if "" in names:
        raise InputError(
            f"{source}: column {names.index('') + 1} has no name; write a header such as t,count_u0"
        )
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(f"{source}: column {twice[0]} stands there twice; remove one of them")
    return names


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(cells: list[str], names: tuple[str, ...], place: str) -> list[float]:
    """Return the numbers of one row; Python's own float takes more than a CSV may hold."""
    try:
        numbers = [float(cell) if cell else math.nan for cell in cells]
    except ValueError:
        numbers = [
            _number(cell.strip(), f"{place}, column {name}")
            for cell, name in zip(cells, names, strict=True)
        ]
    if math.inf in numbers or -math.inf in numbers or any("_" in cell for cell in cells):
        for cell, name in zip(cells, names, strict=True):
            _number(cell.strip(), f"{place}, column {name}")
    return numbers


def _number(cell: str, place: str) -> float:
    shown = cell if len(cell) <= _SHOWN else cell[: _SHOWN - 4] + " ..."
    if not cell:
        return math.nan
    try:
        number = float(cell)
    except ValueError:
        number = math.inf
    if "_" in cell or math.isinf(number):
        raise InputError(
            f"{place}: {shown!r} is not a number; write one with a decimal point, or leave the "
            "cell empty"
        )
    return number
