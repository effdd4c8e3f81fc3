"""Where a joint's sensors are: across the joint, and along it unrolled."""

import math
from typing import TYPE_CHECKING

import numpy as np

from ccgen.figures.style import number_segments
from ccgen.joint import Joint
from ccgen.sensing.arrangement import angle_degrees, unrolled
from ccgen.sensing.readings import direction

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TENDON = "#D55E00"
_JOINT = "#000000"


def draw_across(axes: "Axes", joint: Joint) -> None:
    """Draw the cross-section seen from the tip: each angle and radius at which sensors run."""
    largest = max(sensor.radius for sensor in joint.sensors)
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(largest * np.cos(around), largest * np.sin(around), color=_JOINT, linewidth=0.6)
    axes.plot([0.0], [0.0], "+", color=_JOINT)
    for angle, radius in sorted({(angle_degrees(s), s.radius) for s in joint.sensors}):
        sensor = next(s for s in joint.sensors if (angle_degrees(s), s.radius) == (angle, radius))
        sine, cosine = direction(sensor)
        axes.plot([radius * cosine], [radius * sine], "o", color=_TENDON)
        axes.annotate(
            f"{angle:.4g}°", (radius * cosine, radius * sine), textcoords="offset points",
            xytext=(12 * cosine, 12 * sine), ha="center", va="center", fontsize=7.0,
        )  # fmt: skip
    reach = 1.6 * largest
    axes.set(title="Sensors, seen from the tip", xlabel="x / m", ylabel="y / m", aspect="equal")
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))


def draw_along(axes: "Axes", joint: Joint) -> None:
    """Draw the span of each sensor along the joint, in the order of their angles."""
    rows = unrolled(joint)
    for row, sensor in enumerate(rows):
        axes.plot([sensor.start, sensor.end], [row, row], color=_TENDON, linewidth=3.0)
    borders = np.cumsum(joint.geometry.sections)[:-1]
    for border in borders:
        axes.axvline(float(border), color=_JOINT, linewidth=0.6, linestyle=":")
    labels = [f"{sensor.name}, {angle_degrees(sensor):.4g}°" for sensor in rows]
    axes.set_yticks(range(len(rows)), labels, fontsize=min(8.0, 90.0 / math.sqrt(len(rows)) / 4))
    axes.set(title="Sensors along the joint", xlabel="segment", xlim=(0.0, joint.geometry.segments))
    number_segments(axes.xaxis, joint.geometry.segments)
    axes.set_ylim(len(rows) - 0.5, -0.5)
