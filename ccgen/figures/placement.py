"""Placements drawn along the joint."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ccgen.figures.style import number_segments, styled
from ccgen.placement.problem import Placement

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOUR = "#0072B2"
_FIXED = "#999999"
_ROW = 0.22
_WIDTH = 7.0


@styled
def placement_figure(
    placements: Sequence[Placement],
    segments: int,
    forbidden: Sequence[int] = (),
    unit: str = "ROM",
    names: Sequence[str] = (),
) -> "Figure":
    """Draw each placement's spans over the segments, one line a sensor.

    Args:
        placements: drawn below each other, titled with method and score.
        segments: number m of segments.
        forbidden: segments at which nothing can be attached; shaded.
        unit: what the scores are shares of.
        names: of the sensors whose spans these are, where they differ in more than spans.
    """
    from matplotlib.figure import Figure

    lines = [len(placement.spans) for placement in placements]
    height = sum(0.55 + _ROW * count for count in lines) + 0.5
    figure = Figure(figsize=(_WIDTH, height), layout="constrained")
    ratios = [count + 1.0 for count in lines]
    column = figure.subplots(len(placements), 1, sharex=True, squeeze=False, height_ratios=ratios)
    for axes, placement in zip(column[:, 0], placements, strict=True):
        _draw(axes, placement, segments, forbidden, names)
        title = f"{placement.method}: {placement.percent:.4g} % of {unit}"
        axes.set_title(title, fontsize=9)
    column[-1, 0].set_xlabel("segment (0 at the base)", fontsize=9)
    return figure


def _draw(
    axes: "Axes",
    placement: Placement,
    segments: int,
    forbidden: Sequence[int],
    names: Sequence[str],
) -> None:
    for segment in forbidden:
        axes.axvspan(segment, segment + 1, color=_FIXED, alpha=0.25, linewidth=0)
    for line, (first, last) in enumerate(placement.spans):
        axes.barh(line, last - first + 1, 0.55, left=first, color=_COLOUR)
        axes.plot([first, last + 1], [line, line], "|", color="black", markersize=9)
    axes.set_xlim(-0.1, segments + 0.1)
    axes.set_ylim(len(placement.spans) - 0.4, -0.6)
    axes.set_yticks(range(len(placement.spans)), names or None)
    number_segments(axes.xaxis, segments)
    axes.grid(visible=False, axis="y")
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8)
