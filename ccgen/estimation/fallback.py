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
from ccgen.estimation.fit import Task, weights_of
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.sensing.noise import told_noise
from ccgen.sensing.readings import normalised_response, normaliser

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.joint.specification import AxisSensors

_MANY_ROWS = 4000

_NOTHING_LEFT = 0.98
"""Share of the axis' own size from which on an error says that nothing is estimated."""


def fallback(task: Task, axis: str, method: str, lost: int) -> Weights | None:
    """Weights of an output axis while one of its sensors gives no reading.

    Args:
        task: what the axis' own weights are fitted to.
        axis: an output axis.
        method: of the axis' own weights: "direct", "equal", "wam" or "noise-aware".
        lost: number of the sensor among those that the axis reads.

    Returns:
        Weights for all sensors of the axis, 0 for the lost one; None where the others do not
        tell the axis.
    """
    own = task.joint.own(axis)
    if own.stop - own.start < 2:
        return None
    weights = _without_fit(task, axis, method, lost)
    if weights is None:
        fitted = "wam" if method in ("direct", "equal") else method
        weights = weights_of(task, axis, fitted, own.start + lost)
    actual = task.rows.state[:, task.joint.rows(axis)]
    missed = _estimated(task, axis, weights) - actual
    squares = [float(task.rows.weight @ np.square(one).sum(axis=1)) for one in (missed, actual)]
    return None if squares[0] >= _NOTHING_LEFT**2 * squares[1] else weights


def _without_fit(task: Task, axis: str, method: str, lost: int) -> Weights | None:
    """Direct or equal weights of the sensors that are left, where they cover every segment."""
    if method not in ("direct", "equal"):
        return None
    joint, own = task.joint, task.joint.own(axis)
    try:
        found = weights_of(replace(task, joint=without(joint, own.start + lost)), axis, method)
    except InputError:
        return None
    matrix = np.insert(found.matrix, lost, 0.0, axis=1)
    return without_intercept(method, spans_of(joint.sensors[own]), matrix)


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


def held(task: Task, axis: str, weights: Weights, limit: Floats) -> Weights:
    """The same weights, none larger than its limit: least squares over the others.

    Args:
        task: what they are fitted to.
        axis: an output axis.
        weights: of that axis; a column of zeros stays one.
        limit: largest |weight| of each sensor, shape (n,), 0 or more.
    """
    if (np.abs(weights.matrix) <= limit).all():
        return weights
    system, wanted = _system(task, axis, weights.method == "noise-aware")
    used = np.asarray(weights.matrix.any(axis=0))
    rows = [
        row if (np.abs(row) <= limit).all() else _held_row(system, target, row, limit, used)
        for row, target in zip(weights.matrix, wanted.T, strict=True)
    ]
    return without_intercept(weights.method, weights.spans, np.array(rows))


def expected_error(task: Task, axis: str, weights: Weights) -> float:
    """Root mean square error of an axis on what it is fitted to, radians (a share for "h").

    With the noise of the readings, where it is known.
    """
    missed = _estimated(task, axis, weights) - task.rows.state[:, task.joint.rows(axis)]
    square = float(task.rows.weight @ np.square(missed).mean(axis=1))
    noise = _deviation(task, axis)
    if noise is not None:
        square += float(np.square(weights.matrix * noise).sum(axis=1).mean())
    return float(np.sqrt(square))


def _estimated(task: Task, axis: str, weights: Weights) -> Floats:
    """Estimates from ideal readings of the rows, shape (N, m or S)."""
    read = task.rows.state @ normalised_response(task.joint)[task.joint.own(axis)].T
    return np.asarray(read @ weights.matrix.T)


def _deviation(task: Task, axis: str) -> Floats | None:
    """Deviation of the normalised readings of an axis; None where it is not known."""
    own = task.joint.own(axis)
    if task.noise is not None:
        return np.asarray((task.noise / normaliser(task.joint))[own])
    return told_noise(task.joint, axis, task.rows.second_moment)


def _system(task: Task, axis: str, noisy: bool) -> tuple[DoubleDouble, Floats]:
    """Least squares of the weights, system @ weights^T ~ wanted, with noise among the rows."""
    own = task.joint.own(axis)
    states = task.rows.state * np.sqrt(task.rows.weight)[:, None]
    wanted = states[:, task.joint.rows(axis)]
    system = matmul(states, normalised_response(task.joint)[own].T)
    if len(states) > _MANY_ROWS:  # the same problem in as many rows as it has columns
        small: Floats = np.asarray(np.linalg.qr(np.hstack([system.hi, wanted]), mode="r"))
        count = own.stop - own.start
        system, wanted = DoubleDouble.of(small[:, :count]), small[:, count:]
    noise = _deviation(task, axis) if noisy else None
    if noise is None:
        return system, wanted
    system = concatenate([system, DoubleDouble.of(np.diag(noise))])
    return system, np.vstack([wanted, np.zeros((noise.size, wanted.shape[1]))])


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
