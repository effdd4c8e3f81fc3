"""What `ccgen fit` prints."""

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ccgen.cli.fit_checks import checks_json, show_checks
from ccgen.cli.output import results, show_table

if TYPE_CHECKING:
    from ccgen.estimation.errors import ErrorRow
    from ccgen.estimation.fitted import Without
    from ccgen.fixedpoint import Fit
    from ccgen.joint import Joint

Figures = Mapping[str, Mapping[str, Any]]

_DIGITS = 3


def as_json(fit: "Fit", axes: Figures) -> dict[str, Any]:
    """The JSON object of a fit.

    Args:
        fit: the fit.
        axes: figures of each output axis.
    """
    return {
        "method": fit.method,
        "axes": axes,
        "errors": [row.record() for row in fit.errors],
        "warnings": list(fit.warnings),
        "without": [_without_json(row) for row in fit.without],
        "checks": checks_json(fit.checks),
        "unchecked": list(fit.checks.notes),
        **_stiffness_json(fit),
    }


def _without_json(row: "Without") -> dict[str, Any]:
    """Figures of a sensor lost; its standard deviations are told by exported headers."""
    figures = asdict(row)
    del figures["deviations"]
    return figures


def _stiffness_json(fit: "Fit") -> dict[str, Any]:
    """What recordings tell of the joint's stiffness, where they do."""
    told = None if fit.found is None else fit.found.stiffness
    return {} if told is None else {"stiffness_profile": asdict(told)}


def _show_stiffness(fit: "Fit") -> None:
    """Print the line for [loads] that recordings tell."""
    told = None if fit.found is None else fit.found.stiffness
    if told is not None:
        line, sure = told.lines
        results().print(f"The recordings tell, for [loads] ({sure}):", soft_wrap=True)
        results().print(line, soft_wrap=True)
        results().print(_ONLY_RATIOS, soft_wrap=True)


_ONLY_RATIOS = (
    "These are ratios: shapes alone do not tell loads.stiffness, which takes forces that are known."
)


def show_fit(fit: "Fit", axes: Figures) -> None:
    """Print a fit as tables."""
    show_axes(fit.joint, fit.method, axes)
    show_errors(fit)
    show_stations(fit)
    _show_stiffness(fit)
    _show_without(fit)
    show_checks(fit.checks, fit.joint.false_alarms)


def show_axes(joint: "Joint", method: str, axes: Figures) -> None:
    """Print the weights' figures, a column an axis."""
    from rich.table import Table

    table = Table("", title=f"{joint.name}: {method}", title_justify="left")
    for axis in axes:
        table.add_column(axis, justify="right")
    columns = [_column(figures) for figures in axes.values()]
    titles = list(dict.fromkeys(title for column in columns for title in column))
    if joint.couples:
        titles.remove("spans")  # every axis reads all sensors: `ccgen simulate` lists them
    for title in titles:
        table.add_row(title, *(column.get(title, "") for column in columns))
    show_table(table)


def _column(figures: Mapping[str, Any]) -> dict[str, str]:
    """Figures by their titles, in the order of the table."""
    smallest, largest = figures["weights_range"]
    column = {
        "sensors": str(len(figures["spans"])),
        "spans": " ".join(f"{first:g}-{last:g}" for first, last in figures["spans"]),
    }
    for key, title in _ERRORS.items():
        if key in figures:
            column[title] = "not known" if figures[key] is None else f"{figures[key]:.4g}"
    return column | {
        "noise gain": f"{figures['noise_gain']:.4g}",
        "smallest weight": f"{smallest:.4g}",
        "largest weight": f"{largest:.4g}",
    }


_ERRORS = {
    "score_percent_rom": "score / % of ROM",
    "score_with_noise_percent_rom": "with sensor noise",
    "elongation_adds_percent_rom": "1 % elongation adds",
    "rms_percent": "RMS / % of length",
    "rms_with_noise_percent": "RMS with sensor noise",
}
"""Keys of an axis' errors and the titles of their rows."""


def show_errors(fit: "Fit") -> None:
    """Print errors by source, without and with everything that is stated."""
    from rich.table import Table

    title = "Errors without / with noise, quantisation, tolerances and rounding"
    table = Table("source", title=title, title_justify="left")
    for name in _error_cells(fit.errors[0]):
        table.add_column(name, justify="right")
    for source in dict.fromkeys(row.source for row in fit.errors):
        rows = {row.noise: _error_cells(row) for row in fit.errors if row.source == source}
        plain, noisy = rows.get(False), rows[True]
        held_out = any(row.held_out for row in fit.errors if row.source == source)
        table.add_row(
            source + (" (held out)" if held_out else ""),
            *(
                value if plain is None else f"{plain[name]} / {value}"
                for name, value in noisy.items()
            ),
        )
    show_table(table)


def show_stations(fit: "Fit") -> None:
    """Print errors at the bodies and markers of recordings."""
    from rich.table import Table

    rows = [row for row in fit.errors if row.noise and row.stations]
    if not rows:
        return
    title = "Errors at bodies and markers, the reference's own noise taken off"
    table = Table("source", "station", title=title, title_justify="left")
    for name in ("place\nRMS mm", "u bend\nRMS deg", "v bend\nRMS deg", "length\nRMS mm"):
        table.add_column(name, justify="right")
    for row in rows:
        for station, own in (row.stations or {}).items():
            table.add_row(
                row.source,
                station,
                _known(1e3 * own.position_rms_m),
                *(_known(own.bend_rms_deg[axis]) for axis in ("u", "v")),
                _known(1e3 * own.arc_length_rms_m),
            )
    show_table(table)


def _known(value: float) -> str:
    return _number(None if math.isnan(value) else value)


def _error_cells(row: "ErrorRow") -> dict[str, str]:
    cells = {}
    for axis in row.mean_percent_rom:
        cells[f"{axis} mean\n% of ROM"] = _number(row.mean_percent_rom[axis])
    for axis in row.rms_deg:
        cells[f"{axis} RMS\ndeg"] = _number(row.rms_deg[axis])
    for axis in row.total_bend_rms_deg:
        cells[f"{axis} bend\nRMS deg"] = _number(row.total_bend_rms_deg[axis])
    cells["tip RMS\nmm"] = _number(1e3 * row.tip_rms_m)
    cells["tip worst\nmm"] = _number(1e3 * row.tip_max_m)
    if row.elongation_rms_percent is not None:
        cells["elongation\nRMS %"] = _number(row.elongation_rms_percent)
    return cells


def _show_without(fit: "Fit") -> None:
    from rich.table import Table

    served = "" if fit.sensed.fallback else ", if fallback were true"
    title = f"With one sensor lost, on {fit.stated.name}, with noise{served}"
    table = Table("sensor lost", title=title, title_justify="left")
    for name in (f"{axis} RMS\ndeg" for axis in fit.without[0].rms_deg):
        table.add_column(name, justify="right")
    table.add_column("tip RMS\nmm", justify="right")
    if "h" in fit.joint.axes:
        table.add_column("elongation\nRMS %", justify="right")
    for sensor, row in fit.left:
        tip = None if row.tip_rms_m is None else 1e3 * row.tip_rms_m
        stretch = [row.elongation_rms_percent] if "h" in fit.joint.axes else []
        table.add_row(
            sensor,
            *(_number(rms, "lost") for rms in row.rms_deg.values()),
            _number(tip, "not known"),
            *(_number(rms, "lost") for rms in stretch),
        )
    show_table(table)


def _number(value: float | None, unknown: str = "", digits: int = _DIGITS) -> str:
    return unknown if value is None else f"{value:.{digits}g}"
