"""What a mutant is, and how one is put into a copy of the C runtime."""

import shutil
from dataclasses import dataclass
from pathlib import Path

from ccgen.resources import firmware


class StaleError(Exception):
    """The runtime has moved on from under the table."""


@dataclass(frozen=True)
class Mutant:
    """One change of the runtime that its unit tests are to notice.

    Attributes:
        file: path below `firmware_c`.
        old: what stands in the file exactly once.
        new: what it becomes.
        equivalent: why no test can tell the two apart; empty where one must.
    """

    file: str
    old: str
    new: str
    equivalent: str = ""

    def __str__(self) -> str:
        return f"{self.file}: {_one_line(self.old)}  ->  {_one_line(self.new) or 'nothing'}"


@dataclass(frozen=True)
class Group:
    """Mutants that the same tests see.

    Attributes:
        tests: files below `tests`, or tests in them, as pytest names them.
        chosen: pytest's expression for those that count; empty for all.
    """

    tests: tuple[str, ...]
    chosen: str
    mutants: tuple[Mutant, ...]


def of(file: str, tests: tuple[str, ...], *changes: tuple[str, ...], chosen: str = "") -> Group:
    """Mutants of one file, each as old text, new text and, where it has one, its reason."""
    return Group(tests, chosen, tuple(Mutant(file, *change) for change in changes))


def mutated(mutant: Mutant) -> str:
    """Return the file's text with the change in it.

    Raises:
        StaleError: there is no such file, or the old text does not stand in it exactly once.
    """
    path = firmware() / mutant.file
    if not path.is_file():
        raise StaleError(f"{mutant}: there is no such file")
    text = path.read_text()
    found = text.count(mutant.old)
    if found != 1 or mutant.old == mutant.new:
        raise StaleError(f"{mutant}: the old text stands there {found} times")
    return text.replace(mutant.old, mutant.new)


def copy_with(mutant: Mutant, folder: Path) -> Path:
    """Copy the runtime and put the change into the copy."""
    copy = shutil.copytree(firmware(), folder / "firmware_c")
    (copy / mutant.file).write_text(mutated(mutant))
    return copy


def _one_line(text: str) -> str:
    return " ".join(text.split())
