"""Figure 8: the case study, true and estimated joint under three loadings.

Twelve segments, 3 degrees of range, sensors on [0, 4] [3, 8] [7, 11]; DEM, which knows no overlap,
has its three sensors end to end. The paper does not state the joint's length.
"""

from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation import Weights, fit_weights
from ccgen.estimation.fit import Task, fit_task
from ccgen.estimation.fitted import FittedWeights
from ccgen.estimation.sources import simulated_sources
from ccgen.figures.case_study import case_study_figure
from ccgen.figures.curves import planar_curve
from ccgen.figures.style import Floats
from ccgen.joint import Joint
from ccgen.joint.file import parse_joint
from ccgen.joint.layouts import end_to_end
from ccgen.sensing.readings import readings
from ccgen.shapes import fit_library, single_shape
from ccgen.study.tables import to_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LENGTH = 0.24
"""Neutral axis, metres."""

CASES = ("end-force", "uniform", "s-shape")

_JOINT = f"""
name = "case_study"
[geometry]
segments = 12
length = {LENGTH}
range_of_motion = 3.0
[sensors]
spans = [[0, 4], [3, 8], [7, 11]]
radius = 0.05
[sensors.transducer]
bits = 16
metres_per_count = 2.0e-6
[estimator]
method = "wam"
"""


def case_study_joint() -> Joint:
    """The joint of figure 8."""
    return parse_joint(_JOINT, "figure 8")


def figure8() -> "Figure":
    """Draw the case study."""
    joint = case_study_joint()
    task = Task(joint, simulated_sources(joint))
    return case_study_figure(FittedWeights(joint, "wam", fit_task(task), task))


def figure8_csv() -> bytes:
    """The curves of the case study as CSV: one line for each point, metres."""
    joint = case_study_joint()
    estimators = _estimators(joint)
    lines: list[tuple[object, ...]] = []
    for case in CASES:
        angles = single_shape(12, case, joint.geometry.range_of_motion)
        lines += _lines(joint, case, "actual", angles)
        for method, weights in estimators.items():
            estimate = weights.estimate(readings(angles, weights.spans))
            lines += _lines(joint, case, method, estimate)
    header = ["loading", "curve", "along_m", "deflection_m", "height_m"]
    return to_csv(header, lines)


def _estimators(joint: Joint) -> dict[str, Weights]:
    library, spans = fit_library(joint), joint.axis("u").spans
    return {
        "DEM": fit_weights("direct", library, end_to_end(12, len(spans))),
        "E-WAM": fit_weights("equal", library, spans),
        "WAM": fit_weights("wam", library, spans),
    }


def _lines(joint: Joint, case: str, curve: str, angles: Floats) -> list[tuple[object, ...]]:
    deflection, height = planar_curve(angles, joint.geometry.segment_length)
    along = np.linspace(0.0, joint.geometry.length, len(height))
    points = np.column_stack([along, deflection, height]).tolist()
    return [(case, curve, *(f"{value:.9g}" for value in point)) for point in points]
