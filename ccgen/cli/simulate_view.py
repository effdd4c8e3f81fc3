"""A simulated shape in the browser: there and back, as the joint's own sensors see it."""

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from ccgen.cli.ending import asked_to_end
from ccgen.cli.viewing import stay, viewed

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.sensing.bending import Bending

_STEPS = 60
_BEND_SECONDS, _HOLD_SECONDS = 2.0, 1.5


def show_bending(joint: "Joint", bending: "Bending", port: int | None, no_browser: bool) -> None:
    """Show a joint that is bent, held and let go, until the page is closed.

    Raises:
        As `ccgen.cli.viewing.viewed`; InputError: a joint that cannot be fitted.
    """
    from ccgen.fixedpoint import fit
    from ccgen.view.simulated import as_found, simulated_sights

    fitted = fit(joint)
    found = as_found(fitted)
    shapes = [bending.at(found, step / _STEPS) for step in range(1, _STEPS + 1)]
    sights = simulated_sights(fitted, shapes)
    begin = time.monotonic()
    with asked_to_end() as ended, viewed(found, "the simulated shape", port, no_browser) as page:
        for _ in stay(page, ended):
            now = time.monotonic() - begin
            page.show(replace(sights[_step(now)], t=now))


def _step(seconds: float) -> int:
    """Which of the shapes is shown."""
    within = seconds % (2 * (_BEND_SECONDS + _HOLD_SECONDS))
    there = within < _BEND_SECONDS + _HOLD_SECONDS
    part = within if there else within - _BEND_SECONDS - _HOLD_SECONDS
    share = min(part / _BEND_SECONDS, 1.0)
    return round((share if there else 1.0 - share) * (_STEPS - 1))
