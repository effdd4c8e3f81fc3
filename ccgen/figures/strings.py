"""A bent joint with its sensors as strings, and the sensors unrolled."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ccgen.figures.curves import POINTS_PER_SEGMENT, frames_along, string_paths
from ccgen.figures.sensors import draw_across, draw_along
from ccgen.figures.space import to_scale
from ccgen.figures.style import Floats, styled
from ccgen.joint import Joint

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BEND = np.radians(70.0)
"""Of the whole joint in the picture, or its range of motion where that is less."""

_NARROWEST_BOX = 0.3
"""Of the joint's length."""

_ENTRIES, _ENTRY = 74.0, 9.0
"""Letters that a line of the legend has room for, and that an entry takes beside its name."""

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


@styled
def strings_figure(joint: Joint) -> "Figure":
    """Draw the joint bent about both axes, to scale, each sensor where it runs."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.6, 4.4), layout="constrained")
    axes: Any = figure.add_subplot(projection="3d")
    frames = _frames(joint)
    axes.plot(*frames[:, :3, 3].T, color="#000000", linewidth=1.6)
    axes.plot(*frames[::POINTS_PER_SEGMENT, :3, 3].T, "k.", markersize=4.0)
    paths = string_paths(joint, frames)
    for i, (sensor, path) in enumerate(zip(joint.sensors, paths, strict=True)):
        colour, over = _COLOURS[i % len(_COLOURS)], _over(joint, i)
        width, marks = 1.8 * (1 + over), [0, len(path) - 1]
        axes.plot(*path.T, color=colour, linewidth=width, marker="o", markersize=1.2 + width,
                  markevery=marks, zorder=3.0 - over, label=sensor.name)  # fmt: skip
    to_scale(axes, _NARROWEST_BOX * joint.geometry.length, zoom=0.85)
    axes.set(title=f"{joint.name} with its sensors", xlabel="x / m", ylabel="y / m", zlabel="z / m")
    axes.tick_params(labelsize=6.5)
    longest = max(len(sensor.name) for sensor in joint.sensors)
    columns = max(1, min(6, len(joint.sensors), int(_ENTRIES // (_ENTRY + longest))))
    figure.legend(loc="outside lower center", ncols=columns, fontsize=7.0)
    return figure


def _over(joint: Joint, i: int) -> int:
    """Sensors that run within the span of another at its place, and would hide it or be hidden."""
    own = joint.sensors[i]
    return sum(
        (other.angle, other.radius) == (own.angle, own.radius)
        and own.start <= other.start
        and other.end <= own.end
        and (other.end - other.start, -j) < (own.end - own.start, -i)
        for j, other in enumerate(joint.sensors)
    )


@styled
def unrolled_figure(joint: Joint) -> "Figure":
    """Draw the sensors across the joint and along it."""
    from matplotlib.figure import Figure

    height = 2.4 + 0.16 * len(joint.sensors)
    figure = Figure(figsize=(4.6, 2.2 + height), layout="constrained")
    across, along = figure.subplots(2, 1, height_ratios=[2.2, height])
    draw_across(across, joint)
    draw_along(along, joint)
    return figure


def _frames(joint: Joint) -> Floats:
    """Frames along the joint as it is bent in the picture."""
    geometry = joint.geometry
    whole = min(_BEND, geometry.segments * geometry.range_of_motion)
    bend = np.full(geometry.segments, whole / geometry.segments / np.sqrt(2.0))
    u = bend if "u" in joint.axes else np.zeros_like(bend)
    v = bend if "v" in joint.axes else np.zeros_like(bend)
    return frames_along(u, v, np.full_like(bend, geometry.segment_length))
