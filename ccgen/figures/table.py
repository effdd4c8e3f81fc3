"""A table drawn as a figure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW_HEIGHT = 0.28
_FIRST_COLUMN = 1.6


def table_figure(title: str, header: Sequence[str], lines: Sequence[Sequence[str]]) -> "Figure":
    """Draw a table with a title.

    Args:
        title: stands above.
        header: titles of the columns.
        lines: texts of the cells, as many a line as there are columns.
    """
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

    header_rows = 1 + max(title.count("\n") for title in header)
    rows = len(lines) + header_rows
    figure = Figure(figsize=(1.25 * len(header), _ROW_HEIGHT * (rows + 1.5)))
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    axes.axis("off")
    axes.set_title(title, fontsize=10, y=1 - 1.2 / (rows + 1.5))
    table = axes.table(
        [list(line) for line in lines],
        colLabels=list(header),
        loc="lower center",
        cellLoc="center",
        colWidths=[_FIRST_COLUMN, *[1.0] * (len(header) - 1)],
        bbox=Bbox.from_bounds(0, 0, 1, rows / (rows + 1.5)),
    )
    table.auto_set_font_size(False)
    table.set_fontsize(8.5)
    for (row, _), cell in table.get_celld().items():
        cell.set_linewidth(0.4)
        if row == 0:
            cell.set_text_props(weight="bold")
            cell.set_height(header_rows * cell.get_height())
    return figure
