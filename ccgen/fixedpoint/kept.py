"""A fit in a file beside the joint file, so that every machine exports the same bytes of it.

Fits to loads and recordings depend on rounding in their last bits, which differs between
processors. What `ccgen fit --write` keeps are weights, gains and zeros of twelve digits, the
integers that follow from them, and the errors that were told; export takes them while every file
that they were made from is the same.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ccgen import __version__
from ccgen.errors import InputError
from ccgen.estimation.coupled import spans_of
from ccgen.estimation.errors import ErrorRow, StandardDeviations
from ccgen.estimation.fit import Task
from ccgen.estimation.fitted import Without
from ccgen.estimation.sources import Source
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.fixedpoint.fitted import Fit
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.guarded_storage import guard_record, guarded_model
from ccgen.fixedpoint.joint_checks import JointChecks, SensorCheck
from ccgen.fixedpoint.ranges import reading_per_count
from ccgen.fixedpoint.storage import model_from_record, model_record
from ccgen.joint import Joint
from ccgen.outputs import write_file
from ccgen.shapes import Shapes

_FORMAT = 2
_DIGITS = 12
_SAMPLES = 8
"""Shapes that are kept for an exported folder's self-test, beside the farthest."""
_SENSOR = ("metres_per_count", "zero", "noise", "gain_tolerance")
"""What is kept of a sensor."""


@dataclass(frozen=True, eq=False)
class Kept:
    """What lies beside a joint file.

    Attributes:
        path: the file.
        fit: what it holds; None where it is out of date.
        note: what is to be said of it.
        sha256: of the file.
    """

    path: Path
    fit: Fit | None
    note: str
    sha256: str


def kept_path(joint: Joint) -> Path:
    """Where the fit of a joint is kept."""
    return Path(joint.source).with_name(f"{joint.name}.fit.json")


def inputs_of(joint: Joint) -> dict[str, str]:
    """SHA-256 of everything that a fit of a joint is made from, by name.

    Raises:
        InputError: a recording that cannot be read.
    """
    from ccgen.recordings.hashes import recording_hashes

    found = {"joint.toml": hashlib.sha256(joint.content).hexdigest()}
    if joint.calibration is not None:
        found[joint.calibration] = hashlib.sha256(joint.calibration_content).hexdigest()
    return found | recording_hashes(joint)


def rounded(fit: Fit) -> Fit:
    """The same fit with weights, gains, noise and zeros of twelve digits."""
    sensors = tuple(
        replace(
            sensor,
            metres_per_count=_short(sensor.metres_per_count),
            noise=None if sensor.noise is None else _short(sensor.noise),
            gain_tolerance=_short(sensor.gain_tolerance),
        )
        for sensor in fit.sensed.sensors
    )
    task = replace(fit.task, joint=replace(fit.sensed, sensors=sensors))
    weights = {
        axis: Weights(own.method, own.spans, _shortened(own.matrix), _shortened(own.intercept))
        for axis, own in fit.weights.items()
    }
    return replace(fit, weights=weights, task=task)


def write_fit(fit: Fit) -> Path:
    """Keep a fit beside its joint file.

    Args:
        fit: as `rounded` returns it; what is kept is what it tells.

    Returns:
        The file's path.

    Raises:
        FormatError: no fixed-point format fits; InputError: the file cannot be written.
    """
    path = kept_path(fit.joint)
    text = json.dumps(_record(fit), indent=1, allow_nan=False)
    write_file(path, f"{text}\n".encode())
    return path


def kept_fit(joint: Joint) -> Kept | None:
    """What is kept of a joint's fit; None where nothing is, or the joint has no file.

    Raises:
        InputError: the file is damaged, or an input cannot be read.
    """
    path = kept_path(joint)
    try:
        data = path.read_bytes()
        if Path(joint.source).read_bytes() != joint.content:
            return None
    except OSError:
        return None
    sha256 = hashlib.sha256(data).hexdigest()
    again = f"run `ccgen fit {joint.source} --write`"
    try:
        record = json.loads(data)
        if record["tool"] != "ccgen" or record["kept"] != _FORMAT:
            return Kept(path, None, f"{path}: is of another ccgen and not used; {again}", sha256)
        changed = _changed(record["inputs"], inputs_of(joint))
        if changed is not None:
            said = f"{path}: is older than {changed} and not used, the joint is fitted anew; "
            return Kept(path, None, said + f"{again} to keep it", sha256)
        return Kept(path, _fit(joint, record), f"the fit is that of {path}", sha256)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise InputError(f"{path}: damaged ({error}); remove it, or {again}") from None


def _changed(kept: Mapping[str, str], now: Mapping[str, str]) -> str | None:
    """The first input that is not what it was, or that was not there or is no more."""
    names = [*now, *(name for name in kept if name not in now)]
    return next((name for name in names if kept.get(name) != now.get(name)), None)


def _record(fit: Fit) -> dict[str, Any]:
    guarded = fit.guarded
    rows = _some(fit.shapes.state)
    state = fit.shapes.state[rows]
    return {
        "tool": "ccgen",
        "version": __version__,
        "kept": _FORMAT,
        "joint": fit.joint.name,
        "method": fit.method,
        "inputs": inputs_of(fit.joint),
        "sensors": {
            sensor.name: {key: getattr(sensor, key) for key in _SENSOR}
            for sensor in fit.sensed.sensors
        },
        "weights": {
            axis: {"matrix": own.matrix.tolist(), "intercept": own.intercept.tolist()}
            for axis, own in fit.weights.items()
        },
        "model": model_record(fit.plain),
        "guarded": model_record(guarded.model) | guard_record(guarded),
        "shapes": _shortened(state).tolist(),
        "source": [fit.shapes.source[i] for i in rows],
        "errors": [row.record() for row in fit.errors],
        "without": [asdict(row) for row in fit.without],
        "standard_deviations": asdict(fit.standard_deviations),
        "stated": fit.stated.name,
        "checks": [asdict(row) for row in fit.checks.sensors],
        "unchecked": list(fit.checks.notes),
        "warnings": list(fit.warnings),
        **_stiffness(fit),
    }


def _stiffness(fit: Fit) -> dict[str, Any]:
    """The stiffness profile that recordings told, for people and programs that open the file."""
    told = None if fit.found is None else fit.found.stiffness
    if told is None:
        return {}
    numbers = {name: [_short(value) for value in values] for name, values in asdict(told).items()}
    return {"stiffness_profile": numbers}


def _some(state: Floats) -> list[int]:
    """Rows to keep: some for an exported folder's self-test, and the farthest in every value."""
    samples = range(0, len(state), max(1, len(state) // _SAMPLES))
    farthest = np.abs(state).argmax(axis=0).tolist()
    return sorted({*samples[:_SAMPLES], *farthest})


def _fit(joint: Joint, record: dict[str, Any]) -> Fit:
    sensors = tuple(replace(one, **record["sensors"][one.name]) for one in joint.sensors)
    sensed = replace(joint, sensors=sensors)
    m = joint.geometry.segments
    state = np.array(record["shapes"], dtype=np.float64)
    shapes = Shapes(
        state[:, :m], state[:, m : 2 * m], state[:, 2 * m :], tuple(map(str, record["source"]))
    )
    method = str(record["method"])
    weights = {axis: _weights(sensed, axis, method, record["weights"][axis]) for axis in joint.axes}
    task = Task(sensed, [Source(str(record["stated"]), shapes, 1.0)])
    fit = Fit(joint, method, weights, task)
    std = record["standard_deviations"]
    axes = {axis: tuple(map(float, std["axes"][axis])) for axis in joint.axes}
    guarded = guarded_model(model_from_record(record["guarded"]), record["guarded"])
    checks = JointChecks(
        guarded.groups,
        tuple(SensorCheck(**one) for one in record["checks"]),
        tuple(map(str, record["unchecked"])),
    )
    # What the fit would find out of its shapes is here as it was found.
    fit.__dict__.update(
        shapes=shapes,
        plain=model_from_record(record["model"]),
        model=guarded.model,
        guarded=guarded,
        serving=_serving(sensed, method, guarded),
        checks=checks,
        errors=tuple(_error_row(one) for one in record["errors"]),
        without=tuple(_without(one) for one in record["without"]),
        warnings=tuple(map(str, record["warnings"])),
        standard_deviations=StandardDeviations(axes, float(std["tip_m"])),
    )
    return fit


def _serving(joint: Joint, method: str, guarded: GuardedModel) -> dict[str, list[Weights | None]]:
    """Weights without each sensor of an axis, as its integers have them."""
    found: dict[str, list[Weights | None]] = {}
    for axis, own in guarded.fallbacks.items():
        model, spans = guarded.model.axis(axis), spans_of(joint.sensors[joint.own(axis)])
        unit = reading_per_count(joint, axis)
        found[axis] = [
            None
            if rows is None
            else without_intercept(
                method, spans, np.ldexp(rows, -(model.fraction_bits + model.shift)) / unit
            )
            for rows in own.rows
        ]
    return found


def _weights(joint: Joint, axis: str, method: str, record: dict[str, Any]) -> Weights:
    spans = spans_of(joint.sensors[joint.own(axis)])
    return Weights(method, spans, np.array(record["matrix"]), np.array(record["intercept"]))


def _error_row(record: dict[str, Any]) -> ErrorRow:
    from ccgen.recordings.stations import StationErrors

    stations = record.get("stations")
    if stations is not None:
        stations = {name: StationErrors(**_unknown(one)) for name, one in stations.items()}
    return ErrorRow(**{**record, "stations": stations})


def _without(record: dict[str, Any]) -> Without:
    found = record["deviations"]
    deviations = {a: None if own is None else tuple(map(float, own)) for a, own in found.items()}
    return Without(**{**record, "deviations": deviations})


def _unknown(record: dict[str, Any]) -> dict[str, Any]:
    """The numbers of a record; NaN where there is none."""
    return {
        key: _unknown(value)
        if isinstance(value, dict)
        else float("nan" if value is None else value)
        for key, value in record.items()
    }


def _short(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _shortened(values: Floats) -> Floats:
    return np.array([_short(value) for value in values.flat]).reshape(values.shape)
