"""`ccgen fit`: the weights of a joint's estimator and how well they do."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Method
from ccgen.cli.output import note, print_json, show_table
from ccgen.cli.plot import write_plot

if TYPE_CHECKING:
    from ccgen.fixedpoint import Fit
    from ccgen.joint import Joint


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
    from ccgen.fixedpoint import fit as fitted_to
    from ccgen.joint.file import load

    joint = load(joint_file)
    fitted = fitted_to(joint, method)
    axes = {axis: _figures(fitted, axis) for axis in fitted.weights}
    for warning in fitted.warnings:
        note(f"warning: {warning}")
    if plot is not None:
        from ccgen.figures.case_study import case_study_figure

        write_plot(plot, lambda: case_study_figure(joint, method))
    if json:
        print_json(
            {
                "method": fitted.method,
                "axes": axes,
                "errors": [asdict(row) for row in fitted.errors],
                "warnings": list(fitted.warnings),
            }
        )
    else:
        _print(joint, fitted.method, axes)


def _figures(fitted: "Fit", axis: str) -> dict[str, Any]:
    """What the paper tells of an axis: its weights and their error on the load cases."""
    from ccgen.estimation import noise_gain

    weights = fitted.weights[axis]
    cases = {row.noise: row for row in fitted.errors if row.source == "cases"}
    scores = {noise: row.mean_percent_rom[axis] for noise, row in cases.items()}
    return {
        "spans": [list(span) for span in weights.spans],
        "weights": weights.matrix.tolist(),
        "intercept_rad": weights.intercept.tolist(),
        "weights_range": [float(weights.matrix.min()), float(weights.matrix.max())],
        "score_percent_rom": scores[False],
        "noise_gain": noise_gain(weights),
        "score_with_noise_percent_rom": scores.get(True),
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
