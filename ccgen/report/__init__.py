"""A joint's page for the design review.

The room itself can be called: `ccgen.report("finger.toml", "report.html")`.
"""

import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ccgen.fixedpoint import Fit
    from ccgen.joint import Joint


class _Report(ModuleType):
    def __call__(
        self, subject: "Fit | Joint | str | Path", output: str | Path, cost: bool = False
    ) -> Path:
        """As `ccgen.report.page.report`."""
        from ccgen.report.page import report

        return report(subject, output, cost)


sys.modules[__name__].__class__ = _Report
