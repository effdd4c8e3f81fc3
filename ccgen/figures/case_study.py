"""The paper's case study of the methods (figure 8)."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation import (
    Weights,
    direct,
    fit_coupled,
    fit_weights,
    in_the_papers_way,
)
from ccgen.figures.style import label_curve, new_figure, planar_curve, styled
from ccgen.joint import Joint
from ccgen.joint.layouts import end_to_end
from ccgen.sensing.noise import reading_noise
from ccgen.sensing.readings import normalised_response, readings
from ccgen.shapes import fit_library, fit_shapes, single_shape

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

Estimator = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""What is estimated of the true segment angles, shape (m,), radians."""

# Colours of Okabe and Ito, told apart by readers with any colour vision.
_ACTUAL: dict[str, Any] = {"color": "#000000", "linewidth": 4.0, "alpha": 0.25}
_METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "direct": ("DEM (end to end)", {"color": "#E69F00", "linestyle": "-."}),
    "equal": ("E-WAM", {"color": "#0072B2", "linestyle": "--"}),
    "wam": ("WAM", {"color": "#D55E00", "linestyle": "-"}),
    "noise-aware": ("noise-aware", {"color": "#009E73", "linestyle": ":"}),
    "wam-paper-call": ("WAM, paper's call", {"color": "#CC79A7", "linestyle": ":"}),
}


@styled
def case_study_figure(joint: Joint, method: str | None = None, axis: str | None = None) -> "Figure":
    """Draw actual and estimated curves of an axis under the joint's load cases (figure 8).

    Below each curve stands how far the estimates lie from it. The joint is bent as far as its
    range of motion allows.

    Args:
        joint: the specification.
        method: drawn beside DEM, E-WAM and WAM; the joint's own by default.
        axis: "u" or "v"; the first that is estimated by default.

    Raises:
        InputError: as `fit_joint`.
    """
    cases = [case for case in joint.shapes.cases if case != "constant-curvature"]
    cases = cases or list(joint.shapes.cases)
    estimators = dict(_estimators(joint, method or joint.method, axis or joint.axes[0]))
    figure, (curves, errors) = new_figure((2.6 * len(cases) + 0.6, 6.0), len(cases), rows=2)
    for case, curve, error in zip(cases, curves, errors, strict=True):
        _draw_case(joint, case, estimators, curve, error)
    largest = max(error.get_ylim()[1] for error in errors)
    for error in errors:
        error.set_ylim(_SMALLEST_DISTANCE * joint.geometry.length, largest)
    curves[0].set_ylabel("height / m")
    errors[0].set_ylabel("distance from actual / m")
    handles, labels = curves[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _estimators(joint: Joint, method: str, axis: str) -> Iterator[tuple[str, Estimator]]:
    """Methods by name, each with what it makes of a shape of the axis, the other one straight."""
    names = dict.fromkeys(("direct", "equal", "wam", method))
    if not in_the_papers_way(joint):
        shapes = fit_shapes(joint)
        for name in names:
            if name != "direct" or method == "direct":
                yield name, _of_state(joint, axis, fit_coupled(joint, axis, name, shapes))
        return
    library, spans = fit_library(joint), joint.axis(axis).spans
    segments = joint.geometry.segments
    noise = reading_noise(joint, axis)
    for name in names:
        if name != "direct":
            yield name, _of_spans(fit_weights(name, library, spans, noise))
        elif len(spans) <= segments:
            # DEM knows no overlap: as many sensors, end to end.
            yield name, _of_spans(direct(segments, end_to_end(segments, len(spans))))


def _of_spans(weights: Weights) -> Estimator:
    return lambda angles: weights.estimate(readings(angles, weights.spans))


def _of_state(joint: Joint, axis: str, weights: Weights) -> Estimator:
    seen = normalised_response(joint)[joint.own(axis), joint.rows(axis)]
    return lambda angles: weights.estimate(seen @ angles)


def _draw_case(
    joint: Joint, case: str, estimators: dict[str, Estimator], curve: "Axes", error: "Axes"
) -> None:
    geometry = joint.geometry
    angles = single_shape(geometry.segments, case, geometry.range_of_motion)
    actual = planar_curve(angles, geometry.segment_length)
    along = np.linspace(0.0, geometry.length, len(actual[0]))
    curve.plot(*actual, label="actual", **_ACTUAL)
    for name, estimator in estimators.items():
        estimated = planar_curve(estimator(angles), geometry.segment_length)
        label, style = _METHODS[name]
        curve.plot(*estimated, label=label, linewidth=1.2, **style)
        distance = np.hypot(estimated[0] - actual[0], estimated[1] - actual[1])
        error.plot(along[1:], distance[1:], linewidth=1.2, **style)
    label_curve(curve, _TITLES[case])
    curve.set_ylabel("")
    error.set(xlabel="along the joint / m", yscale="log")
