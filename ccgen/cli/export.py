"""`ccgen export`: the C for a joint's microcontroller."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.costs import note_left_out, show_costs
from ccgen.cli.output import note, print_json, progress_bars, results, show_table, warn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ccgen.cost.measure import Cost
    from ccgen.export.package import Export
    from ccgen.fixedpoint import AxisModel
    from ccgen.joint import Joint


def export(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="The folder to write.")
    ],
    cost: Annotated[
        bool,
        typer.Option(
            "--cost",
            help="Measure it for every target whose tools are installed, as `ccgen cost --write`.",
        ),
    ] = False,
    examples: Annotated[
        list[str] | None,
        typer.Option(
            "--example",
            metavar="KIND",
            help="Write a complete project as well, to DIR/examples/KIND: cmake, cortex-m, stm32, "
            "esp-idf, arduino, mcp2515, platformio or zephyr; may be repeated.",
        ),
    ] = None,
    functions: Annotated[
        Path | None,
        typer.Option(
            "--functions",
            metavar="FILE",
            help="A Python file of CasADi functions of the joint's angles u, v and elongation h, "
            "polynomials, to export in integers too; docs/polynomial.md tells more.",
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Write a folder with fixed-point C that stands alone: estimator, kinematics, CAN node, DBC.

    The folder appears whole or not at all; an older export in its place is replaced. The same
    input gives the same bytes, except for the table that --cost puts into README.md, which depends
    on the compilers.

    \b
    Example:
      ccgen export shoulder.toml -o firmware/shoulder
      ccgen verify firmware/shoulder --target host
      ccgen export shoulder.toml -o firmware/shoulder --example zephyr
    """
    from ccgen.can.load import load_percent
    from ccgen.cost.readme import has_table
    from ccgen.export.package import export as write
    from ccgen.joint.file import read_joint

    targets = _countable_targets() if cost else []
    table_is_lost = not cost and has_table(output)
    joint = read_joint(joint_file)
    warn(_said_before(joint))
    with progress_bars(lines=True) as report:
        done = write(joint, output, report, examples or (), functions)
    for text in done.notes:
        note(text)
    warn(done.doubts)
    load = load_percent(done.layout, done.joint.can.bitrate)
    if load > 100.0:
        note(_too_slow(done, load))
    if _meets_neighbour(done):
        note(_may_meet(done))
    if not done.layout.fd and not done.layout.has_turn:
        note(_without_turn(done))
    if table_is_lost:
        note(
            f"{output / 'README.md'}: the table of costs that was in it is gone, for it was "
            f"measured on what has been replaced; `ccgen cost {output} --write` measures again"
        )
    costs = _write_costs(output, targets) if targets else []
    if json:
        measured = {"targets": [one.record() for one in costs]} if costs else {}
        print_json(_record(done, load) | measured)
    else:
        _show(done, load, costs)


def _said_before(joint: "Joint") -> tuple[str, ...]:
    """Warnings that need not wait for what recordings tell, where they are to be learned from."""
    from ccgen.fixedpoint.beforehand import check_counts
    from ccgen.fixedpoint.kept import kept_fit

    kept = kept_fit(joint) if joint.recordings else None
    return check_counts(joint) if kept is None or kept.fit is None else ()


def _countable_targets() -> "Sequence[str]":
    from ccgen.cost.costs import choose

    choice = choose()
    note_left_out(choice.left_out)
    return choice.measured


def _write_costs(directory: Path, targets: "Sequence[str]") -> "Sequence[Cost]":
    from ccgen.cost.costs import cost as costed

    with progress_bars() as report:
        return costed(directory, targets, write=True, report=report).targets


def _record(done: "Export", load: float) -> dict[str, Any]:
    return {
        "directory": str(done.directory),
        "files": list(done.files),
        "fixed_point": {axis: _format(own) for axis, own in done.model.axes.items()},
        "bus_load_percent": load,
    }


def _format(axis: "AxisModel") -> dict[str, Any]:
    return {
        "fraction_bits": axis.fraction_bits,
        "shift": axis.shift,
        "headroom_bits": axis.headroom_bits,
        "saturates": axis.saturates,
        "worst_error_percent_rom": axis.worst_error_percent_rom,
        "rms_error_percent_rom": axis.rms_error_percent_rom,
    }


def _show(done: "Export", load: float, costs: "Sequence[Cost]") -> None:
    from rich.table import Table

    axes = done.model.axes
    table = Table("", *(f"axis {axis}" for axis in axes), box=None, pad_edge=False)
    for title, key, pattern in (
        ("fraction bits of an angle", "fraction_bits", "{}"),
        ("shift", "shift", "{}"),
        ("headroom, bits", "headroom_bits", "{}"),
        ("added by fixed point, at most", "worst_error_percent_rom", "{:.2g} % of {}"),
        ("  RMS over the shapes", "rms_error_percent_rom", "{:.2g} % of {}"),
    ):
        cells = (
            pattern.format(_format(own)[key], "length" if axis == "h" else "ROM")
            for axis, own in axes.items()
        )
        table.add_row(title, *cells)
    console = results()
    show_table(table)
    frames = done.layout.lengths_frames + done.layout.answer_frames
    console.print(
        f"{frames} frames every {done.layout.cycle_ms} ms take at most "
        f"{load:.0f} % of a bus at {done.joint.can.bitrate:,} bit/s"
    )
    if done.fallback_bytes:
        console.print(f"weights for each single missing sensor take {done.fallback_bytes:,} bytes")
    if costs:
        show_costs(costs)
    to_measure = "" if costs else f", ccgen cost {done.directory} --write"
    console.print(
        f"{len(done.files)} files in {done.directory}; README.md there tells how to use them. "
        f"Next: ccgen verify {done.directory}{to_measure}",
        soft_wrap=True,
    )


def _meets_neighbour(done: "Export") -> bool:
    """Whether HEALTH or COMMAND is where a neighbour may begin, who counts identifiers in sixteens.

    Joints were two identifiers shorter once.
    """
    return done.layout.last_id // 16 > (done.layout.last_id - 2) // 16


def _may_meet(done: "Export") -> str:
    last = done.layout.last_id
    return (
        f"{done.joint.source}: can.base_id: the joint's identifiers end at {last:#x}, HEALTH's "
        f"{last - 1:#x} and COMMAND's {last:#x} among them; a neighbour on the bus begins behind it"
    )


def _without_turn(done: "Export") -> str:
    layout = done.layout
    return (
        f"{done.joint.source}: can.turn = false: {layout.numbers} numbers tell snapshots apart, so "
        f"a snapshot's window has at most {layout.window_cycles} cycles, and no frame may arrive "
        f"{layout.latest_cycles} cycles after it was sent; with the turn, 100 and 120"
    )


def _too_slow(done: "Export", load: float) -> str:
    layout, can = done.layout, done.joint.can
    frames = layout.lengths_frames + layout.answer_frames
    shortest = math.ceil(layout.cycle_ms * load / 100.0)
    remedy = "bit-rate switching" if layout.fd else "can.fd = true"
    return (
        f"warning: {done.joint.source}: can.cycle_ms: the {frames} frames of a "
        f"snapshot need up to {load:.0f} % of {layout.cycle_ms} ms at {can.bitrate:,} bit/s; "
        f"{shortest} or more, a higher can.bitrate, or {remedy} would fit"
    )
