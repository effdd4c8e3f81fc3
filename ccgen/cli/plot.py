"""Figures into files, by the ending of their name."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.cli.output import note
from ccgen.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".svg", ".png")


def write_plot(path: Path, draw: Callable[[], "Figure"]) -> None:
    """Draw a figure and write it.

    Raises:
        InputError: an ending that is neither .svg nor .png, or a place that cannot be written.
    """
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"--plot: {path}: unknown format; give a name that ends in .svg or .png")
    from ccgen.figures.style import figure_bytes
    from ccgen.outputs import write_file

    write_file(path, figure_bytes(draw(), path.suffix.lower().removeprefix(".")))
    note(f"wrote {path}")
