"""`ccgen verify`: proof that an exported folder computes what the model computes."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Level, Optimise
from ccgen.cli.output import note, print_json, progress_bars, results, show_table
from ccgen.errors import ToolError

if TYPE_CHECKING:
    from ccgen.verify.run import Run


TITLES = "snapshots", "degraded", "a second", "angles", "poses", "wrong", "lost", "pose / µm"


def verify(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder that `ccgen export` wrote.")
    ],
    target: Annotated[
        list[str] | None,
        typer.Option(
            "--target",
            metavar="NAME",
            help="host, cortex-m0, cortex-m3, cortex-m4, cortex-m7, riscv32, avr, or all; may be "
            "repeated.  [default: host]",
        ),
    ] = None,
    snapshots: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            help="Over each bus.  [default: 1000 over an emulated UART; otherwise for a million "
            "angles, at least 20000]",
        ),
    ] = None,
    values: Annotated[
        int, typer.Option(min=1, help="Angles compared in batches, besides.", metavar="N")
    ] = 1_000_000,
    optimise: Optimise = Level.O2,
    seed: Annotated[int, typer.Option(min=0, help="Of the random counts.", metavar="N")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Compile a folder, stream counts to it over CAN and compare every angle and pose bit for bit.

    On the host it runs as a shared library on python-can's virtual bus and as a process of its own
    over SLCAN on a pseudo-terminal; microcontrollers run in an emulator and speak SLCAN over their
    UART. Counts cover the shapes, the corners and the whole declared range. Angles, poses in
    integers and TIP frames are compared with their integer models, poses in floating point with
    double precision (none where joint.toml says float = false). A mismatch, a lost frame or a pose
    out of bounds ends with status 1.

    \b
    Example:
      ccgen verify firmware/shoulder
      ccgen verify firmware/shoulder --target cortex-m0 --target cortex-m4 --optimise s
    """
    from ccgen.can.transports.terminal import has_terminals
    from ccgen.export.manifest import changed_files
    from ccgen.verify.target import verify as verified

    for file in changed_files(directory):
        note(f"warning: {directory / file} differs from what was exported; export again to undo")
    names = _names(target or ["host"])
    if "host" in names and not has_terminals():
        note("left out: host, slcan-pty: it needs a pseudo-terminal, which this system has not")
    runs: list[Run] = []
    try:
        with progress_bars() as report:
            for name in names:
                runs += verified(directory, name, snapshots, values, optimise, seed, report).runs
    except ToolError:
        if runs and not json:
            _show(runs)
        raise
    if json:
        print_json({"runs": [run.record() for run in runs]})
    else:
        _show(runs)
    if not all(run.passed for run in runs):
        raise typer.Exit(1)


def _names(targets: Sequence[str]) -> Sequence[str]:
    from ccgen.targets.cores import VERIFIED

    return VERIFIED if "all" in targets else targets


def _show(runs: Sequence["Run"]) -> None:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    table.add_column("target, transport", no_wrap=True)
    functions = ["functions"] if any(run.compared_functions for run in runs) else []
    for title in (*TITLES[:5], *functions, *TITLES[5:]):
        table.add_column(title, justify="right", no_wrap=True)
    for run in runs:
        table.add_row(
            f"{run.target}, {run.transport}",
            f"{run.snapshots:,}",
            f"{run.degraded_snapshots:,}",
            f"{run.rate_hz:,.0f}",
            f"{run.compared_values:,}",
            f"{run.compared_poses:,}",
            *(f"{run.compared_functions:,}" for _ in functions),
            f"{run.mismatches + run.pose_mismatches + run.function_mismatches:,}",
            f"{run.lost_frames:,}",
            _distance(run),
        )
    console = results()
    show_table(table)
    failed = [run for run in runs if not run.passed]
    for run in failed:
        reason = run.note or _said(run)
        console.print(f"FAILED: {run.target} over {run.transport}: {reason}")
    if not failed:
        whole = "angle, pose and result" if functions else "angle and pose"
        console.print(f"Every {whole} is the model's, bit for bit; no frame was lost.")


def _distance(run: "Run") -> str:
    if run.pose_max_error_m is None or run.pose_bound_m is None:
        return "no float"
    return f"{1e6 * run.pose_max_error_m:.2g} < {1e6 * run.pose_bound_m:.2g}"


def _said(run: "Run") -> str:
    counts = (
        (run.mismatches, "angles"),
        (run.pose_mismatches, "poses in integers"),
        (run.function_mismatches, "results of functions"),
    )
    wrong = " and ".join(f"{count:,} {what}" for count, what in counts if count)
    return f"{wrong} differ from the model's" if wrong else "does not compute what the model does"
