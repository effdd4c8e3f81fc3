"""`ccgen place`: where to put the sensors."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Axis, Generations, Individuals
from ccgen.cli.output import note, print_json, results
from ccgen.cli.plot import write_plot
from ccgen.errors import InputError

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.layouts import Span
    from ccgen.placement import Constraints, Evolution, Placement, Problem


class PlacementMethod(StrEnum):
    """`ccgen.placement.METHODS`."""

    SINGLE = "single"
    END_TO_END = "end-to-end"
    HEURISTIC = "heuristic"
    EVOLUTIONARY = "evolutionary"
    SEARCH = "search"


class Objective(StrEnum):
    """What a placement is judged by."""

    PAPER = "paper"
    NOISE = "noise"


def place(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    sensors: Annotated[
        int | None,
        typer.Option("--sensors", metavar="N", help="Sensors per axis.  [default: as in the file]"),
    ] = None,
    method: Annotated[
        PlacementMethod | None,
        typer.Option("--method", help="Only this one.  [default: all are compared]"),
    ] = None,
    axis: Annotated[
        Axis | None, typer.Option("--axis", help="For one axis only.  [default: for both]")
    ] = None,
    objective: Annotated[
        Objective | None,
        typer.Option(
            "--objective",
            help="paper: error of WAM without noise; noise: expected error of the noise-aware"
            " estimator under the transducer's noise.  [default: by the joint's estimator]",
        ),
    ] = None,
    shortest: Annotated[
        int, typer.Option("--min-span", metavar="N", help="Fewest segments of a span.")
    ] = 1,
    longest: Annotated[
        int | None, typer.Option("--max-span", metavar="N", help="Most segments of a span.")
    ] = None,
    forbidden: Annotated[
        str,
        typer.Option(
            "--forbid", metavar="LIST", help="Segments where no span may begin or end: 3,7-9."
        ),
    ] = "",
    fixed: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="A-B", help="A sensor that stays; may be repeated."),
    ] = None,
    stacked: Annotated[
        int | None, typer.Option("--max-stacked", metavar="N", help="Most sensors over a segment.")
    ] = None,
    enumerated: Annotated[
        int, typer.Option("--enumerate", metavar="N", help="Prove up to so many placements.")
    ] = 300_000,
    starts: Annotated[
        int, typer.Option("--starts", metavar="N", help="Descents of the search.")
    ] = 24,
    individuals: Individuals = 500,
    generations: Generations = 10,
    seed: Annotated[int, typer.Option("--seed", help="Of all random numbers.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Draw the spans: .svg or .png."),
    ] = None,
) -> None:
    """Place the sensors of a joint, compare the methods, and print the spans to paste.

    \b
    Example:
      ccgen place shoulder.toml --sensors 3 --plot spans.svg
    """
    from ccgen.joint import read_joint
    from ccgen.placement import Constraints, Evolution, Search

    joint = read_joint(joint_file)
    constraints = Constraints(
        shortest=shortest,
        longest=longest,
        forbidden=_segments(forbidden),
        fixed=tuple(_span(text) for text in fixed or ()),
        stacked=stacked,
    )
    problem = _problem(joint, axis, sensors, objective, constraints)
    evolution = Evolution(individuals=individuals, generations=generations, seed=seed)
    searching = Search(enumerated=enumerated, starts=starts, seed=seed)
    found = _find(problem, method, evolution, searching)
    # Of equals the last, which is the one that may be proven.
    best = min(reversed(found), key=lambda placement: placement.percent)
    described = [_describe(joint, axis, problem, placement) for placement in found]
    if plot is not None:
        from ccgen.placement.figure import placement_figure

        write_plot(plot, lambda: placement_figure(found, problem.segments, constraints.forbidden))
    if json:
        chosen = described[found.index(best)]
        objective_name = Objective.NOISE if problem.noise else Objective.PAPER
        print_json({**chosen, "objective": str(objective_name), "methods": described})
        return
    _print(problem, described)
    table = "sensors" if axis is None else f"sensors.{axis}"
    note(f"the best, {best.method}, for the joint file (it replaces placement and count):")
    spans = [list(span) for span in best.spans]
    results().print(f"[{table}]\nspans = {spans}", markup=False, soft_wrap=True)


def _problem(
    joint: "Joint",
    axis: Axis | None,
    sensors: int | None,
    objective: Objective | None,
    constraints: "Constraints",
) -> "Problem":
    from ccgen.placement import joint_problem

    if objective is None:
        objective = Objective.NOISE if joint.method == "noise-aware" else Objective.PAPER
    with_noise = objective is Objective.NOISE
    if axis is None and with_noise:
        _refuse_different_axes(joint)
    chosen = axis or Axis.U
    count = len(joint.axis(chosen).spans) if sensors is None else sensors
    return joint_problem(joint, chosen, count, constraints, with_noise)


def _refuse_different_axes(joint: "Joint") -> None:
    noises = {(sensor.transducer.noise, sensor.radius) for sensor in (joint.u, joint.v)}
    if len(noises) > 1:
        raise InputError(
            f"--axis: the axes of {joint.source} differ in noise or radius, and so does the best"
            " placement; give --axis u, then --axis v"
        )


def _find(
    problem: "Problem",
    method: PlacementMethod | None,
    evolution: "Evolution",
    searching: Any,
) -> "list[Placement]":
    """Placements by one method, or by each that can keep to the constraints."""
    from ccgen.placement import METHODS
    from ccgen.placement import place as place_by

    if method is not None:
        return [place_by(problem, method, evolution, searching)]
    found = []
    for name in METHODS:
        if (name == "single") != (problem.sensors == 1):
            continue
        try:
            found.append(place_by(problem, name, evolution, searching))
        except InputError as error:
            if name == "search":
                raise
            note(str(error))
    return found


def _describe(
    joint: "Joint", axis: Axis | None, problem: "Problem", placement: "Placement"
) -> dict[str, Any]:
    from ccgen.estimation import score_percent_rom, score_with_noise_percent_rom

    weights = problem.weights(placement.spans)
    sensor = joint.axis(axis or Axis.U)
    noise, expected = sensor.transducer.noise, None
    if noise is not None:
        sigma = [noise / sensor.radius / (b - a + 1) for a, b in placement.spans]
        expected = score_with_noise_percent_rom(weights, problem.score, sigma)
    return {
        "method": placement.method,
        "spans": [list(span) for span in placement.spans],
        "score_percent_rom": score_percent_rom(weights, problem.score),
        "score_with_noise_percent_rom": expected,
        "evaluations": placement.evaluations,
        "optimality": placement.optimality,
        "gap": placement.gap,
    }


def _print(problem: "Problem", described: list[dict[str, Any]]) -> None:
    from rich.table import Table

    estimator = "noise-aware" if problem.noise else "WAM"
    table = Table(title=f"{problem.sensors} sensors, {estimator}; error in % of ROM")
    table.add_column("method", no_wrap=True)
    table.add_column("spans")
    for title in ("error", "with noise", "optimality", "evaluations"):
        table.add_column(title, justify="right")
    for row in described:
        expected = row["score_with_noise_percent_rom"]
        gap = f" ({100 * row['gap']:.0f} % gap)" if row["optimality"] == "bound" else ""
        table.add_row(
            row["method"],
            " ".join(f"{first}-{last}" for first, last in row["spans"]),
            f"{row['score_percent_rom']:.5g}",
            "not known" if expected is None else f"{expected:.4g}",
            row["optimality"] + gap,
            str(row["evaluations"]),
        )
    results().print(table)


def _segments(text: str) -> tuple[int, ...]:
    """Segments of a list such as "3,7-9"."""
    found: set[int] = set()
    for item in filter(None, (part.strip() for part in text.split(","))):
        first, dash, last = item.partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise InputError(f"--forbid: {item!r} is no segment; give a list such as 3,7-9")
        found.update(range(int(first), int(last or first) + 1))
    return tuple(sorted(found))


def _span(text: str) -> "Span":
    first, _, last = text.partition("-")
    if not first.isdecimal() or not last.isdecimal():
        raise InputError(f"--fix: {text!r} is no span; give its first and last segment, as in 0-4")
    return int(first), int(last)
