"""What `ccgen simulate` prints."""

import math
from typing import TYPE_CHECKING, Any

from ccgen.cli.output import show_table

if TYPE_CHECKING:
    from ccgen.joint import Joint, Sensor
    from ccgen.sensing.simulation import Simulation


def as_json(joint: "Joint", simulation: "Simulation") -> dict[str, Any]:
    """The JSON object of one shape."""
    import numpy as np

    return {
        "segment_angles_deg": {
            "u": np.degrees(simulation.u).tolist(),
            "v": np.degrees(simulation.v).tolist(),
        },
        "elongation": simulation.h.tolist(),
        "sensor_lengths_m": _by_sensor(joint, simulation.lengths.tolist()),
        "sensor_counts": _by_sensor(joint, simulation.counts.tolist()),
        "tip_pose": simulation.tip_pose.tolist(),
    }


def print_tables(joint: "Joint", simulation: "Simulation") -> None:
    """Print the shape and its sensors as tables."""
    from rich.table import Table

    segments = Table("segment", "u / deg", "v / deg", title="Segment angles")
    for i, (u, v) in enumerate(zip(simulation.u, simulation.v, strict=True)):
        segments.add_row(str(i), f"{math.degrees(u):.6f}", f"{math.degrees(v):.6f}")
    sections = Table("section", "elongation / %", title="Elongation")
    for i, share in enumerate(simulation.h):
        sections.add_row(str(i), f"{100 * share:.6f}")
    sensors = Table("sensor", "segments", "length / m", "count", title="Sensors")
    for sensor, length, count in zip(
        joint.sensors, simulation.lengths, simulation.counts, strict=True
    ):
        sensors.add_row(sensor.name, _covered(sensor), f"{length:.9f}", str(count))
    pose = Table(*("x", "y", "z", "position / m"), title="Tip pose in the base frame")
    for row in simulation.tip_pose[:3]:
        pose.add_row(*(f"{value:.9f}" for value in row))
    for table in (segments, sections, sensors, pose):
        for column in table.columns:
            column.justify = "right"
        if table is not sections or simulation.h.any():
            show_table(table)


def _by_sensor(joint: "Joint", values: list[float]) -> dict[str, Any]:
    """Values by axis where the joint has the paper's sets of sensors, else by sensor."""
    sets = {"u": joint.u, "v": joint.v}
    if any(sets.values()):
        return {axis: values[joint.members(axis)] if sets[axis] else [] for axis in sets}
    return {sensor.name: value for sensor, value in zip(joint.sensors, values, strict=True)}


def _covered(sensor: "Sensor") -> str:
    """Segments under a sensor; a border within one is told by its share."""
    if sensor.start.is_integer() and sensor.end.is_integer():
        return f"{sensor.start:g} to {sensor.end - 1:g}"
    return f"from {sensor.start:.4g} to {sensor.end:.4g}"
