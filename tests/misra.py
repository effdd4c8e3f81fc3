"""What cppcheck's MISRA C:2012 addon finds in an exported folder, and what is on record for it."""

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "firmware_c" / "MISRA.md"

ADVISORY = frozenset(
    [
        "2.3",
        "2.4",
        "2.5",
        "2.6",
        "2.7",
        "4.2",
        "5.9",
        "8.7",
        "8.9",
        "8.11",
        "8.13",
        "10.5",
        "11.4",
        "11.5",
        "12.1",
        "12.3",
        "12.4",
        "13.3",
        "13.4",
        "15.1",
        "15.4",
        "15.5",
        "17.5",
        "17.8",
        "18.4",
        "18.5",
        "19.2",
        "20.1",
        "20.5",
        "20.10",
        "21.12",
    ]
)
"""Rules that the standard calls advisory; all others are required or mandatory."""

_FOUND = re.compile(r"^(?P<file>[^:]+):(?P<line>\d+):(?P<rule>\d+\.\d+)$")
_TAG = re.compile(r"MISRA ((?:\d+\.\d+)(?:, \d+\.\d+)*)(?P<throughout> throughout)?")
_ROW = re.compile(r"^\| (?P<rule>\d+\.\d+) \| (?P<place>[^|]+) \| (?P<reason>[^|]+) \|$", re.M)


@dataclass(frozen=True, order=True)
class Finding:
    """A required rule that a line does not keep."""

    file: Path
    line: int
    rule: str

    def __str__(self) -> str:
        return f"{self.file.name}:{self.line}: rule {self.rule}: {self.text.strip()}"

    @property
    def text(self) -> str:
        return self.file.read_text().splitlines()[self.line - 1]


def findings(folder: Path, *flags: str) -> list[Finding]:
    """Return the findings of required rules in a folder's own sources, without repetition."""
    sources = sorted([*folder.glob("src/*.c"), *folder.glob("src/ccgen/*.c")])
    # Names within the folder: the addon passes over every file with "misra" in its path.
    done = subprocess.run(
        ["cppcheck", "--std=c99", "--addon=misra", "--enable=style", "--quiet", "--template",
         "{file}:{line}:{id}", "-Isrc", *flags, *(str(s.relative_to(folder)) for s in sources)],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = set()
    for line in done.stderr.splitlines():
        match = _FOUND.match(line.replace(":misra-c2012-", ":"))
        if match and match["rule"] not in ADVISORY:
            found.add(Finding(folder / match["file"], int(match["line"]), match["rule"]))
    return sorted(found)


def recorded() -> dict[str, str]:
    """Rules of the record, with their reasons."""
    return {row["rule"]: row["reason"] for row in _ROW.finditer(RECORD.read_text())}


def is_recorded(finding: Finding) -> bool:
    """Whether the record has the rule, and the place its tag."""
    return finding.rule in recorded() and is_tagged(finding)


def is_tagged(finding: Finding) -> bool:
    """Whether a tag of the rule stands at the line, above it or over the file."""
    lines = finding.file.read_text().splitlines()
    near = lines[max(0, finding.line - 2) : finding.line]
    tags = [_TAG.search(line) for line in near]
    tags += [tag for line in lines if (tag := _TAG.search(line)) and tag["throughout"]]
    rules = {rule for tag in tags if tag for rule in tag[1].split(", ")}
    return finding.rule in rules
