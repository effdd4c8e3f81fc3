"""`ccgen fit`: the weights of a joint's estimator and how well they do."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Method
from ccgen.cli.output import print_json, show_table
from ccgen.cli.plot import write_plot

if TYPE_CHECKING:
    from ccgen.estimation import Weights
    from ccgen.joint import Joint
    from ccgen.shapes import ShapeLibrary


def fit(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    method: Annotated[
        Method | None, typer.Option("--method", help="Instead of the joint file's method.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Draw estimated against actual: .svg or .png."),
    ] = None,
) -> None:
    """Fit a joint's estimator and score it on shapes between those it was fitted to.

    \b
    Example:
      ccgen fit shoulder.toml --method equal --plot shapes.svg
    """
    from ccgen.estimation import fit_joint
    from ccgen.joint import AXES
    from ccgen.joint.file import read_joint
    from ccgen.shapes import score_library

    joint = read_joint(joint_file)
    weights = fit_joint(joint, method)
    library = score_library(joint)
    axes = {axis: _figures(joint, axis, weights[axis], library) for axis in AXES}
    if plot is not None:
        from ccgen.figures.case_study import case_study_figure

        write_plot(plot, lambda: case_study_figure(joint, method))
    if json:
        print_json({"method": weights["u"].method, "axes": axes})
    else:
        _print(joint, weights["u"].method, axes)


def _figures(
    joint: "Joint", axis: str, weights: "Weights", library: "ShapeLibrary"
) -> dict[str, Any]:
    from ccgen.estimation import noise_gain, score_percent_rom, score_with_noise_percent_rom
    from ccgen.sensing.noise import reading_noise

    noise = reading_noise(joint, axis)
    return {
        "spans": [list(span) for span in weights.spans],
        "weights": weights.matrix.tolist(),
        "intercept_rad": weights.intercept.tolist(),
        "weights_range": [float(weights.matrix.min()), float(weights.matrix.max())],
        "score_percent_rom": score_percent_rom(weights, library),
        "noise_gain": noise_gain(weights),
        "score_with_noise_percent_rom": (
            None if noise is None else score_with_noise_percent_rom(weights, library, noise)
        ),
    }


def _print(joint: "Joint", method: str, axes: dict[str, dict[str, Any]]) -> None:
    from rich.table import Table

    table = Table("", title=f"{joint.name}: {method}", title_justify="left")
    for axis in axes:
        table.add_column(axis, justify="right")
    columns = [_column(figures) for figures in axes.values()]
    for title in columns[0]:
        table.add_row(title, *(column[title] for column in columns))
    show_table(table)


def _column(figures: dict[str, Any]) -> dict[str, str]:
    with_noise = figures["score_with_noise_percent_rom"]
    smallest, largest = figures["weights_range"]
    return {
        "sensors": str(len(figures["spans"])),
        "spans": " ".join(f"{first}-{last}" for first, last in figures["spans"]),
        "score / % of ROM": f"{figures['score_percent_rom']:.4g}",
        "with sensor noise": "not known" if with_noise is None else f"{with_noise:.4g}",
        "noise gain": f"{figures['noise_gain']:.4g}",
        "smallest weight": f"{smallest:.4g}",
        "largest weight": f"{largest:.4g}",
    }
