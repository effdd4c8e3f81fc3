"""The tables of the page: texts of cells, numbers with three digits."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ccgen.can.layout import layout_for
from ccgen.can.load import frame_bits, load_percent
from ccgen.errors import FormatError
from ccgen.sensing.arrangement import angle_degrees

if TYPE_CHECKING:
    from ccgen.estimation.errors import ErrorRow
    from ccgen.fixedpoint import Fit

_OF = {"u": "ROM", "v": "ROM", "h": "length"}


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        header: titles of the columns.
        rows: texts of the cells.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def number(value: float | None, unknown: str = "–") -> str:
    """Three digits; what is not known is a dash."""
    return unknown if value is None or value != value else f"{value:.3g}"


def facts(fit: "Fit") -> tuple[tuple[str, str], ...]:
    """What a reader wants to know first: label and value."""
    joint, geometry = fit.joint, fit.joint.geometry
    found = fit.standard_deviations
    bends = [np.sqrt(np.mean(np.square(found.axes[axis]))) for axis in joint.axes if axis != "h"]
    return (
        ("segments", f"{geometry.segments}"),
        ("length", f"{1e3 * geometry.length:.4g} mm"),
        ("range of a segment", f"±{np.degrees(geometry.range_of_motion):.3g}°"),
        ("sensors", f"{len(joint.sensors)}"),
        ("axes", ", ".join(joint.axes)),
        ("method", fit.method),
        ("RMS of a segment", f"{number(float(np.degrees(max(bends))))}°"),
        ("RMS of the tip", f"{number(1e3 * found.tip_m)} mm"),
    )


def warnings(fit: "Fit") -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What to know before relying on the fit: of the joint, and of single recordings.

    Recordings go by their names in the joint file, together where the same is said of them.
    """
    names = {one.source: f"recording:{one.file.file}" for one in fit.recordings}
    own: list[str] = []
    of_recordings: dict[str, list[str]] = {}
    for warning in fit.warnings:
        for source, name in names.items():
            start = next((s for s in (source, name) if warning.startswith(f"{s}: ")), None)
            if start is not None:
                of_recordings.setdefault(warning[len(start) + 2 :], []).append(name)
                break
        else:
            own.append(warning)
    told = (f"{', '.join(who)}: {said}" for said, who in of_recordings.items())
    return tuple(own), tuple(told)


def sensors(fit: "Fit") -> Table:
    """Where every sensor runs, and what it is."""
    length = 1e3 * fit.sensed.geometry.segment_length
    return Table(
        ("sensor", "from mm", "to mm", "angle °", "radius mm", "µm a count", "noise mm"),
        tuple(
            (
                sensor.name,
                number(length * sensor.start),
                number(length * sensor.end),
                f"{angle_degrees(sensor):.4g}",
                number(1e3 * sensor.radius),
                number(1e6 * sensor.metres_per_count),
                number(None if sensor.noise is None else 1e3 * sensor.noise),
            )
            for sensor in fit.sensed.sensors
        ),
    )


def errors(fit: "Fit") -> Table:
    """Errors by source, without and with noise, as `ccgen fit` tells them."""
    first = _cells(fit.errors[0])
    rows = []
    for source in dict.fromkeys(row.source for row in fit.errors):
        own = {row.noise: row for row in fit.errors if row.source == source}
        plain, noisy = own.get(False), own[True]
        told = _cells(noisy)
        if plain is not None:
            told = {key: f"{value} / {told[key]}" for key, value in _cells(plain).items()}
        rows.append((source + (" (held out)" if noisy.held_out else ""), *told.values()))
    return Table(("shapes", *first), tuple(rows))


def _cells(row: "ErrorRow") -> dict[str, str]:
    cells = {f"{axis}, % of ROM": number(v) for axis, v in row.mean_percent_rom.items()}
    cells |= {f"{axis} RMS °": number(value) for axis, value in row.rms_deg.items()}
    cells |= {f"{axis} bend RMS °": number(v) for axis, v in row.total_bend_rms_deg.items()}
    cells["tip RMS mm"] = number(1e3 * row.tip_rms_m)
    cells["tip worst mm"] = number(1e3 * row.tip_max_m)
    if row.elongation_rms_percent is not None:
        cells["elongation RMS %"] = number(row.elongation_rms_percent)
    return cells


def stations(fit: "Fit") -> Table | None:
    """Errors at bodies and markers of recordings; None without any."""
    rows = [
        (
            row.source,
            name,
            number(1e3 * own.position_rms_m),
            *(number(own.bend_rms_deg[axis]) for axis in ("u", "v")),
            number(1e3 * own.arc_length_rms_m),
        )
        for row in fit.errors
        if row.noise
        for name, own in (row.stations or {}).items()
    ]
    header = ("recording", "station", "place RMS mm", "u RMS °", "v RMS °", "length RMS mm")
    return Table(header, tuple(rows)) if rows else None


def without(fit: "Fit") -> Table:
    """What is left with each single sensor lost."""
    bends, stretch = tuple(fit.without[0].rms_deg), "h" in fit.joint.axes
    return Table(
        (
            "sensor lost",
            *(f"{axis} RMS °" for axis in bends),
            "tip RMS mm",
            *(("elongation RMS %",) if stretch else ()),
        ),
        tuple(
            (
                sensor,
                *(number(row.rms_deg[axis], "lost") for axis in bends),
                number(None if row.tip_rms_m is None else 1e3 * row.tip_rms_m),
                *((number(row.elongation_rms_percent, "lost"),) if stretch else ()),
            )
            for sensor, row in fit.left
        ),
    )


def checks(fit: "Fit") -> Table | None:
    """Faults that are seen; None where no sensor is held against the others."""
    if not fit.checks.groups:
        return None
    rows = [
        (
            row.sensor,
            "not" if row.detectable_m is None else number(1e3 * row.detectable_m),
            number(row.detectable_percent),
            "" if row.detectable_m is None else ("yes" if row.isolable else "no"),
            "not" if row.isolated_m is None else number(1e3 * row.isolated_m),
        )
        for row in fit.checks.sensors
    ]
    header = ("sensor", "seen from mm", "% of largest", "named then", "named from mm")
    return Table(header, tuple(rows))


def fixed_point(fit: "Fit") -> Table | None:
    """Formats and what they add; None where none fits."""
    try:
        axes = fit.model.axes
    except FormatError:
        return None
    titles = ("axis", "bits", "fraction bits", "shift", "headroom bits", "adds at most", "RMS")
    return Table(
        titles,
        tuple(
            (
                name,
                str(axis.precision),
                str(axis.fraction_bits),
                str(axis.shift),
                str(axis.headroom_bits),
                f"{axis.worst_error_percent_rom:.2g} % of {_OF[name]}",
                f"{axis.rms_error_percent_rom:.2g} %",
            )
            for name, axis in axes.items()
        ),
    )


def bus(fit: "Fit") -> Table | None:
    """Frames of the joint and their share of the bus; None where no fixed point fits."""
    try:
        layout = layout_for(fit.joint, fit.model.readings)
    except FormatError:
        return None
    can = fit.joint.can
    load = load_percent(layout, can.bitrate)
    return Table(
        ("what", "value"),
        (
            ("bus", f"CAN{' FD' if can.fd else ''}, {can.bitrate:,} bit/s"),
            ("identifiers", f"{layout.base_id:#x} to {layout.last_id:#x}"),
            ("cycle", f"{can.cycle_ms} ms"),
            ("frames of lengths", str(layout.lengths_frames)),
            ("frames of an answer", str(layout.answer_frames)),
            (
                "bits of a frame, at most",
                str(max(frame_bits(layout, frame) for frame in layout.used_frames)),
            ),
            ("load, at most", f"{load:.3g} %"),
        ),
    )
