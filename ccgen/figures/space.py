"""One shape under loads, in three dimensions."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ccgen.figures.curves import POINTS_PER_SEGMENT, space_curve
from ccgen.figures.sensors import draw_across, draw_along
from ccgen.figures.style import number_segments, styled
from ccgen.joint import Joint
from ccgen.joint.loads import StatedLoads
from ccgen.sensing.simulation import segment_lengths

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ccgen.sensing.simulation import Simulation

Floats = NDArray[np.float64]

_FORCE = {"color": "#D55E00", "linewidth": 1.4, "label": "force"}
_SPREAD = {"color": "#0072B2", "linewidth": 0.8, "label": "force along the joint"}
_LONGEST_ARROW = 0.3
"""Of the joint's length."""
_SPREAD_ARROWS = 6
_NARROWEST_BOX = 0.7
"""Of the joint's length."""


@styled
def loads_figure(joint: Joint, simulation: "Simulation", loads: StatedLoads) -> "Figure":
    """Draw the neutral axis with the forces on it, and the angles of the segments.

    Arrows of forces are to one scale, those of the force along the joint to one of their own. Below
    stand the sensors: across the joint, and along it.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 6.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[3, 2], height_ratios=[5, 3])
    _draw_space(figure.add_subplot(grid[0, 0], projection="3d"), joint, simulation, loads)
    draw_across(figure.add_subplot(grid[1, 0]), joint)
    draw_along(figure.add_subplot(grid[1, 1]), joint)
    profile = figure.add_subplot(grid[0, 1])
    for axis, colour in (("u", "#009E73"), ("v", "#CC79A7")):
        angles = np.degrees(getattr(simulation, axis))
        profile.stairs(angles, baseline=None, color=colour, linewidth=1.6, label=axis)
    profile.set(title="Segment angles", xlabel="segment", ylabel="degrees")
    number_segments(profile.xaxis, joint.geometry.segments)
    profile.legend()
    return figure


def _draw_space(axes: Any, joint: Joint, simulation: "Simulation", loads: StatedLoads) -> None:
    lengths = segment_lengths(joint, simulation.h)
    curve = space_curve(simulation.u, simulation.v, lengths)
    axes.plot(*curve.T, color="#000000", linewidth=2.0)
    axes.plot(*curve[::POINTS_PER_SEGMENT].T, "k.")
    length = joint.geometry.length
    axes.plot([0, 0], [0, 0], [0, lengths.sum()], color="#000000", linestyle=":", linewidth=0.8)
    # Places along the joint are told without elongation, which stretches each section evenly.
    share = np.linspace(0.0, 1.0, len(curve))
    points = [(contact.at / length, contact.force) for contact in loads.contacts]
    _arrows(axes, curve, share, [*points, (1.0, loads.tip_force)], length, _FORCE)
    along = [(s, loads.distributed) for s in (np.arange(_SPREAD_ARROWS) + 0.5) / _SPREAD_ARROWS]
    _arrows(axes, curve, share, along, length, _SPREAD)
    axes.set(title=f"{joint.name} under loads", xlabel="x / m", ylabel="y / m", zlabel="z / m")
    to_scale(axes, _NARROWEST_BOX * length, zoom=0.9)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left")


def to_scale(axes: Any, narrowest: float, zoom: float) -> None:
    """One scale for all three coordinates, in a box that is never too narrow for its numbers.

    Args:
        axes: three-dimensional, with everything drawn.
        narrowest: least side of the box, metres.
        zoom: of the box in its place.
    """
    from matplotlib.ticker import MaxNLocator

    limits = [getattr(axes, f"get_{axis}lim")() for axis in "xyz"]
    sides = [max(high - low, narrowest) for low, high in limits]
    for axis, (low, high), side in zip("xyz", limits, sides, strict=True):
        middle = (low + high) / 2
        getattr(axes, f"set_{axis}lim")(middle - side / 2, middle + side / 2)
        getattr(axes, f"{axis}axis").set_major_locator(MaxNLocator(4))
    axes.set_box_aspect(sides, zoom=zoom)


def _arrows(
    axes: Any,
    curve: Floats,
    share: Floats,
    forces: list[tuple[float, tuple[float, float, float]]],
    length: float,
    style: dict[str, Any],
) -> None:
    """Arrows that end where the forces act."""
    acting = [(at, np.array(force)) for at, force in forces if np.any(force)]
    if not acting:
        return
    places = np.array([[np.interp(at, share, x) for x in curve.T] for at, _ in acting])
    arrows = np.array([force for _, force in acting])
    arrows *= _LONGEST_ARROW * length / np.linalg.norm(arrows, axis=1).max()
    axes.quiver(*(places - arrows).T, *arrows.T, arrow_length_ratio=0.2, **style)
