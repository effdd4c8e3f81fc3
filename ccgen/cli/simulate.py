"""`ccgen simulate`: one shape of a joint, its sensors' lengths and counts."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Axis, Case
from ccgen.cli.output import note, print_json
from ccgen.cli.plot import write_plot
from ccgen.cli.simulate_output import as_json, print_tables
from ccgen.errors import InputError, ReachError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ccgen.joint import Joint
    from ccgen.sensing.simulation import Simulation

_STEEPEST = 90.0
_ROUNDING = 1 + 1e-12


def simulate(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    case: Annotated[Case | None, typer.Option("--case", help="The load case.")] = None,
    first_segment: Annotated[
        float | None,
        typer.Option("--first-segment", metavar="DEG", help="Angle of the first segment, degrees."),
    ] = None,
    axis: Annotated[
        Axis | None, typer.Option("--axis", help="The axis that bends; u by default.")
    ] = None,
    loads: Annotated[
        Path | None,
        typer.Option("--loads", metavar="FILE", help="Loads on the joint, instead of a load case."),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the shape: .svg or .png.")
    ] = None,
) -> None:
    """Show one shape of a joint: segment angles, sensor lengths and counts, tip pose.

    The joint bends under a load case in one axis, or under the loads that a TOML file states:
    stiffness (N m^2), stiffness_profile, actuation_u and actuation_v (degrees), tip_force (N),
    tip_moment (N m), distributed (N/m), contacts, elongation; in the base frame, z along the
    unbent axis.

    \b
    Examples:
      ccgen simulate shoulder.toml --case end-force --first-segment 2.5 --plot shape.svg
      ccgen simulate shoulder.toml --loads push.toml --plot shape.svg
    """
    from ccgen.joint.file import read_joint

    joint = read_joint(joint_file)
    if loads is not None:
        _refuse({"--case": case, "--first-segment": first_segment, "--axis": axis})
        simulation, draw = _under_loads(joint, loads)
    else:
        simulation, draw = _under_case(joint, case, first_segment, axis)
    for j in simulation.out_of_range:
        name, count = joint.sensors[j].name, simulation.counts[j]
        note(f"sensor {name}: its transducer cannot give a count of {count}")
    if plot is not None:
        write_plot(plot, draw)
    if json:
        print_json(as_json(joint, simulation))
    else:
        print_tables(joint, simulation)


def _refuse(options: dict[str, object]) -> None:
    """Refuse options of a load case beside --loads."""
    for option, value in options.items():
        if value is not None:
            raise InputError(f"{option}: belongs to a load case; give it or --loads, not both")


def _under_case(
    joint: "Joint", case: str | None, degrees: float | None, axis: str | None
) -> "tuple[Simulation, Callable[[], Figure]]":
    from ccgen.sensing.simulation import simulate as simulated

    if case is None or degrees is None:
        missing = "--case" if case is None else "--first-segment"
        raise InputError(f"{missing}: missing; give --case with --first-segment, or --loads FILE")
    bent = axis or (Axis.U if "u" in joint.axes else Axis.V)
    if not abs(degrees) <= _STEEPEST:
        raise InputError(
            f"--first-segment: {degrees:g} is no angle of a segment; "
            f"give degrees from {-_STEEPEST:g} to {_STEEPEST:g}"
        )
    try:
        simulation = simulated(joint, case, math.radians(degrees), bent)
    except ReachError as error:
        raise ReachError(f"--first-segment: {error}") from error
    limit = math.degrees(joint.geometry.range_of_motion)
    if abs(degrees) > limit * _ROUNDING:
        note(f"{degrees:g} degrees is beyond the range of motion of {limit:.6g}")

    def draw() -> "Figure":
        from ccgen.figures.shape import shape_figure

        return shape_figure(joint, simulation, bent)

    return simulation, draw


def _under_loads(joint: "Joint", path: Path) -> "tuple[Simulation, Callable[[], Figure]]":
    from ccgen.joint.load_files import read_loads
    from ccgen.sensing.simulation import simulate_loads

    loads = read_loads(path, joint.geometry)
    simulation = simulate_loads(joint, loads)
    limit = math.degrees(joint.geometry.range_of_motion)
    for axis, angles in (("u", simulation.u), ("v", simulation.v)):
        steepest = int(abs(angles).argmax())
        degrees = math.degrees(angles[steepest])
        if abs(degrees) > limit * _ROUNDING:
            note(
                f"segment {steepest} bends by {degrees:.3g} degrees in {axis}, beyond the range of "
                f"motion of {limit:.6g}"
            )

    def draw() -> "Figure":
        from ccgen.figures.space import loads_figure

        return loads_figure(joint, simulation, loads)

    return simulation, draw
