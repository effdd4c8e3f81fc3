"""Errors along a joint, by the shapes that they are met on."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.errors import StandardDeviations, standard_deviations
from ccgen.estimation.fitted import FittedWeights
from ccgen.figures.style import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colours of Okabe and Ito, told apart by readers with any colour vision.
_COLOURS = ("#000000", "#E69F00", "#56B4E9", "#009E73", "#D55E00", "#CC79A7", "#0072B2")
_LINES = {"u": "-", "v": "--"}
_ALIKE = 0.01
"""Share by which curves differ at most that lie on each other."""
_SMALLEST = 1e-6
"""Degrees; less is not drawn."""


def errors_along(fit: FittedWeights) -> Iterator[tuple[str, StandardDeviations]]:
    """Sources of a fit by name, each with the errors of every segment, noise and all."""
    for source in fit.told:
        yield source.name, standard_deviations(fit.missed(source, True))
    if fit.recorded is not None:
        for i, reference in enumerate(fit.recorded.whole.found.references):
            yield reference.name, standard_deviations(fit.recorded.judged(i, True))


def _curves(found: StandardDeviations) -> list[tuple[str, Floats]]:
    """Errors by bending axis; one curve where both are alike, for one would hide the other."""
    bends = {axis: np.asarray(found.axes[axis]) for axis in found.axes if axis != "h"}
    if len(bends) == 2 and np.allclose(bends["u"], bends["v"], rtol=_ALIKE, atol=0.0):
        return [("u and v", bends["u"])]
    return list(bends.items())


def draw_errors_along(fit: FittedWeights, axes: "Axes") -> None:
    """Draw the root mean square error of every segment, a colour a source, a line an axis."""
    joint = fit.sensed
    segments = joint.geometry.segments
    centre = (np.arange(segments) + 0.5) * joint.geometry.segment_length
    for i, (name, found) in enumerate(errors_along(fit)):
        for which, errors in _curves(found):
            axes.plot(
                centre,
                np.maximum(np.degrees(errors), _SMALLEST),
                color=_COLOURS[i % len(_COLOURS)],
                linestyle=_LINES[which[0]],
                marker=".",
                linewidth=1.2,
                label=f"{name}, {which}",
            )
    axes.set(
        title="Error of a segment, by the shapes that it is met on, with noise",
        xlabel="along the joint / m",
        ylabel="RMS / deg",
        yscale="log",
        xlim=(0.0, joint.geometry.length),
    )
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
