"""The one style of all figures. The same data give the same bytes."""

import functools
import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
P = ParamSpec("P")
T = TypeVar("T")

STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9.0,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "svg.fonttype": "path",
    "svg.hashsalt": "ccgen",
}
_MOST_NUMBERS = 16
"""Numbers of segments along an axis."""
_LONGEST_NAME = 26
"""Characters."""


def styled(draw: Callable[P, T]) -> Callable[P, T]:
    """Draw in the style of all figures."""

    @functools.wraps(draw)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        import matplotlib

        with matplotlib.rc_context(STYLE):
            return draw(*args, **kwargs)

    return run


@styled
def figure_bytes(figure: "Figure", file_format: str) -> bytes:
    """Return the figure as a file of the format "svg" or "png", without date and version."""
    metadata = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}
    buffer = io.BytesIO()
    figure.savefig(buffer, format=file_format, dpi=150, metadata=metadata[file_format])
    return buffer.getvalue()


def shortened(name: str) -> str:
    """A source's name as it fits into a picture: the end of a long path."""
    return name if len(name) <= _LONGEST_NAME else "…" + name[1 - _LONGEST_NAME :]


def new_figure(size: tuple[float, float], columns: int, rows: int = 1) -> tuple["Figure", Any]:
    """A figure of a size in inches, and its axes: an array, two-dimensional for several rows."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    heights = [2, 1, 1.2][:rows] if rows > 1 else [1]
    axes = figure.subplots(rows, columns, squeeze=False, height_ratios=heights)
    return figure, axes if rows > 1 else axes[0]


def number_segments(axis: "Axis", segments: int) -> None:
    """Number segments along an axis on which segment i reaches from i to i + 1, in its middle."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    step = max(1, -(-segments // _MOST_NUMBERS))
    numbers = range(0, segments, step)
    axis.set_major_locator(FixedLocator([i + 0.5 for i in numbers]))
    axis.set_major_formatter(FixedFormatter([str(i) for i in numbers]))
    axis.set_minor_locator(FixedLocator(range(segments + 1)))
    axis.set_tick_params(which="major", length=0)
    axis.grid(visible=False, which="major")
    axis.grid(visible=True, which="minor")


def plain_numbers(axis: "Axis") -> None:
    """Number a logarithmic axis 0.02, 0.1, 3 rather than by powers of ten."""
    from matplotlib.ticker import LogFormatter

    class Plain(LogFormatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:g}" if super().__call__(x, pos) else ""

    axis.set_major_formatter(Plain(labelOnlyBase=False))
    axis.set_minor_formatter(Plain(labelOnlyBase=False, minor_thresholds=(1, 0.4)))


def whole_row(figure: "Figure", axes: Any) -> "Axes":
    """One for the whole row in the place of the axes of a row."""
    grid, row = axes[0].get_gridspec(), axes[0].get_subplotspec().rowspan.start
    for one in axes:
        one.remove()
    return figure.add_subplot(grid[row, :])


def label_curve(axes: "Axes", title: str) -> None:
    """Label axes that show `planar_curve`, to scale."""
    axes.set(title=title, xlabel="deflection / m", ylabel="height / m", aspect="equal")
    axes.set_adjustable("datalim")


@styled
def figure_svg(figure: "Figure") -> str:
    """Return the figure as an element for a page: without prolog, on the page's own background."""
    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None}
    figure.savefig(buffer, format="svg", transparent=True, metadata=metadata)
    text = buffer.getvalue().decode("utf-8")
    return text[text.index("<svg") :]
