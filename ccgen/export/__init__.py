"""From a fit to the folder with its C. The room itself can be called: `ccgen.export(fit, DIR)`."""

import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ccgen.export.package import Export
    from ccgen.fixedpoint import Fit
    from ccgen.joint import Joint


class _Export(ModuleType):
    def __call__(
        self,
        fitted: "Fit | Joint | str | Path",
        directory: str | Path,
        functions: str | Path | None = None,
    ) -> "Export":
        """As `ccgen.export.package.export`."""
        from ccgen.export.package import export

        return export(fitted, directory, functions=functions)


sys.modules[__name__].__class__ = _Export
