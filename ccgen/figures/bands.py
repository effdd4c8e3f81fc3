"""Errors of every segment by the shapes that they are met on, noise as a band above."""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.errors import Missed, Pooled
from ccgen.estimation.fitted import FittedWeights
from ccgen.figures.style import Floats, number_segments, plain_numbers, shortened, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = ("#000000", "#E69F00", "#56B4E9", "#009E73", "#D55E00", "#CC79A7", "#0072B2")
_SMALLEST = 1e-5
"""Degrees; less is not drawn."""


@styled
def bands_figure(fit: FittedWeights) -> "Figure":
    """Draw the RMS error of every segment: a line without noise, and up to it with noise a band.

    Recordings have real noise in their readings: their errors are one line.
    """
    from matplotlib.figure import Figure

    joint = fit.sensed
    bending = [axis for axis in joint.axes if axis != "h"]
    figure = Figure(figsize=(4.6, 0.8 + 2.3 * len(bending)), layout="constrained")
    rows = figure.subplots(len(bending), 1, squeeze=False, sharex=True)[:, 0]
    numbers = np.arange(joint.geometry.segments) + 0.5
    for i, (name, plain, noisy) in enumerate(_sources(fit)):
        colour = _COLOURS[i % len(_COLOURS)]
        for axis, axes in zip(bending, rows, strict=True):
            upper = _rms(noisy, axis)
            lower = upper if plain is None else _rms(plain, axis)
            axes.fill_between(numbers, lower, upper, color=colour, alpha=0.25, linewidth=0.0)
            axes.plot(numbers, lower, ".-", color=colour, linewidth=1.2, label=shortened(name))
    for axis, axes in zip(bending, rows, strict=True):
        axes.set(title=f"Error of {axis}", ylabel="RMS / deg", yscale="log")
        plain_numbers(axes.yaxis)
    rows[-1].set_xlabel("segment")
    number_segments(rows[-1].xaxis, joint.geometry.segments)
    handles, labels = rows[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=7.0)
    return figure


def _sources(fit: FittedWeights) -> "list[tuple[str, Missed | None, Missed | Pooled]]":
    found: list[tuple[str, Missed | None, Missed | Pooled]] = [
        (source.name, fit.missed(source, False), fit.missed(source, True)) for source in fit.told
    ]
    if fit.recorded is not None:
        names = [one.name for one in fit.recorded.whole.found.references]
        found += [(name, None, fit.recorded.judged(i, True)) for i, name in enumerate(names)]
    return found


def _rms(missed: Missed | Pooled, axis: str) -> Floats:
    """Of every segment, shape (m,), degrees."""
    squares = np.square(missed.known(axis)) + np.square(missed.spread(axis))
    rms = np.degrees(np.sqrt(np.nanmean(squares, axis=0)))
    return np.asarray(np.maximum(rms, _SMALLEST))
