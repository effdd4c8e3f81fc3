"""`ccgen fit`: the weights of a joint's estimator and how well they do."""

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Method
from ccgen.cli.fit_output import as_json, show_fit
from ccgen.cli.output import note, print_json, progress_bars, warn
from ccgen.cli.plot import write_plot
from ccgen.errors import ArgumentError, FormatError

if TYPE_CHECKING:
    from ccgen.fixedpoint import Fit
    from ccgen.joint import Joint


def fit(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    method: Annotated[
        Method | None, typer.Option("--method", help="Instead of the joint file's method.")
    ] = None,
    write: Annotated[
        bool,
        typer.Option(
            "--write",
            help="Keep the fit beside the joint file, for `ccgen export` to give the same bytes of "
            "the same files everywhere.",
        ),
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            "--plot",
            metavar="FILE",
            help="Draw estimated against actual, and errors along the joint: .svg or .png.",
        ),
    ] = None,
) -> None:
    """Fit a joint's estimator and tell its errors, by the shapes that they are met on.

    \b
    Example:
      ccgen fit shoulder.toml --method equal --plot shapes.svg
    """
    from ccgen.fixedpoint import fit as fitted_to
    from ccgen.joint.file import load
    from ccgen.recordings.progress import in_silence

    if write and method is not None:
        raise ArgumentError(
            "takes no part in what --write keeps; write estimator.method in the joint file",
            "method",
        )
    joint = load(joint_file)
    said = _said_before(joint, write)
    warn(said)
    with progress_bars(lines=True) if joint.recordings else nullcontext(in_silence) as report:
        fitted = fitted_to(joint, method, report=report)
        if write:
            fitted = _kept(fitted)
        axes = {axis: _figures(fitted, axis) for axis in fitted.weights}
    if plot is not None:
        from ccgen.figures.case_study import case_study_figure

        write_plot(plot, lambda: case_study_figure(fitted, along=True))
    record = as_json(fitted, axes)  # everything, before the first line is printed
    if json:
        print_json(record)
        return
    show_fit(fitted, axes)
    warn(one for one in fitted.warnings if one not in said)


def _said_before(joint: "Joint", write: bool) -> tuple[str, ...]:
    """Warnings that need not wait for what recordings tell.

    Raises:
        FormatError: no fixed point can be kept, whatever they tell.
    """
    from ccgen.fixedpoint.advice import unexportable
    from ccgen.fixedpoint.beforehand import check_counts

    try:
        return check_counts(joint)
    except FormatError as error:
        if write:
            raise
        return (unexportable(error),)


def _kept(fitted: "Fit") -> "Fit":
    """The fit as it is kept beside the joint file from now on."""
    from ccgen.fixedpoint.kept import rounded, write_fit

    found = rounded(fitted)
    note(f"wrote {write_fit(found)}")
    return found


def _figures(fitted: "Fit", axis: str) -> dict[str, Any]:
    """What the paper tells of an axis: its weights and their error on the load cases."""
    from ccgen.estimation import elongation_adds, noise_gain
    from ccgen.sensing.noise import stated_noise

    weights = fitted.weights[axis]
    known = stated_noise(fitted.joint) is not None
    cases = {
        row.noise: row
        for row in fitted.errors
        if row.source == "cases" and (known or not row.noise)
    }
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
            "rms_percent": errors.get(False),
            "rms_with_noise_percent": errors.get(True),
        }
    scores = {noise: row.mean_percent_rom[axis] for noise, row in cases.items()}
    return figures | {
        "intercept_rad": weights.intercept.tolist(),
        "score_percent_rom": scores.get(False),
        "score_with_noise_percent_rom": scores.get(True),
        "elongation_adds_percent_rom": elongation_adds(fitted.joint, fitted.weights)[axis],
    }
