"""The paper's case study of the methods (figure 8)."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ccgen.errors import ReachError
from ccgen.estimation import direct, in_the_papers_way
from ccgen.estimation.fit import weights_of
from ccgen.estimation.fitted import FittedWeights
from ccgen.figures.along import draw_errors_along
from ccgen.figures.curves import planar_curve
from ccgen.figures.estimators import Estimator, own_estimator, spans_estimator
from ccgen.figures.style import label_curve, new_figure, styled, whole_row
from ccgen.joint import CASES, Joint
from ccgen.joint.layouts import end_to_end
from ccgen.placement.moved import moved
from ccgen.shapes import single_shape

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SMALLEST_DISTANCE = 1e-8  # of the joint's length; less is not drawn

_TITLES = {
    "end-force": "End force",
    "uniform": "Uniform load",
    "s-shape": "End force and moment",
    "constant-curvature": "Constant curvature",
}

# Colours of Okabe and Ito, told apart by readers with any colour vision.
_ACTUAL: dict[str, Any] = {"color": "#000000", "linewidth": 4.0, "alpha": 0.25}
_METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "direct": ("DEM (end to end)", {"color": "#E69F00", "linestyle": "-."}),
    "equal": ("E-WAM", {"color": "#0072B2", "linestyle": "--"}),
    "wam": ("WAM", {"color": "#D55E00", "linestyle": "-"}),
    "noise-aware": ("noise-aware", {"color": "#009E73", "linestyle": ":"}),
    "wam-paper-call": ("WAM, paper's call", {"color": "#CC79A7", "linestyle": ":"}),
}
_WITHOUT_NOISE: dict[str, Any] = {"linewidth": 0.6, "alpha": 0.6}
"""How distances without noise are drawn beside those with it."""


@styled
def case_study_figure(fit: FittedWeights, axis: str | None = None, along: bool = False) -> "Figure":
    """Draw actual and estimated curves of an axis under the joint's load cases (figure 8).

    Below each curve stands how far the estimates lie from it; where the joint states noise, as a
    root mean square with it, and thinner without. The joint is bent as far as its range of motion
    allows; all methods are fitted to what the fit was.

    Args:
        fit: its method is drawn beside DEM, E-WAM and WAM.
        axis: "u" or "v"; the first that is estimated by default.
        along: whether the error along the joint follows, by the shapes that it is met on.

    Raises:
        InputError: a method that cannot use the joint's sensors.
    """
    joint, cases = fit.sensed, _cases(fit.joint)
    estimators = dict(methods(fit, axis or joint.axes[0]))
    size = (2.6 * len(cases) + 0.6, 9.0 if along else 6.0)
    figure, (curves, errors, *rest) = new_figure(size, len(cases), rows=3 if along else 2)
    for row in rest:
        draw_errors_along(fit, whole_row(figure, row))
    for case, curve, error in zip(cases, curves, errors, strict=True):
        _draw_case(joint, case, estimators, curve, error)
    largest = max(error.get_ylim()[1] for error in errors)
    for error in errors:
        error.set_ylim(_SMALLEST_DISTANCE * joint.geometry.length, largest)
    curves[0].set_ylabel("height / m")
    errors[0].set_ylabel("distance from actual / m")
    handles, labels = curves[0].get_legend_handles_labels()
    noisy = any(estimator.noise is not None for estimator in estimators.values())
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=len(labels),
        title=_told(joint) if noisy else None,
    )
    return figure


def _told(joint: Joint) -> str:
    """What distances are told with."""
    parts = ["sensor noise", "the step of the counts"]
    if any(sensor.gain_tolerance for sensor in joint.sensors):
        parts.insert(1, "the gains' tolerance")
    return f"distances: RMS with {', '.join(parts[:-1])} and {parts[-1]}; thin: without them"


def _cases(joint: Joint) -> list[str]:
    """Cases to draw: the joint's, or those that it reaches; bent evenly only where no other is."""
    cases = [case for case in joint.shapes.cases or CASES if case != "constant-curvature"]
    if not joint.shapes.cases:
        cases = [case for case in cases if _reached(joint, case)]
    return cases or ["constant-curvature"]


def _reached(joint: Joint, case: str) -> bool:
    try:
        single_shape(joint.geometry.segments, case, joint.geometry.range_of_motion)
    except ReachError:
        return False
    return True


def methods(fit: FittedWeights, axis: str) -> Iterator[tuple[str, Estimator]]:
    """Methods by name, each with what it makes of shapes of an axis."""
    joint, papers_way = fit.sensed, in_the_papers_way(fit.joint)
    for name in dict.fromkeys(("direct", "equal", "wam", fit.method)):
        if name == "direct" and papers_way:
            yield from _end_to_end(joint, axis)
        elif name == fit.method:
            yield name, own_estimator(joint, axis, fit.weights[axis], fit.task.noise)
        elif name != "direct":
            weights = weights_of(fit.whole.quick, axis, name)
            yield name, own_estimator(joint, axis, weights, fit.task.noise)


def _end_to_end(joint: Joint, axis: str) -> Iterator[tuple[str, Estimator]]:
    """DEM, which knows no overlap: as many sensors, end to end; nothing where they do not fit."""
    segments, count = joint.geometry.segments, len(joint.axis(axis).spans)
    if count <= segments:
        spans = end_to_end(segments, count)
        weights, placed = direct(segments, spans), moved(joint, axis, spans)
        if placed is None:
            yield "direct", spans_estimator(weights)
        else:
            yield "direct", own_estimator(placed, axis, weights)


def _draw_case(
    joint: Joint, case: str, estimators: dict[str, Estimator], curve: "Axes", error: "Axes"
) -> None:
    geometry = joint.geometry
    angles = single_shape(geometry.segments, case, geometry.range_of_motion)
    actual = planar_curve(angles, geometry.segment_length)
    along = np.linspace(0.0, geometry.length, len(actual[0]))
    curve.plot(*actual, label="actual", **_ACTUAL)
    for name, estimator in estimators.items():
        estimated = planar_curve(estimator.angles(angles), geometry.segment_length)
        label, style = _METHODS[name]
        curve.plot(*estimated, label=label, linewidth=1.2, **style)
        distance = np.hypot(estimated[0] - actual[0], estimated[1] - actual[1])
        if estimator.noise is not None:
            error.plot(along[1:], distance[1:], **style | _WITHOUT_NOISE)
            distance = np.hypot(distance, estimator.spread(angles, geometry.segment_length))
        error.plot(along[1:], distance[1:], linewidth=1.2, **style)
    label_curve(curve, _TITLES[case])
    curve.set_ylabel("")
    error.set(xlabel="along the joint / m", yscale="log")
