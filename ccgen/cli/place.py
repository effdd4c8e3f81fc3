"""`ccgen place`: where to put the sensors."""

from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Axis, Generations, Individuals
from ccgen.cli.output import note, progress_bars
from ccgen.cli.plot import write_plot
from ccgen.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ccgen.cli.place_output import Placed
    from ccgen.joint import Joint
    from ccgen.joint.layouts import Span
    from ccgen.placement import Constraints, Evolution, Placement, Problem, Search


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
    from ccgen.cli.place_output import figure, show, show_json
    from ccgen.joint.file import read_joint
    from ccgen.placement import Constraints, Evolution, Search

    joint = read_joint(joint_file)
    constraints = Constraints(
        shortest=shortest,
        longest=longest,
        forbidden=_segments(forbidden),
        fixed=tuple(_span(text) for text in fixed or ()),
        stacked=stacked,
    )
    evolution = Evolution(individuals=individuals, generations=generations, seed=seed)
    searching = Search(enumerated=enumerated, starts=starts, seed=seed)
    evolution.check()
    searching.check()
    problems = [
        (table, axes, _problem(joint, axes[0], sensors, objective, constraints))
        for table, axes in _tables(joint, axis)
    ]
    placed = _find(problems, method, evolution, searching)
    if plot is not None:
        write_plot(plot, lambda: figure(placed, constraints.forbidden))
    if json:
        show_json(joint, placed)
    else:
        show(joint, placed)


def _tables(joint: "Joint", axis: Axis | None) -> list[tuple[str, tuple[str, ...]]]:
    """The tables of the joint file that spans belong into, and the axes that each is for.

    Spans of [sensors] have no effect on an axis that has its own, and its own count, noise or
    radius make it a different question.
    """
    from ccgen.joint import AXES
    from ccgen.joint.places import has_own_table

    bending = tuple(one for one in AXES if one in joint.axes)
    if axis is None and not any(has_own_table(joint, one) for one in bending):
        return [("sensors", bending)]
    chosen = bending if axis is None else (str(axis),)
    return [(f"sensors.{one}", (one,)) for one in chosen]


def _problem(
    joint: "Joint",
    axis: str,
    sensors: int | None,
    objective: Objective | None,
    constraints: "Constraints",
) -> "Problem":
    from ccgen.joint.sensor_tables import MOST_SENSORS_OF_AXIS as MOST_SENSORS
    from ccgen.placement import check_placeable, joint_problem

    if sensors is not None and not 1 <= sensors <= MOST_SENSORS:
        raise InputError(
            f"--sensors: {sensors} sensors on an axis; a joint file takes 1 to {MOST_SENSORS}"
        )
    if objective is None:
        objective = Objective.NOISE if joint.method == "noise-aware" else Objective.PAPER
    check_placeable(joint, axis)
    count = len(joint.axis(axis).spans) if sensors is None else sensors
    return joint_problem(joint, axis, count, constraints, objective is Objective.NOISE)


def _find(
    problems: "Sequence[tuple[str, tuple[str, ...], Problem]]",
    method: PlacementMethod | None,
    evolution: "Evolution",
    searching: "Search",
) -> "list[Placed]":
    """Placements for each table; what two of them ask alike is answered once."""
    from ccgen.cli.place_output import Placed

    answers: dict[tuple[int, float], list[Placement]] = {}
    messages: list[str] = []
    with progress_bars() as report:
        for _, axes, problem in problems:
            asked = (problem.sensors, problem.noise)
            name = f"{axes[0]}: " if len(problems) > 1 else ""
            if asked not in answers:
                ask = partial(_place, problem, evolution, searching, report, name)
                try:
                    answers[asked], refused = _compare(ask, problem.sensors, method)
                except InputError as error:
                    raise InputError(f"{name}{error}") from error
                messages += [f"{name}{error}" for error in refused]
    for message in messages:
        note(message)
    return [
        Placed(table, axes, problem, answers[problem.sensors, problem.noise])
        for table, axes, problem in problems
    ]


def _place(
    problem: "Problem",
    evolution: "Evolution",
    searching: "Search",
    report: "Callable[[str, int, int], None]",
    name: str,
    method: str,
) -> "Placement":
    from ccgen.placement import place as place_by

    return place_by(problem, method, evolution, searching, partial(report, name + method))


def _compare(
    ask: "Callable[[str], Placement]", sensors: int, method: PlacementMethod | None
) -> "tuple[list[Placement], list[InputError]]":
    """Placements by one method, or by each that finds one; and the errors of the others.

    Raises:
        InputError: by no method.
    """
    from ccgen.placement import METHODS

    if method is not None:
        return [ask(method)], []
    found, refused = [], []
    for name in METHODS:
        if name == "single" and sensors != 1:
            continue
        try:
            found.append(ask(name))
        except InputError as error:
            refused.append(error)
    if not found:
        # The search's, which alone may know that there is none.
        raise refused[-1]
    return found, refused


def _segments(text: str) -> tuple[int, ...]:
    """Segments of a list such as "3,7-9"."""
    from ccgen.joint.tables import MOST_SEGMENTS

    found: set[int] = set()
    for item in filter(None, (part.strip() for part in text.split(","))):
        first, dash, last = item.partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise InputError(f"--forbid: {item!r} is no segment; give a list such as 3,7-9")
        segments = range(int(first), int(last or first) + 1)
        if not segments:
            raise InputError(f"--forbid: {item!r} is reversed; write {last}-{first}")
        # As many as no joint has are enough to be refused.
        found.update(segments[: MOST_SEGMENTS + 1])
    return tuple(sorted(found))


def _span(text: str) -> "Span":
    first, _, last = text.partition("-")
    if not first.isdecimal() or not last.isdecimal():
        raise InputError(f"--fix: {text!r} is no span; give its first and last segment, as in 0-4")
    return int(first), int(last)
