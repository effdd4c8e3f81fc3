"""`ccgen simulate`: one shape of a joint, its sensors' lengths and counts."""

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.choices import Axis, Case
from ccgen.cli.output import note, print_json, warn
from ccgen.cli.plot import write_plot
from ccgen.cli.simulate_output import as_json, print_tables
from ccgen.cli.viewing import NoBrowser, View, ViewPort, check_view
from ccgen.errors import InputError, ReachError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ccgen.joint import Joint
    from ccgen.sensing.bending import Bending
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
    view: View = False,
    view_port: ViewPort = None,
    no_browser: NoBrowser = False,
) -> None:
    """Show one shape of a joint: segment angles, sensor lengths and counts, tip pose.

    The joint bends under a load case in one axis, or under the loads that a TOML file states:
    stiffness (N m^2), stiffness_profile, actuation_u and actuation_v (degrees), tip_force (N),
    tip_moment (N m), distributed (N/m), contacts, elongation; in the base frame, z along the
    unbent axis.

    --view bends the joint there and back in a browser, beside what its sensors and the joint file's
    method make of it, until the page is closed.

    \b
    Examples:
      ccgen simulate shoulder.toml --case end-force --first-segment 2.5 --plot shape.svg
      ccgen simulate shoulder.toml --loads push.toml --plot shape.svg
      ccgen simulate shoulder.toml --case s-shape --first-segment 2 --view
    """
    from ccgen.joint.file import read_joint
    from ccgen.joint.units import unit_doubts

    check_view(view, view_port, no_browser)
    joint = read_joint(joint_file)
    warn(unit_doubts(joint))
    bending = _bending(joint, case, first_segment, axis, loads)
    simulation, draw = _simulated(joint, bending)
    _note_what_is_beyond(joint, simulation, first_segment)
    for j in simulation.out_of_range:
        name, count = joint.sensors[j].name, simulation.counts[j]
        note(f"sensor {name}: its transducer cannot give a count of {count}")
    if plot is not None:
        write_plot(plot, draw)
    if json:
        print_json(as_json(joint, simulation))
    else:
        print_tables(joint, simulation)
    if view:
        from ccgen.cli.simulate_view import show_bending

        sys.stdout.flush()
        show_bending(joint, bending, view_port, no_browser)


def _bending(
    joint: "Joint", case: str | None, degrees: float | None, axis: str | None, path: Path | None
) -> "Bending":
    from ccgen.joint.load_files import read_loads
    from ccgen.sensing.bending import Bending

    if degrees is not None and not abs(degrees) <= _STEEPEST:
        raise InputError(
            f"--first-segment: {degrees:g} is no angle of a segment; "
            f"give degrees from {-_STEEPEST:g} to {_STEEPEST:g}"
        )
    radians = None if degrees is None else math.radians(degrees)
    loads = None if path is None else read_loads(path, joint.geometry)
    return Bending(case, radians, axis, loads)


def _simulated(joint: "Joint", bending: "Bending") -> "tuple[Simulation, Callable[[], Figure]]":
    """The shape, and what draws it."""
    loads = bending.loads
    try:
        simulation = bending.at(joint)
    except ReachError as error:
        raise (error if loads else ReachError(f"--first-segment: {error}")) from error

    def draw() -> "Figure":
        from ccgen.figures.shape import shape_figure
        from ccgen.figures.space import loads_figure

        if loads is not None:
            return loads_figure(joint, simulation, loads)
        return shape_figure(joint, simulation, bending.axis or joint.axes[0])

    return simulation, draw


def _note_what_is_beyond(
    joint: "Joint", simulation: "Simulation", first_segment: float | None
) -> None:
    """Say where a shape leaves the range of motion, asked for so or bent so by loads."""
    limit = math.degrees(joint.geometry.range_of_motion)
    if first_segment is not None:
        if abs(first_segment) > limit * _ROUNDING:
            note(f"{first_segment:g} degrees is beyond the range of motion of {limit:.6g}")
        return
    for axis, angles in (("u", simulation.u), ("v", simulation.v)):
        steepest = int(abs(angles).argmax())
        degrees = math.degrees(angles[steepest])
        if abs(degrees) > limit * _ROUNDING:
            note(
                f"segment {steepest} bends by {degrees:.3g} degrees in {axis}, beyond the range of "
                f"motion of {limit:.6g}"
            )
