"""What to tell a user whose weights are not what they seem, in plain words."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ccgen.errors import InputError, ReachError
from ccgen.estimation.errors import ErrorRow, Missed, Pooled, errors_of
from ccgen.estimation.excitation import few_rows, unexcited
from ccgen.estimation.fit import fit_task
from ccgen.estimation.fitted import FittedWeights
from ccgen.estimation.held_out import Choice
from ccgen.estimation.score import elongation_warning
from ccgen.estimation.sources import CASES, OTHER, RECORDING, Source
from ccgen.estimation.weights import Floats
from ccgen.joint import METHODS
from ccgen.sensing.readings import normalised_response
from ccgen.shapes import fit_shapes

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
    yield from _better_weights(fit)
    yield from _spare_sensors(fit)
    yield from _elongation(fit)
    yield from _untold(fit)
    if fit.found is not None:
        for reference in fit.found.references:
            yield from reference.notes
            if not reference.dense:
                yield (
                    f"{reference.name}: its errors of segments hold the most probable shapes for "
                    "true, which bodies and markers tell in part; those at stations are measured"
                )


def _other_loads(fit: FittedWeights) -> Iterator[str]:
    """Say how far the weights may be off on shapes that nobody has stated."""
    # Of real counts there is a row with noise alone.
    own = {row.source: row for row in sorted(fit.errors, key=lambda row: not row.noise)}
    fitted = [source.name for source in fit.task.sources if source.weight > 0]
    near = max(_worst(own[name]) for name in fitted if name in own)
    far = _worst(own[OTHER])
    if far < _MATTERS or far < _FAR * near:
        return
    cases = fitted == [CASES]
    if any(name.startswith(RECORDING) for name in fitted):
        remedy = "record it in every load that it meets, or state them in [loads]"
    elif cases:
        remedy = "state the joint's loads in [loads]"
    else:
        remedy = "state every load that it meets in [loads]"
    yield (
        f"the weights are fitted to {'the load cases alone' if cases else ' and '.join(fitted)}, "
        f"with an error of {near:.2g} % of the range of motion; where other loads bend the joint "
        f"it is {far:.2g} %; {remedy}"
    )


def _worst(row: ErrorRow) -> float:
    return max(row.mean_percent_rom.values())


def _no_better_than_nothing(fit: FittedWeights) -> Iterator[str]:
    found, name = fit.judged(), fit.stated.name
    for axis in fit.weights:
        error, size = _size(found, axis), _rms(found.truth(axis))
        if size > 0 and error >= size:
            yield (
                f"axis {axis}: on {name} the estimate errs by {_said(error, axis)}, but "
                f"answering zero errs by {_said(size, axis)} only; choose other sensors or shapes"
            )


def _better_weights(fit: FittedWeights) -> Iterator[str]:
    """Say which other weights do better on what the joint states."""
    own = fit.judged()
    others = {remedy: _judged(fit, choice) for remedy, choice in _others(fit).items()}
    for axis in fit.weights:
        errors = {remedy: _size(one, axis) for remedy, one in others.items() if one is not None}
        if not errors:
            return
        best, chosen = min(errors, key=lambda remedy: errors[remedy]), _size(own, axis)
        if chosen > _WORSE * errors[best]:
            weights, remedy = best
            yield (
                f'axis {axis}: on {fit.stated.name} method "{fit.method}" errs by '
                f"{_said(chosen, axis)}, {weights} by {_said(errors[best], axis)}; {remedy}"
            )


def _others(fit: FittedWeights) -> dict[tuple[str, str], Choice]:
    """Weights that are at hand beside those chosen: what they are, and how to choose them."""
    found: dict[tuple[str, str], Choice] = {
        (f'"{method}"', f'write method = "{method}" in [estimator]'): _by(method)
        for method in METHODS
        if method != fit.method
    }
    if fit.joint.shapes.cases and {one.name for one in fit.task.sources} != {CASES}:
        cases = Source(CASES, fit_shapes(fit.joint), 1.0)
        found["the same fitted to the load cases", "give cases a weight in [shapes]"] = (
            lambda block: fit_task(replace(block.quick, sources=[cases]), fit.method)
        )
    return found


def _by(method: str) -> Choice:
    return lambda block: fit_task(block.quick, method)


def _judged(fit: FittedWeights, choice: Choice) -> Missed | Pooled | None:
    """Errors of other weights; None where the joint does not allow them."""
    try:
        return fit.judged(choice)
    except (InputError, ReachError):
        return None


def _spare_sensors(fit: FittedWeights) -> Iterator[str]:
    """Say where a sensor may be left out at no cost, so that more of them would not help."""
    own = errors_of("", fit.judged(), True, False)
    for axis in own.rms_deg:
        lost = {row.sensor: row.rms_deg[axis] for row in fit.without}
        seen = normalised_response(fit.sensed)[:, fit.sensed.rows(axis)]
        read = [
            sensor.name for sensor, row in zip(fit.sensed.sensors, seen, strict=True) if row.any()
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


def _untold(fit: FittedWeights) -> Iterator[str]:
    """Say what the sources do not tell of the weights."""
    if fit.method in ("direct", "equal"):
        return
    sources = [source for source in fit.task.sources if source.weight > 0]
    others = next(source for source in fit.told if source.name == OTHER)
    yield from unexcited(fit.sensed, sources, others)
    yield from few_rows(fit.sensed, [one for one in sources if one.name.startswith(RECORDING)])


def _elongation(fit: FittedWeights) -> Iterator[str]:
    """Say how elongation that is stated bends an estimate that does not know it."""
    bent = elongation_warning(fit.sensed, fit.weights)
    if bent is not None and fit.sensed.geometry.elongation is not None:
        yield bent


def _size(found: Missed | Pooled, axis: str) -> float:
    squares = np.square(found.known(axis)) + np.square(found.spread(axis))
    return float(np.sqrt(np.nanmean(squares)))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


def _said(value: float, axis: str) -> str:
    return f"{100 * value:.2g} %" if axis == "h" else f"{np.degrees(value):.2g} degrees"
