"""Which sources the study's numbers come from, told by one fingerprint."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]

_SOURCES = (
    *("double_double", "joint/__init__.py", "joint/layouts.py", "joint/loads.py"),
    *("digits.py", "joint/places.py", "joint/specification.py"),
    *("kinematics/__init__.py", "kinematics/tip.py", "kinematics/uvh.py", "shapes"),
    *("sensing/__init__.py", "sensing/arrangement.py", "sensing/noise.py", "sensing/readings.py"),
    *("recordings/__init__.py", "recordings/progress.py"),
    *("estimation", "placement", "study/joints.py", "study/paper.py"),
)
"""What `ccgen.study.joints` needs of this package, errors' texts aside."""


def sources() -> Iterator[Path]:
    """The files that scores depend on, in a fixed order."""
    for name in _SOURCES:
        path = PACKAGE / name
        yield from sorted(path.rglob("*.py")) if path.is_dir() else (path,)


def fingerprint() -> str:
    """SHA-256 over names and contents of the files that scores depend on."""
    digest = hashlib.sha256()
    for path in sources():
        data = path.read_bytes()
        digest.update(f"{path.relative_to(PACKAGE).as_posix()} {len(data)}\n".encode() + data)
    return digest.hexdigest()
