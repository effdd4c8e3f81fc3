"""The one style of all figures, and the neutral axis as a curve.

A curve is the neutral axis in the plane of bending, in metres: deflection to the right for a
positive angle, the unbent axis upwards. The same data give the same bytes.
"""

import functools
import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from ccgen.kinematics import chain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
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
POINTS_PER_SEGMENT = 8
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


def planar_curve(angles: Floats, segment_length: float) -> tuple[Floats, Floats]:
    """Neutral axis of a joint bent in one plane, several points a segment.

    Args:
        angles: segment angles of the bending axis, shape (m,), radians.
        segment_length: metres.

    Returns:
        Deflection and height, shape (points,), metres, the base included.
    """
    bent = np.asarray(angles)
    curve = space_curve(np.zeros_like(bent), bent, np.full_like(bent, segment_length))
    return curve[:, 0], curve[:, 2]


def space_curve(u: Floats, v: Floats, lengths: Floats) -> Floats:
    """Neutral axis of a joint in the base frame, several points a segment.

    Args:
        u: bends of the segments about x, shape (m,), radians.
        v: the same about y.
        lengths: of the segments, shape (m,), metres.

    Returns:
        Shape (points, 3), metres, the base included.
    """
    parts = (np.repeat(x / POINTS_PER_SEGMENT, POINTS_PER_SEGMENT) for x in (u, v, lengths))
    return np.concatenate([np.zeros((1, 3)), chain(*parts)[:, :3, 3]])


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
