"""ccgen: shape estimation of continuum joints, from a joint's description to proven C.

    joint = ccgen.load("finger.toml")
    fit = ccgen.fit(joint)
    estimate = fit.estimate(counts)
    ccgen.export(fit, "firmware/finger")

Angles are in radians and lengths in metres; errors are those of `ccgen.errors`. What is listed in
`__all__` is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ccgen.calibration.calibrate import calibrate as calibrate
    from ccgen.cost.costs import cost as cost
    from ccgen.estimation.estimate import Estimate as Estimate
    from ccgen.export.package import export as export
    from ccgen.fixedpoint.fitted import Fit as Fit
    from ccgen.fixedpoint.fitted import fit as fit
    from ccgen.joint.file import load as load
    from ccgen.joint.file import parse as parse
    from ccgen.joint.specification import Joint as Joint
    from ccgen.placement.placed import place as place
    from ccgen.report.page import report as report
    from ccgen.sensing.simulation import simulate as simulate
    from ccgen.shapes.library import Shapes as Shapes
    from ccgen.verify.target import verify as verify

__version__ = "0.1.0"

FORMAT_VERSION = 3
"""Version of what generator and C runtime agree on; `CCGEN_FORMAT_VERSION` in C."""

_HOMES = {
    "Estimate": "estimation.estimate",
    "Fit": "fixedpoint.fitted",
    "Joint": "joint.specification",
    "Shapes": "shapes.library",
    "calibrate": "calibration.calibrate",
    "fit": "fixedpoint.fitted",
    "load": "joint.file",
    "parse": "joint.file",
    "place": "placement.placed",
    "simulate": "sensing.simulation",
}
"""Modules of the public names."""

_ROOMS = ("cost", "export", "report", "verify")
"""Public functions that have a room of their name: the room itself is called."""

__all__ = ["FORMAT_VERSION", "__version__", *_HOMES, *_ROOMS]


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"ccgen.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module 'ccgen' has no attribute {name!r}")
    value = getattr(import_module(f"ccgen.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
