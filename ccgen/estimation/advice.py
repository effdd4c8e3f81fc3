"""What to tell a user whose weights are not what they seem, in plain words."""

from collections.abc import Iterator

import numpy as np

from ccgen.errors import InputError
from ccgen.estimation.errors import ErrorRow, Missed, errors_of
from ccgen.estimation.fit import weights_of
from ccgen.estimation.fitted import FittedWeights
from ccgen.estimation.score import elongation_warning
from ccgen.estimation.sources import CASES, OTHER
from ccgen.estimation.weights import Floats
from ccgen.joint import METHODS
from ccgen.sensing.readings import normalised_response

_FAR = 3.0
"""Times the error on what was fitted to, from which on other loads are told of."""
_MATTERS = 1.0
"""Error in % of the range of motion that is told of."""
_WORSE = 1.05
"""Times the error of the best other weights from which on the chosen ones are called worse."""
_USELESS = 1.02
"""Growth of the error without a sensor below which that sensor adds nothing."""


def advice(fit: FittedWeights) -> Iterator[str]:
    """Everything that there is to say of a fit, the most important first."""
    yield from fit.notes
    yield from _other_loads(fit)
    yield from _no_better_than_nothing(fit)
    yield from _better_method(fit)
    yield from _spare_sensors(fit)
    yield from _elongation(fit)


def _other_loads(fit: FittedWeights) -> Iterator[str]:
    """Say how far the weights may be off on shapes that nobody has stated."""
    own = {row.source: row for row in fit.errors if not row.noise}
    fitted = [source.name for source in fit.task.sources if source.weight > 0]
    near = max(_worst(own[name]) for name in fitted if name in own)
    far = _worst(own[OTHER])
    if far < _MATTERS or far < _FAR * near:
        return
    cases = fitted == [CASES]
    remedy = (
        "state the joint's loads in [loads]"
        if cases
        else "state every load that it meets in [loads]"
    )
    yield (
        f"the weights are fitted to {'the load cases alone' if cases else ' and '.join(fitted)}, "
        f"with an error of {near:.2g} % of the range of motion; where other loads bend the joint "
        f"it is {far:.2g} %; {remedy}"
    )


def _worst(row: ErrorRow) -> float:
    return max(row.mean_percent_rom.values())


def _no_better_than_nothing(fit: FittedWeights) -> Iterator[str]:
    source = fit.stated
    shapes = source.shapes
    found = fit.missed(shapes, True)
    for axis in fit.weights:
        error, size = _size(found, axis), _rms(found.state[:, fit.joint.rows(axis)])
        if size > 0 and error >= size:
            yield (
                f"axis {axis}: on {source.name} the estimate errs by {_said(error, axis)}, but "
                f"answering zero errs by {_said(size, axis)} only; choose other sensors or shapes"
            )


def _better_method(fit: FittedWeights) -> Iterator[str]:
    """Say which other method does better on what the joint states."""
    found = {}
    for method in METHODS:
        if method != fit.method:
            try:
                found[method] = {a: weights_of(fit.quick, a, method) for a in fit.joint.axes}
            except InputError:
                continue
    shapes = fit.stated.shapes
    own = fit.missed(shapes, True)
    others = {method: fit.missed(shapes, True, weights) for method, weights in found.items()}
    for axis in fit.weights:
        errors = {method: _size(other, axis) for method, other in others.items()}
        if not errors:
            return
        best, chosen = min(errors, key=lambda method: errors[method]), _size(own, axis)
        if chosen > _WORSE * errors[best]:
            yield (
                f'axis {axis}: on {fit.stated.name} method "{fit.method}" errs by '
                f'{_said(chosen, axis)}, "{best}" by {_said(errors[best], axis)}; '
                f'write method = "{best}" in [estimator]'
            )


def _spare_sensors(fit: FittedWeights) -> Iterator[str]:
    """Say where a sensor may be left out at no cost, so that more of them would not help."""
    own = errors_of("", fit.missed(fit.stated.shapes, True), True, False)
    for axis in own.rms_deg:
        lost = {row.sensor: row.rms_deg[axis] for row in fit.without}
        seen = normalised_response(fit.joint)[:, fit.joint.rows(axis)]
        read = [
            sensor.name for sensor, row in zip(fit.joint.sensors, seen, strict=True) if row.any()
        ]
        known = {name: rms for name in read if (rms := lost[name]) is not None}
        if len(known) < 2 or not own.rms_deg[axis]:
            continue
        least = min(known, key=lambda name: known[name])
        if known[least] < _USELESS * own.rms_deg[axis]:
            yield (
                f"axis {axis}: without sensor {least} the error on {fit.stated.name} would be "
                f"{known[least]:.2g} degrees a segment instead of {own.rms_deg[axis]:.2g}: more "
                "sensors would not help"
            )


def _elongation(fit: FittedWeights) -> Iterator[str]:
    """Say how elongation that is stated bends an estimate that does not know it."""
    bent = elongation_warning(fit.joint, fit.weights)
    if bent is not None and fit.joint.geometry.elongation is not None:
        yield bent


def _size(found: Missed, axis: str) -> float:
    known, spread = found.known(axis), found.spread(axis)
    return float(np.sqrt(np.mean(np.square(known) + np.square(spread))))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _said(value: float, axis: str) -> str:
    return f"{100 * value:.2g} %" if axis == "h" else f"{np.degrees(value):.2g} degrees"
