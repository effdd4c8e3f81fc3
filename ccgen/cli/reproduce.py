"""`ccgen reproduce`: the paper's tables and figures."""

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Generations, Individuals
from ccgen.cli.output import note, print_json, progress, show_table

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

    from ccgen.study.joints import StudyJoint

_SILENT_SECONDS = 10.0


def reproduce(
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="The folder to write to.")
    ],
    joints: Annotated[
        str | None,
        typer.Option(
            "--joints",
            metavar="LIST",
            help="Some of the 80 joints as SEGMENTS:DEGREES, such as 12:3,48:8.",
        ),
    ] = None,
    processes: Annotated[
        int | None,
        typer.Option("--processes", metavar="N", help="Processes.  [default: one a processor]"),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Use the workers of a Dask cluster."),
    ] = None,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Of the evolutionary algorithm and the search.")
    ] = 0,
    individuals: Individuals = 500,
    generations: Generations = 10,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Reproduce the paper: Tables 2 to 4, figures 7 and 8, and a report.

    An interrupted run resumes from the joints that are finished; they are kept in DIR/joints.

    \b
    Example:
      ccgen reproduce -o study
    """
    from ccgen.placement import Evolution, Search
    from ccgen.study.files import write_files
    from ccgen.study.joints import Settings, all_joints, chosen_joints
    from ccgen.study.run import Store, run_study

    start = time.monotonic()
    chosen = all_joints() if joints is None else chosen_joints(joints)
    usual = Settings()
    settings = Settings(
        Evolution(individuals=individuals, generations=generations, seed=seed),
        Search(usual.search.enumerated, usual.search.starts, seed),
    )
    settings.evolution.check()
    store = Store(output / "joints", settings)
    with _executor(processes, scheduler) as executor, _reporting(chosen) as finished:
        records = run_study(chosen, settings, store, executor, finished)
    table = write_files(output, records)
    seconds = time.monotonic() - start
    note(f"wrote {output}/report.html and the tables and figures beside it in {seconds:.1f} s")
    if json:
        print_json({**table, "seconds": round(seconds, 3)})
    else:
        _print(table)


def _executor(processes: int | None, scheduler: str | None) -> "AbstractContextManager[Executor]":
    from ccgen.errors import InputError
    from ccgen.study import spread

    if scheduler is None:
        return spread.on_processes(processes)
    if processes is not None:
        raise InputError("--processes: the cluster at --scheduler has its own; give one of the two")
    return spread.on_cluster(scheduler)


@contextmanager
def _reporting(joints: "Sequence[StudyJoint]") -> "Iterator[Callable[[StudyJoint, bool], None]]":
    """Give what reports a finished joint: a bar on a terminal, else a line now and then.

    Joints count by their segments, to which their time is about proportional.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    bar = Progress(
        TextColumn("{task.fields[joints]} of {task.fields[of]} joints"),
        BarColumn(),
        TextColumn("{task.fields[rate]}, remaining"),
        TimeRemainingColumn(),
        console=progress(),
        disable=not progress().is_terminal,
    )
    start = time.monotonic()
    total = sum(joint.segments for joint in joints)
    state = {"joints": 0, "resumed": 0, "segments": 0, "new": 0, "said": start}
    task = bar.add_task("", total=total, joints=0, of=len(joints), rate="starting")

    def finished(joint: "StudyJoint", before: bool) -> None:
        state["joints"] += 1
        state["segments"] += joint.segments
        state["resumed" if before else "new"] += 1 if before else joint.segments
        elapsed = max(time.monotonic() - start, 1e-9)
        rate = (state["joints"] - state["resumed"]) / elapsed
        left = (total - state["segments"]) * elapsed / max(state["new"], 1)
        text = f"{rate:.2f} joints/s"
        bar.update(task, advance=joint.segments, joints=state["joints"], rate=text)
        if bar.disable and not before and time.monotonic() - state["said"] > _SILENT_SECONDS:
            state["said"] = time.monotonic()
            note(f"{state['joints']} of {len(joints)} joints, {text}, {left:.0f} s remaining")

    with bar:
        yield finished
    if state["resumed"]:
        note(f"{state['resumed']} of {len(joints)} joints were finished before")


def _print(table: dict[str, Any]) -> None:
    from rich.table import Table

    from ccgen.study.tables import is_compared, not_compared

    joints = table["joints"]
    compared = is_compared(joints)
    over = "1 joint: error" if joints == 1 else f"{joints} joints: median error"
    shown = Table(
        title=f"{over}, % of range of motion", caption=None if compared else not_compared(joints)
    )
    titles = ("placement", "method", "sensors", "ours", "paper", *(["difference"] * compared))
    for title in titles:
        shown.add_column(title, justify="left" if title in ("placement", "method") else "right")
    for row in table["rows"] + table["extra_rows"]:
        paper, difference = row["paper"], row["relative_difference"]
        cells = (
            row["placement"],
            row["method"],
            str(row["sensors"]),
            f"{row['median']:.4g}",
            "" if paper is None else f"{paper['median']:.4g}",
            "" if difference is None else f"{100 * difference:+.1f} %",
        )
        shown.add_row(*cells[: len(titles)])
    show_table(shown)
