"""One shape with its sensors."""

import math
from typing import TYPE_CHECKING

import numpy as np

from ccgen.figures.curves import POINTS_PER_SEGMENT, planar_curve
from ccgen.figures.sensors import draw_across, draw_along
from ccgen.figures.style import label_curve, new_figure, number_segments, styled
from ccgen.joint import Joint
from ccgen.sensing.readings import coverage, direction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ccgen.sensing.simulation import Simulation


@styled
def shape_figure(joint: Joint, simulation: "Simulation", axis: str = "u") -> "Figure":
    """Draw the bent axis of a simulated joint: its curve, its angles and the sensors' readings.

    Below stand the sensors: across the joint, and along it.
    """
    angles = simulation.u if axis == "u" else simulation.v
    figure, ((curve, profile), (across, along)) = new_figure((7.0, 6.4), 2, rows=2)
    deflection, height = planar_curve(angles, joint.geometry.segment_length)
    curve.plot(deflection, height, color="#000000")
    curve.plot(deflection[::POINTS_PER_SEGMENT], height[::POINTS_PER_SEGMENT], "k.")
    label_curve(curve, f"{joint.name}, bent in {axis}")
    profile.stairs(np.degrees(angles), baseline=None, color="#000000", label="segment angle")
    label: str | None = "sensor: mean over its span"
    for sensor, covered in zip(joint.sensors, coverage(joint), strict=True):
        if direction(sensor)[0 if axis == "u" else 1]:
            mean = math.degrees(covered @ angles / sensor.segments)
            profile.plot([sensor.start, sensor.end], [mean, mean], color="#D55E00", label=label)
            label = None
    profile.set(title="Angles", xlabel="segment", ylabel="degrees")
    number_segments(profile.xaxis, joint.geometry.segments)
    draw_across(across, joint)
    draw_along(along, joint)
    figure.legend(loc="outside lower center", ncols=2)
    return figure
