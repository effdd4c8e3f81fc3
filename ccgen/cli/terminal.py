"""Standard output and error as they come: in any encoding, closed, full, or with nobody listening.

What an encoding lacks is written in ASCII. A pipe that its reader has closed takes what is still
written as the null device would: the program ends as it would have ended, without a word. An output
that fails otherwise, such as on a full disk, is an error.
"""

import codecs
import io
import os
import sys
import unicodedata
from typing import Any

_ERRORS = "ccgen-ascii"

_ASCII = {
    "µ": "u", "μ": "u", "°": " deg", "±": "+-", "×": "x", "·": "*", "−": "-", "–": "-", "—": "-",
    "≥": ">=", "≤": "<=", "≈": "~", "→": "->", "Σ": "sum", "φ": "phi", "…": "...", "²": "^2",
    "○": "o", "‘": "'", "’": "'", "“": '"', "”": '"',
    **dict(zip("▁▂▃▄▅▆▇█", "_.-=+*%#", strict=True)),
}  # fmt: skip
"""What is written for signs that an encoding may lack; bars by their height."""


def in_ascii(text: str) -> str:
    """A text in ASCII: signs by their meaning, letters without accents, the rest by number."""
    return "".join(_sign(character) for character in text)


def _sign(character: str) -> str:
    if character.isascii():
        return character
    if character in _ASCII:
        return _ASCII[character]
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode("ascii")
    return plain or character.encode("ascii", "backslashreplace").decode("ascii")


def _replace(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return in_ascii(error.object[error.start : error.end]), error.end


class _Output(io.FileIO):
    """A file descriptor that fails once at most, and takes everything once nobody listens."""

    def __init__(self, descriptor: int, name: str, silent: bool) -> None:
        super().__init__(descriptor, "wb", closefd=False)
        self._name, self._silent = name, silent
        self._gone = False

    @property
    def gone(self) -> bool:
        """Whether nobody takes what is written any more."""
        return self._gone

    def write(self, data: Any) -> int:
        """Write; see the class.

        Raises:
            OSError: for the first failure that is not a closed pipe, unless silent.
        """
        if self._gone:
            return memoryview(data).nbytes
        try:
            return super().write(data) or 0
        except OSError as error:
            self._gone = True
            if not self._silent and not isinstance(error, BrokenPipeError):
                raise OSError(error.errno, error.strerror, self._name) from error
            return memoryview(data).nbytes


def nobody_listens() -> bool:
    """Whether the reader of the standard output has closed it: what has no end by itself ends."""
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return isinstance(raw, _Output) and raw.gone


class Terminal:
    """The program's standard output and error, put in the place of Python's."""

    def __init__(self) -> None:
        codecs.register_error(_ERRORS, _replace)
        for descriptor in range(3):
            _open_if_closed(descriptor)
        self._out = _Output(1, "standard output", silent=False)
        sys.stdout = _text(self._out, sys.stdout)
        sys.stderr = _text(_Output(2, "standard error", silent=True), sys.stderr)

    def finish(self) -> OSError | None:
        """Write what is left; return why that was not possible."""
        try:
            sys.stdout.flush()
        except OSError as error:
            return error
        return None


def _open_if_closed(descriptor: int) -> None:
    """Give a closed descriptor the null device, before a file of ours takes its number."""
    try:
        os.fstat(descriptor)
    except OSError:
        os.open(os.devnull, os.O_RDWR)


def _text(raw: _Output, before: object) -> io.TextIOWrapper:
    """A text stream as Python's own was, but for what its encoding lacks."""
    own = before if isinstance(before, io.TextIOWrapper) else None
    if os.name == "nt" and own is not None and own.isatty():
        own.reconfigure(errors=_ERRORS)  # a console takes characters, not bytes
        return own
    # What PYTHONUNBUFFERED asks for is written line by line.
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=own.encoding if own else "utf-8",
        errors=_ERRORS,
        line_buffering=own.line_buffering or own.write_through if own else True,
    )
