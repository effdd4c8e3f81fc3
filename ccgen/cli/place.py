"""`ccgen place`: where to put the sensors."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Axis, Generations, Individuals
from ccgen.cli.output import note, progress_bars, warn
from ccgen.cli.plot import write_plot
from ccgen.errors import InputError

if TYPE_CHECKING:
    from ccgen.joint.layouts import Span


class PlacementMethod(StrEnum):
    """`ccgen.placement.STATED` and `METHODS`."""

    STATED = "stated"
    SINGLE = "single"
    END_TO_END = "end-to-end"
    HEURISTIC = "heuristic"
    EVOLUTIONARY = "evolutionary"
    SEARCH = "search"


class Objective(StrEnum):
    """What a placement is judged by, `ccgen.placement.OBJECTIVES`."""

    PAPER = "paper"
    ANGLES = "angles"
    TIP = "tip"


def place(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    sensors: Annotated[
        int | None,
        typer.Option(
            "--sensors",
            metavar="N",
            help="Sensors per axis, for the sets of [sensors].  [default: as in the file]",
        ),
    ] = None,
    method: Annotated[
        PlacementMethod | None,
        typer.Option("--method", help="Only this one.  [default: all are compared]"),
    ] = None,
    axis: Annotated[
        Axis | None,
        typer.Option(
            "--axis", help="For one axis only, for the sets of [sensors].  [default: for both]"
        ),
    ] = None,
    objective: Annotated[
        Objective | None,
        typer.Option(
            "--objective",
            help="angles: expected error of a segment's angle by all that the file states: loads,"
            " noise, tolerances; tip: expected error of the tip; paper: error of WAM on the load"
            " cases, without noise.  [default: angles]",
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
        typer.Option(
            "--fix",
            metavar="A-B",
            help="A sensor of the sets that stays, by its span; may be repeated.",
        ),
    ] = None,
    staying: Annotated[
        list[str] | None,
        typer.Option(
            "--keep",
            metavar="NAME",
            help="A sensor of [[sensor]] that stays where it is; may be repeated.",
        ),
    ] = None,
    stacked: Annotated[
        int | None,
        typer.Option(
            "--max-stacked", metavar="N", help="Most sensors at one angle over a segment."
        ),
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

    Sensors of [[sensor]], and those of a joint that elongates, keep their angle, radius and
    transducer, and each has a span of its own.

    \b
    Example:
      ccgen place shoulder.toml --sensors 3 --plot spans.svg
    """
    from ccgen import placement
    from ccgen.cli.place_output import figure, show, show_json
    from ccgen.joint.file import load
    from ccgen.joint.units import unit_doubts

    joint = load(joint_file)
    warn(unit_doubts(joint))
    constraints = placement.Constraints(
        shortest=shortest,
        longest=longest,
        forbidden=_segments(forbidden),
        fixed=tuple(_span(text) for text in fixed or ()),
        stacked=stacked,
        staying=tuple(staying or ()),
    )
    evolution = placement.Evolution(individuals=individuals, generations=generations, seed=seed)
    search = placement.Search(enumerated=enumerated, starts=starts, seed=seed)
    with progress_bars() as report:
        placed = placement.place(
            joint, sensors, method, axis, objective, constraints, evolution, search, report
        )
    for one in placed:
        for reason in one.refused:
            note(reason)
    if plot is not None:
        write_plot(plot, lambda: figure(joint, placed, constraints.forbidden))
    if json:
        show_json(joint, placed)
    else:
        show(joint, placed)


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
