"""Weights that serve while one sensor of an axis gives no reading.

They are fitted as the axis' own are, by the joint's method to the same shapes, as if the sensor did
not exist. A method without a fit may have no reading left for a segment; what the shapes allow
("wam") then takes its place. Fixed point holds weights to the format of the axis' own: where one
would exceed it, it is held at the limit and the others are fitted again.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.double_double import DoubleDouble, concatenate, least_squares, matmul
from ccgen.errors import InputError
from ccgen.estimation.coupled import spans_of
from ccgen.estimation.fit import fit_axis
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.sensing.noise import second_moment, told_noise
from ccgen.sensing.readings import normalised_response

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.joint.specification import AxisSensors
    from ccgen.shapes import Shapes

_NOTHING_LEFT = 0.98
"""Share of the axis' own size from which on an error says that nothing is estimated."""


def fallback(joint: "Joint", axis: str, method: str, shapes: "Shapes", lost: int) -> Weights | None:
    """Weights of an output axis while one of its sensors gives no reading.

    Args:
        joint: its sensors.
        axis: an output axis.
        method: of the axis' own weights.
        shapes: that those are fitted to.
        lost: number of the sensor among those that the axis reads.

    Returns:
        Weights for all sensors of the axis, 0 for the lost one; None where the others do not
        tell the axis.
    """
    own = joint.own(axis)
    if own.stop - own.start < 2:
        return None
    rest = without(joint, own.start + lost)
    try:
        found = fit_axis(rest, axis, method, shapes)
    except InputError:
        if method not in ("direct", "equal"):
            raise
        found = fit_axis(rest, axis, "wam", shapes)
    matrix = np.insert(found.matrix, lost, 0.0, axis=1)
    states = shapes.state
    read = states @ normalised_response(joint)[own].T
    actual = states[:, joint.rows(axis)]
    missed = np.square(read @ matrix.T - actual).sum()
    if missed >= _NOTHING_LEFT**2 * np.square(actual).sum():
        return None
    return without_intercept(found.method, spans_of(joint.sensors[own]), matrix)


def without(joint: "Joint", sensor: int) -> "Joint":
    """The same joint without one sensor of its list."""
    parts = tuple((a - (a > sensor), b - (b > sensor)) for a, b in joint.parts)
    sensors = joint.sensors[:sensor] + joint.sensors[sensor + 1 :]
    sets = {}
    for axis in ("u", "v"):
        own = getattr(joint, axis)
        if own is not None and axis in joint.axes:
            part = joint.own(axis)
            if part.start <= sensor < part.stop:
                own = _set_without(own, sensor - part.start)
        sets[axis] = own
    return replace(joint, sensors=sensors, parts=parts, u=sets["u"], v=sets["v"])


def _set_without(own: "AxisSensors", sensor: int) -> "AxisSensors":
    return replace(own, spans=own.spans[:sensor] + own.spans[sensor + 1 :])


def held(joint: "Joint", axis: str, weights: Weights, shapes: "Shapes", limit: Floats) -> Weights:
    """The same weights, none larger than its limit: least squares over the others.

    Args:
        joint: its sensors.
        axis: an output axis.
        weights: of that axis; a column of zeros stays one.
        shapes: that they are fitted to.
        limit: largest |weight| of each sensor, shape (n,), 0 or more.
    """
    if (np.abs(weights.matrix) <= limit).all():
        return weights
    own, states = joint.own(axis), shapes.state / np.sqrt(len(shapes))
    system = matmul(states, normalised_response(joint)[own].T)
    wanted = states[:, joint.rows(axis)]
    noise = told_noise(joint, axis, second_moment(shapes.state))
    if weights.method == "noise-aware" and noise is not None:
        system = concatenate([system, DoubleDouble.of(np.diag(noise))])
        wanted = np.vstack([wanted, np.zeros((noise.size, wanted.shape[1]))])
    used = np.asarray(weights.matrix.any(axis=0))
    rows = [
        row if (np.abs(row) <= limit).all() else _held_row(system, target, row, limit, used)
        for row, target in zip(weights.matrix, wanted.T, strict=True)
    ]
    return without_intercept(weights.method, weights.spans, np.array(rows))


def _held_row(
    system: DoubleDouble, target: Floats, row: Floats, limit: Floats, used: NDArray[np.bool_]
) -> Floats:
    """One row of weights; each turn holds those that exceed their limit and fits the rest."""
    row, free = row.copy(), used.copy()
    while (beyond := free & (np.abs(row) > limit)).any():
        row[beyond] = np.copysign(limit, row)[beyond]
        free &= ~beyond
        if free.any():
            left = (target[:, None] - matmul(system[:, ~free], row[~free, None])).hi
            row[free] = least_squares(system[:, free], left)[:, 0]
    return row


def expected_error(joint: "Joint", axis: str, weights: Weights, shapes: "Shapes") -> float:
    """Root mean square error of an axis on shapes, radians (a share of the length for "h").

    With the noise of the readings, the step of the counts and the tolerance of the gains, where
    noise is stated.
    """
    states, own = shapes.state, joint.own(axis)
    missed = states @ normalised_response(joint)[own].T @ weights.matrix.T
    square = float(np.mean(np.square(missed - states[:, joint.rows(axis)])))
    noise = told_noise(joint, axis, second_moment(states))
    if noise is not None:
        square += float(np.square(weights.matrix * noise).sum(axis=1).mean())
    return float(np.sqrt(square))
