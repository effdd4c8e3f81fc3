"""Figures: one shape with its sensors, and the paper's case study of the methods (figure 8).

A curve is the neutral axis in the plane of bending, in metres: deflection to the right for a
positive angle, the unbent axis upwards. The same data give the same bytes.
"""

import functools
import io
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from ccgen.estimation import Weights, direct, fit_weights, reading_noise, readings
from ccgen.joint import Joint
from ccgen.kinematics import chain
from ccgen.layouts import end_to_end
from ccgen.shapes import fit_library, single_shape

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ccgen.simulation import Simulation

Floats = NDArray[np.float64]
P = ParamSpec("P")
T = TypeVar("T")

_STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9.0,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "svg.fonttype": "path",
    "svg.hashsalt": "ccgen",
}
_POINTS_PER_SEGMENT = 8
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


def _styled(draw: Callable[P, T]) -> Callable[P, T]:
    @functools.wraps(draw)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        import matplotlib

        with matplotlib.rc_context(_STYLE):
            return draw(*args, **kwargs)

    return run


@_styled
def figure_bytes(figure: "Figure", file_format: str) -> bytes:
    """Return the figure as a file of the format "svg" or "png", without date and version."""
    metadata = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}
    buffer = io.BytesIO()
    figure.savefig(buffer, format=file_format, dpi=150, metadata=metadata[file_format])
    return buffer.getvalue()


def planar_curve(angles: Floats, segment_length: float) -> tuple[Floats, Floats]:
    """Neutral axis of a joint bent in one plane, several points a segment.

    Args:
        angles: segment angles of the bending axis, shape (m,), radians.
        segment_length: metres.

    Returns:
        Deflection and height, shape (points,), metres, the base included.
    """
    fine = np.repeat(np.asarray(angles) / _POINTS_PER_SEGMENT, _POINTS_PER_SEGMENT)
    ends = chain(np.zeros_like(fine), fine, segment_length / _POINTS_PER_SEGMENT)[:, :3, 3]
    return np.append(0.0, ends[:, 0]), np.append(0.0, ends[:, 2])


@_styled
def shape_figure(joint: Joint, simulation: "Simulation", axis: str = "u") -> "Figure":
    """Draw the bent axis of a simulated joint: its curve, its angles and the sensors' readings."""
    angles = simulation.u.angles if axis == "u" else simulation.v.angles
    figure, (curve, profile) = _figure((7.0, 4.0), 2)
    deflection, height = planar_curve(angles, joint.geometry.segment_length)
    curve.plot(deflection, height, color="#000000")
    curve.plot(deflection[::_POINTS_PER_SEGMENT], height[::_POINTS_PER_SEGMENT], "k.")
    _label_curve(curve, f"{joint.name}, bent in {axis}")
    profile.stairs(np.degrees(angles), baseline=None, color="#000000", label="segment angle")
    means = readings(angles, joint.axis(axis).spans)
    for j, ((a, b), mean) in enumerate(zip(joint.axis(axis).spans, means, strict=True)):
        label = "sensor: mean over its span" if j == 0 else None
        profile.plot([a, b + 1], np.degrees([mean, mean]), color="#D55E00", label=label)
    profile.set(title="Angles", xlabel="segment", ylabel="degrees")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


@_styled
def case_study_figure(joint: Joint, method: str | None = None, axis: str = "u") -> "Figure":
    """Draw actual and estimated curves of an axis under the joint's load cases (figure 8).

    Below each curve stands how far the estimates lie from it. The joint is bent as far as its
    range of motion allows.

    Args:
        joint: the specification.
        method: drawn beside DEM, E-WAM and WAM; the joint's own by default.
        axis: "u" or "v".

    Raises:
        InputError: as `fit_joint`.
    """
    cases = [case for case in joint.shapes.cases if case != "constant-curvature"]
    cases = cases or list(joint.shapes.cases)
    estimators = dict(_estimators(joint, method or joint.method, axis))
    figure, (curves, errors) = _figure((2.6 * len(cases) + 0.6, 6.0), len(cases), rows=2)
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


def _estimators(joint: Joint, method: str, axis: str) -> Iterator[tuple[str, Weights]]:
    library, spans = fit_library(joint), joint.axis(axis).spans
    segments = joint.geometry.segments
    noise = reading_noise(joint, axis)
    for name in dict.fromkeys(("direct", "equal", "wam", method)):
        if name != "direct":
            yield name, fit_weights(name, library, spans, noise)
        elif len(spans) <= segments:
            # DEM knows no overlap: as many sensors, end to end.
            yield name, direct(segments, end_to_end(segments, len(spans)))


def _draw_case(
    joint: Joint, case: str, estimators: dict[str, Weights], curve: "Axes", error: "Axes"
) -> None:
    geometry = joint.geometry
    angles = single_shape(geometry.segments, case, geometry.range_of_motion)
    actual = planar_curve(angles, geometry.segment_length)
    along = np.linspace(0.0, geometry.length, len(actual[0]))
    curve.plot(*actual, label="actual", **_ACTUAL)
    for name, weights in estimators.items():
        estimate = weights.estimate(readings(angles, weights.spans))
        estimated = planar_curve(estimate, geometry.segment_length)
        label, style = _METHODS[name]
        curve.plot(*estimated, label=label, linewidth=1.2, **style)
        distance = np.hypot(estimated[0] - actual[0], estimated[1] - actual[1])
        error.plot(along[1:], distance[1:], linewidth=1.2, **style)
    _label_curve(curve, _TITLES[case])
    curve.set_ylabel("")
    error.set(xlabel="along the joint / m", yscale="log")


def _figure(size: tuple[float, float], columns: int, rows: int = 1) -> tuple["Figure", Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    heights = [2, 1] if rows == 2 else [1]
    axes = figure.subplots(rows, columns, squeeze=False, height_ratios=heights)
    return figure, axes if rows > 1 else axes[0]


def _label_curve(axes: "Axes", title: str) -> None:
    axes.set(title=title, xlabel="deflection / m", ylabel="height / m", aspect="equal")
    axes.set_adjustable("datalim")
