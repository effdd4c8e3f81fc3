"""Weights as heat maps."""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.fitted import FittedWeights
from ccgen.figures.style import number_segments, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = 41
"""Steps of the scale; matplotlib draws one of 50 or more as a picture of pixels."""


@styled
def matrix_figure(fit: FittedWeights) -> "Figure":
    """Draw the weights of each output axis: a row a segment or section, a column a sensor."""
    import matplotlib
    from matplotlib.figure import Figure

    colours = matplotlib.colormaps["PuOr"].resampled(_COLOURS)
    joint = fit.sensed
    figure = Figure(figsize=(4.6, 1.0 + 2.6 * len(joint.axes)), layout="constrained")
    rows = figure.subplots(len(joint.axes), 1, squeeze=False)[:, 0]
    for axis, axes in zip(joint.axes, rows, strict=True):
        matrix = fit.weights[axis].matrix
        largest = float(np.abs(matrix).max()) or 1.0
        drawn = axes.pcolormesh(matrix, cmap=colours, vmin=-largest, vmax=largest, shading="flat")
        names = [sensor.name for sensor in joint.sensors[joint.own(axis)]]
        axes.set_xticks(
            np.arange(len(names)) + 0.5, names, rotation=90 if len(names) > 6 else 0, fontsize=7.5
        )
        kind = "section" if axis == "h" else "segment"
        axes.set(title=f"Weights of {axis}", ylabel=kind)
        number_segments(axes.yaxis, len(matrix))
        axes.grid(visible=False, which="both")
        figure.colorbar(drawn, ax=axes, shrink=0.9).ax.tick_params(labelsize=7.0)
    return figure
