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
    from ccgen.estimation import elongation_adds, noise_gain

    weights = fitted.weights[axis]
    cases = {row.noise: row for row in fitted.errors if row.source == "cases"}
    figures = {
        "spans": [list(span) for span in weights.spans],
        "weights": weights.matrix.tolist(),
        "weights_range": [float(weights.matrix.min()), float(weights.matrix.max())],
        "noise_gain": noise_gain(weights),
    }
    if axis == "h":
        errors = {noise: row.elongation_rms_percent for noise, row in cases.items()}
        return figures | {
            "intercept": weights.intercept.tolist(),
            "rms_percent": errors[False],
            "rms_with_noise_percent": errors.get(True),
        }
    scores = {noise: row.mean_percent_rom[axis] for noise, row in cases.items()}
    return figures | {
        "intercept_rad": weights.intercept.tolist(),
        "score_percent_rom": scores[False],
        "score_with_noise_percent_rom": scores.get(True),
        "elongation_adds_percent_rom": elongation_adds(fitted.joint, fitted.weights)[axis],
    }


def _print(joint: "Joint", method: str, axes: dict[str, dict[str, Any]]) -> None:
    from rich.table import Table

    table = Table("", title=f"{joint.name}: {method}", title_justify="left")
    for axis in axes:
        table.add_column(axis, justify="right")
    columns = [_column(figures) for figures in axes.values()]
    titles = list(dict.fromkeys(title for column in columns for title in column))
    if joint.couples:
        titles.remove("spans")  # every axis reads all sensors: `ccgen simulate` lists them
    for title in titles:
        table.add_row(title, *(column.get(title, "") for column in columns))
    show_table(table)


def _column(figures: dict[str, Any]) -> dict[str, str]:
    """Figures by their titles, in the order of the table."""
    smallest, largest = figures["weights_range"]
    column = {
        "sensors": str(len(figures["spans"])),
        "spans": " ".join(f"{first:g}-{last:g}" for first, last in figures["spans"]),
    }
    for key, title in _ERRORS.items():
        if key in figures:
            column[title] = "not known" if figures[key] is None else f"{figures[key]:.4g}"
    return column | {
        "noise gain": f"{figures['noise_gain']:.4g}",
        "smallest weight": f"{smallest:.4g}",
        "largest weight": f"{largest:.4g}",
    }


_ERRORS = {
    "score_percent_rom": "score / % of ROM",
    "score_with_noise_percent_rom": "with sensor noise",
    "elongation_adds_percent_rom": "1 % elongation adds",
    "rms_percent": "RMS / % of length",
    "rms_with_noise_percent": "RMS with sensor noise",
}
"""Keys of an axis' errors and the titles of their rows."""
