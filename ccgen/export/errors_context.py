"""What the templates tell of errors: a fit's table, and the standard deviations of its values."""

import math
from collections.abc import Callable
from typing import Any

from ccgen.estimation.errors import ErrorRow
from ccgen.fixedpoint import Fit
from ccgen.fixedpoint.model import FixedPointModel

_NOTHING = 1e-12
"""Degrees, metres and per cent below which an error is rounding alone."""

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
        steps = [math.ceil(value * 2.0 ** model.axis(axis).fraction_bits) for value in values]
        unit = 100.0 if axis == "h" else 180.0 / math.pi
        axes[axis] = {"steps": steps, "said": [_said(unit * value) for value in values]}
    return {
        "axes": axes,
        "tip_um": math.ceil(1e6 * found.tip_m),
        "tip_mm": _said(1e3 * found.tip_m),
        "source": fitted.stated.name,
    }


def _said(value: float) -> str:
    return f"{value:.3g}" if value > _NOTHING else "0"
