"""Exported folders as commands are given them: by name, or as a joint's file."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.errors import InputError

if TYPE_CHECKING:
    from ccgen.targets.exported import Exported


@contextmanager
def opened(path: Path) -> Iterator["Exported"]:
    """Open an exported folder, or export a joint's file into one that goes away again."""
    from ccgen.targets.exported import open_exported

    if not path.exists():
        raise InputError(
            f"{path}: no such folder or joint file; `ccgen init NAME` writes a joint file"
        )
    if path.is_dir():
        yield open_exported(path)
        return
    from ccgen.export.package import export

    with tempfile.TemporaryDirectory() as folder:
        export(path, Path(folder) / "joint")
        yield open_exported(Path(folder) / "joint")
