"""What the templates tell of errors: a fit's tables, and the standard deviations of its values."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from ccgen.estimation.errors import ErrorRow
from ccgen.estimation.fitted import Without
from ccgen.fixedpoint import Fit
from ccgen.fixedpoint.model import FixedPointModel

_NOTHING = 1e-12
"""Degrees, metres and per cent below which an error is rounding alone."""

_LOST = "lost"

_OF_AXES: tuple[tuple[str, Callable[[ErrorRow], dict[str, float]]], ...] = (
    ("mean, % of range", lambda row: dict(row.mean_percent_rom)),
    ("RMS of a segment, °", lambda row: dict(row.rms_deg)),
    ("RMS of the whole bend, °", lambda row: dict(row.total_bend_rms_deg)),
)


def errors_context(fitted: Fit) -> dict[str, Any]:
    """The table of errors, and the standard deviations in steps and in degrees."""
    rows = fitted.errors
    return {
        "error_titles": list(_cells(rows[0])),
        "error_rows": [_row(source, rows) for source in dict.fromkeys(row.source for row in rows)],
        "std": _deviations(fitted, fitted.model),
        "left_titles": list(_left(fitted, *fitted.left[0])),
        "left_rows": [list(_left(fitted, sensor, row).values()) for sensor, row in fitted.left],
        "std_without": [_serving(fitted, j) for j in range(len(fitted.without))],
    }


def _row(source: str, rows: tuple[ErrorRow, ...]) -> dict[str, Any]:
    """Errors on one source, without and with noise."""
    own = {row.noise: row for row in rows if row.source == source}
    noisy = _cells(own[True])
    plain = _cells(own[False]) if False in own else {}
    return {
        "source": source,
        "held_out": own[True].held_out,
        "cells": [
            f"{plain[title]} / {value}" if title in plain else value
            for title, value in noisy.items()
        ],
    }


def _cells(row: ErrorRow) -> dict[str, str]:
    cells = {
        f"{axis}: {title}": _said(value)
        for title, of in _OF_AXES
        for axis, value in of(row).items()
    }
    cells["tip, RMS, mm"] = _said(1e3 * row.tip_rms_m)
    cells["tip, worst, mm"] = _said(1e3 * row.tip_max_m)
    if row.elongation_rms_percent is not None:
        cells["elongation, RMS, %"] = _said(row.elongation_rms_percent)
    return cells


def _deviations(fitted: Fit, model: FixedPointModel) -> dict[str, Any]:
    """Standard deviations of all axes in steps of their formats, rounded up, and of the tip."""
    found = fitted.standard_deviations
    axes = {}
    for axis, values in found.axes.items():
        unit = 100.0 if axis == "h" else 180.0 / math.pi
        axes[axis] = {
            "steps": _steps(model, axis, values),
            "said": [_said(unit * value) for value in values],
        }
    return {
        "axes": axes,
        "tip_um": _micrometres(found.tip_m),
        "tip_mm": _said(1e3 * found.tip_m),
        "source": fitted.stated.name,
    }


def _left(fitted: Fit, sensor: str, row: ErrorRow | Without) -> dict[str, str]:
    """What is told while a sensor is lost: texts by title."""
    cells = {"missing": sensor}
    for axis, rms in row.rms_deg.items():
        cells[f"{axis}: RMS of a segment, °"] = _LOST if rms is None else _said(rms)
    tip = row.tip_rms_m
    cells["tip, RMS, mm"] = "not known" if tip is None else _said(1e3 * tip)
    if "h" in fitted.joint.axes:
        found = row.deviations if isinstance(row, Without) else fitted.standard_deviations.axes
        rms, values = row.elongation_rms_percent, found["h"]
        cells["elongation, RMS, %"] = _LOST if rms is None else _said(rms)
        cells["of a section, RMS, mm"] = _LOST if values is None else _section_mm(fitted, values)
    return cells


def _section_mm(fitted: Fit, shares: Sequence[float]) -> str:
    """Root mean square error of a section's length; its share of it is known of each section."""
    geometry = fitted.joint.geometry
    lengths = [count * geometry.segment_length for count in geometry.sections]
    errors = [share * length for share, length in zip(shares, lengths, strict=True)]
    return _said(1e3 * math.hypot(*errors) / math.sqrt(len(errors)))


def _serving(fitted: Fit, sensor: int) -> dict[str, Any]:
    """Standard deviations of what a sensor tells of while it is missing, and what is lost then."""
    row, every = fitted.without[sensor], range(len(fitted.without))
    read = [axis for axis in fitted.joint.axes if sensor in every[fitted.sensed.own(axis)]]
    told = {axis: row.deviations[axis] for axis in read}
    return {
        "sensor": row.sensor,
        "lost": [axis for axis, values in told.items() if values is None],
        "axes": {
            axis: _steps(fitted.model, axis, values)
            for axis, values in told.items()
            if values is not None
        },
        "tip_um": None if row.tip_rms_m is None else _micrometres(row.tip_rms_m),
    }


def _steps(model: FixedPointModel, axis: str, values: Sequence[float]) -> list[int]:
    """Angles or shares in steps of an axis, rounded up."""
    return [math.ceil(value * 2.0 ** model.axis(axis).fraction_bits) for value in values]


def _micrometres(metres: float) -> int:
    """Rounded up."""
    return math.ceil(1e6 * metres)


def _said(value: float) -> str:
    return f"{value:.3g}" if value > _NOTHING else "0"
