"""Shapes on which estimates are worst."""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.fitted import FittedWeights
from ccgen.figures.style import number_segments, shortened, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def worst_figure(fit: FittedWeights) -> "Figure":
    """Draw, of each source, the shape whose tip is estimated worst: true and estimated angles.

    Of the axis that is off most there. Without noise: these errors are of the weights alone.
    """
    from matplotlib.figure import Figure

    bending = [axis for axis in fit.sensed.axes if axis != "h"]
    figure = Figure(figsize=(4.6, 0.5 + 2.1 * len(fit.told)), layout="constrained")
    rows = figure.subplots(len(fit.told), 1, squeeze=False, sharex=True)[:, 0]
    for source, axes in zip(fit.told, rows, strict=True):
        missed = fit.missed(source, False)
        tip = missed.tip[0]
        row = int(np.nanargmax(tip))
        axis = max(bending, key=lambda name: float(np.abs(missed.known(name)[row]).max()))
        true = np.degrees(missed.truth(axis)[row])
        estimated = true + np.degrees(missed.known(axis)[row])
        axes.stairs(true, baseline=None, color="#000000", linewidth=3.5, alpha=0.3, label="true")
        axes.stairs(estimated, baseline=None, color="#D55E00", linewidth=1.4, label="estimated")
        off = f"tip off by {1e3 * tip[row]:.3g} mm"
        axes.set(title=f"{shortened(source.name)}, {axis}: {off}", ylabel="degrees")
    rows[-1].set_xlabel("segment")
    number_segments(rows[-1].xaxis, fit.sensed.geometry.segments)
    rows[0].legend()
    return figure
