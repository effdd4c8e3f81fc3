"""Whether an exported folder computes what the model computes.

The room itself can be called: `ccgen.verify(DIR, target="cortex-m4")`.
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ccgen.verify.target import Verification


class _Verify(ModuleType):
    def __call__(
        self,
        directory: str | Path,
        target: str | Sequence[str] = "host",
        snapshots: int | None = None,
        values: int = 1_000_000,
        optimise: str = "2",
        seed: int = 0,
        report: Callable[[str, int, int], None] | None = None,
    ) -> "Verification":
        """As `ccgen.verify.target.verify`."""
        from ccgen.verify.target import verify

        return verify(directory, target, snapshots, values, optimise, seed, report)


sys.modules[__name__].__class__ = _Verify
