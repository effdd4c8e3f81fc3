"""What may be wrong with the joints of one bus."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Kind = Literal["identifiers", "data-ids", "bit-rate", "bus-load", "names", "older", "edited"]

KINDS: dict[Kind, str] = {
    "identifiers": "no two joints share an identifier",
    "data-ids": "no two joints share a data ID of the end-to-end protection",
    "names": "no names meet in one program",
    "older": "folders are of the joint file as it is",
    "edited": "folders are as they were written",
    "bit-rate": "all joints state one bit rate",
    "bus-load": "the frames of all joints fit the bus",
}
"""What is checked: of every path, of folders, of the bus."""

OF_FOLDERS: tuple[Kind, ...] = ("older", "edited")
OF_THE_BUS: tuple[Kind, ...] = ("bit-rate", "bus-load")


@dataclass(frozen=True)
class Problem:
    """One problem: the path that it is told of, its kind, and a sentence."""

    file: Path
    kind: Kind
    text: str

    def record(self) -> dict[str, str]:
        """As it stands in JSON."""
        return {"file": str(self.file), "kind": self.kind, "text": self.text}
