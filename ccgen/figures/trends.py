"""What more sensors, or less noise, would bring."""

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation.fitted import FittedWeights
from ccgen.figures.style import Floats, plain_numbers, shortened, styled
from ccgen.joint import Joint
from ccgen.sensing.noise import length_variance, second_moment, stated_noise
from ccgen.sensing.readings import response

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 8
"""Sensors at one place around the joint."""

_FACTORS = np.geomspace(0.1, 10.0, 25)
_FLOOR = 1e-12
"""Of the largest variance of a reading, where nothing states its noise."""


@styled
def sensors_figure(fit: FittedWeights) -> "Figure":
    """Draw what sensors end to end could do, by how many of them run at each place.

    The error that the best linear estimator leaves on the shapes that say most of the joint, with
    the noise, steps and tolerances that the joint states; the joint's own error beside it.
    """
    from matplotlib.figure import Figure

    joint = fit.sensed
    state = fit.stated.shapes.state
    places = list(dict.fromkeys((sensor.angle, sensor.radius) for sensor in joint.sensors))
    counts = np.arange(1, min(_MOST, joint.geometry.segments) + 1)
    figure = Figure(figsize=(4.6, 3.0), layout="constrained")
    axes = figure.subplots()
    left = [_left(_end_to_end(joint, int(count)), state) for count in counts]
    axes.plot(counts * len(places), left, "o-", color="#0072B2", label="end to end, at their best")
    own = np.sqrt(
        np.mean([np.square(fit.standard_deviations.axes[a]) for a in joint.axes if a != "h"])
    )
    axes.plot([len(joint.sensors)], [np.degrees(own)], "D", color="#D55E00", label="this joint")
    axes.set(
        title="Error against the number of sensors",
        xlabel=f"sensors, at {len(places)} place{'s' * (len(places) > 1)} around the joint",
        ylabel="RMS of a segment / deg", yscale="log",
    )  # fmt: skip
    plain_numbers(axes.yaxis)
    axes.legend()
    return figure


@styled
def noise_figure(fit: FittedWeights) -> "Figure | None":
    """Draw the error of the weights as they are, were the noise another; None where none is stated.

    On the shapes that say most of the joint, unless those are recordings, whose noise is their own.
    """
    if stated_noise(fit.sensed) is None:
        return None
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.6, 3.0), layout="constrained")
    axes = figure.subplots()
    bending = [axis for axis in fit.sensed.axes if axis != "h"]
    source = fit.stated if fit.stated in fit.told else fit.told[0]
    found = fit.missed(source, True)
    for axis, colour in zip(bending, ("#0072B2", "#D55E00"), strict=False):
        known, spread = (np.mean(np.square(x)) for x in (found.known(axis), found.spread(axis)))
        rms = np.degrees(np.sqrt(known + np.square(_FACTORS) * spread))
        line = {"u": "-", "v": "--"}[axis]  # curves of like axes lie on each other
        axes.plot(_FACTORS, rms, color=colour, linestyle=line, label=axis)
        stated = float(np.degrees(np.sqrt(known + spread)))
        axes.plot([1.0], [stated], "D", color=colour)
    axes.set(
        title=f"Error against noise, on {shortened(source.name)}",
        xlabel="times the noise that is stated",
        ylabel="RMS of a segment / deg", xscale="log", yscale="log",
    )  # fmt: skip
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.legend()
    return figure


def _end_to_end(joint: Joint, count: int) -> Joint:
    """The joint with so many sensors at each of its places, each as the first one there is."""
    firsts = {(sensor.angle, sensor.radius): sensor for sensor in reversed(joint.sensors)}
    borders = np.linspace(0.0, joint.geometry.segments, count + 1)
    sensors = [
        replace(sensor, start=float(start), end=float(end))
        for sensor in firsts.values()
        for start, end in pairwise(borders)
    ]
    return replace(joint, sensors=tuple(sensors))


def _left(joint: Joint, state: Floats) -> float:
    """RMS error of a segment that is left at best, C - C H^T (H C H^T + R)^-1 H C, degrees."""
    moment = second_moment(state)
    if not joint.couples:
        m = joint.geometry.segments
        moment[:m, m:] = moment[m:, :m] = 0.0  # each axis reads its own sensors
    H = response(joint)
    sensed = H @ moment
    variance = length_variance(joint, moment)
    covariance = sensed @ H.T
    floor = _FLOOR * float(np.diag(covariance).max())
    remaining = moment - sensed.T @ np.linalg.solve(
        covariance + np.diag(np.maximum(variance, floor)), sensed
    )
    bends = [np.diag(remaining)[joint.rows(axis)] for axis in joint.axes if axis != "h"]
    return float(np.degrees(np.sqrt(np.maximum(np.mean(bends), 0.0))))
