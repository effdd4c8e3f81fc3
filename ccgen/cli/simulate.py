"""`ccgen simulate`: one shape of a joint, its sensors' lengths and counts."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.choices import Axis, Case
from ccgen.cli.output import note, print_json, show_table
from ccgen.cli.plot import write_plot
from ccgen.errors import InputError, ReachError

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.sensing.simulation import Simulation

_STEEPEST = 90.0


def simulate(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    case: Annotated[Case, typer.Option("--case", help="The load case.")],
    first_segment: Annotated[
        float,
        typer.Option("--first-segment", metavar="DEG", help="Angle of the first segment, degrees."),
    ],
    axis: Annotated[Axis, typer.Option("--axis", help="The axis that bends.")] = Axis.U,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the shape: .svg or .png.")
    ] = None,
) -> None:
    """Show one shape of a joint: segment angles, sensor lengths and counts, tip pose.

    \b
    Example:
      ccgen simulate shoulder.toml --case end-force --first-segment 2.5 --plot shape.svg
    """
    from ccgen.joint.file import read_joint

    joint = read_joint(joint_file)
    simulation = _simulation(joint, case, first_segment, axis)
    _warn(joint, simulation, first_segment)
    if plot is not None:
        from ccgen.figures.shape import shape_figure

        write_plot(plot, lambda: shape_figure(joint, simulation, axis))
    if json:
        print_json(_as_json(simulation))
    else:
        _print(joint, simulation)


def _simulation(joint: "Joint", case: str, degrees: float, axis: str) -> "Simulation":
    from ccgen.sensing import simulation

    if not abs(degrees) <= _STEEPEST:
        raise InputError(
            f"--first-segment: {degrees:g} is no angle of a segment; "
            f"give degrees from {-_STEEPEST:g} to {_STEEPEST:g}"
        )
    try:
        return simulation.simulate(joint, case, math.radians(degrees), axis)
    except ReachError as error:
        raise ReachError(f"--first-segment: {error}") from error


def _warn(joint: "Joint", simulation: "Simulation", degrees: float) -> None:
    limit = math.degrees(joint.geometry.range_of_motion)
    if abs(degrees) > limit * (1 + 1e-12):
        note(f"{degrees:g} degrees is beyond the range of motion of {limit:.6g}")
    for axis, sensed in (("u", simulation.u), ("v", simulation.v)):
        for j in sensed.out_of_range:
            note(f"{axis} sensor {j}: its transducer cannot give a count of {sensed.counts[j]}")


def _as_json(simulation: "Simulation") -> dict[str, Any]:
    import numpy as np

    axes = {"u": simulation.u, "v": simulation.v}
    return {
        "segment_angles_deg": {a: np.degrees(s.angles).tolist() for a, s in axes.items()},
        "sensor_lengths_m": {a: s.lengths.tolist() for a, s in axes.items()},
        "sensor_counts": {a: s.counts.tolist() for a, s in axes.items()},
        "tip_pose": simulation.tip_pose.tolist(),
    }


def _print(joint: "Joint", simulation: "Simulation") -> None:
    from rich.table import Table

    segments = Table("segment", "u / deg", "v / deg", title="Segment angles")
    for i, (u, v) in enumerate(zip(simulation.u.angles, simulation.v.angles, strict=True)):
        segments.add_row(str(i), f"{math.degrees(u):.6f}", f"{math.degrees(v):.6f}")
    sensors = Table("sensor", "segments", "length / m", "count", title="Sensors")
    for axis, sensed in (("u", simulation.u), ("v", simulation.v)):
        for j, (a, b) in enumerate(joint.axis(axis).spans):
            sensors.add_row(
                f"{axis}{j}", f"{a} to {b}", f"{sensed.lengths[j]:.9f}", str(sensed.counts[j])
            )
    pose = Table(*("x", "y", "z", "position / m"), title="Tip pose in the base frame")
    for row in simulation.tip_pose[:3]:
        pose.add_row(*(f"{value:.9f}" for value in row))
    for table in (segments, sensors, pose):
        for column in table.columns:
            column.justify = "right"
        show_table(table)
