"""What `ccgen place` finds, as a table, as JSON and as lines for the joint file."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ccgen.cli.output import note, print_json, results, show_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ccgen.joint import Joint
    from ccgen.joint.layouts import AnySpans
    from ccgen.placement import Placed, Placement
    from ccgen.shapes import Shapes

_TELLING = 0.9
"""Largest gap to a lower bound that says something about the placement."""


def show_json(joint: "Joint", placed: "Sequence[Placed]") -> None:
    """Print one object: the answer for each axis, and at the top what holds for all of them."""
    from ccgen.placement import wide_shapes

    wide = wide_shapes(joint)
    axes = {}
    for one in placed:
        if _one_by_one(one):  # one answer for all axes
            axes.update(dict.fromkeys(one.axes, _answer(joint, one.axes[0], one, wide)))
        else:
            axes.update({axis: _answer(joint, axis, one, wide) for axis in one.axes})
    answers = list(axes.values())
    shared = {
        key: value
        for key, value in answers[0].items()
        if all(other[key] == value for other in answers)
    }
    method = placed[0].estimator
    objective = placed[0].problem.objective
    print_json({**shared, "objective": objective, "estimator": method, "axes": axes})


def show(joint: "Joint", placed: "Sequence[Placed]") -> None:
    """Print a table for each part, and the lines to paste into the joint file."""
    from ccgen.placement import wide_shapes

    wide = wide_shapes(joint)
    for one in placed:
        _show_tables(joint, one, wide)
    chosen = ", ".join(f"{_named(one)}{one.best.method}" for one in placed)
    replaced = "[[sensor]]" if _lists(joint) else "placement and count"
    note(f"the best ({chosen}) for the joint file; spans replace {replaced} there:")
    if joint.calibration is not None and _one_by_one(placed[0]):
        note(f"{joint.calibration} is of the sensors as they are; calibrate again once they moved")
    lines = [_pasted(joint, one) for one in placed]
    method = placed[0].estimator
    if method != joint.method:
        note(
            f"these are the errors of {method}, not of the file's estimator {joint.method};"
            " [estimator] below chooses it"
        )
        lines.append(f'[estimator]\nmethod = "{method}"')
    results().print("\n\n".join(lines), soft_wrap=True)


def figure(joint: "Joint", placed: "Sequence[Placed]", forbidden: Sequence[int]) -> "Figure":
    """Draw the spans of all placements along the joint."""
    from ccgen.figures.placement import placement_figure

    drawn = [
        replace(placement, method=_named(one) + placement.method)
        for one in placed
        for placement in one.found
    ]
    problem = placed[0].problem
    unit = "the length at the tip" if problem.objective == "tip" else "ROM"
    names = [sensor.name for sensor in joint.sensors] if _one_by_one(placed[0]) else ()
    return placement_figure(drawn, problem.segments, forbidden, unit, names)


def _one_by_one(placed: "Placed") -> bool:
    """Whether each sensor of the joint has a span of its own."""
    return placed.table == "sensor"


def _lists(joint: "Joint") -> bool:
    """Whether the joint file lists its sensors one by one."""
    return joint.u is None and joint.v is None


def _pasted(joint: "Joint", placed: "Placed") -> str:
    """Lines for the joint file, with the best spans in segments, and in metres as a comment."""
    from ccgen.joint.pasted import sensor_tables

    spans = placed.best.spans
    if not _one_by_one(placed):
        return f"[{placed.table}]\n{_spans_lines(joint, spans)}"
    if _lists(joint):
        return sensor_tables(joint, spans)
    sets = [(axis, spans[joint.members(axis)]) for axis in placed.axes]
    return "\n\n".join(f"[sensors.{axis}]\n{_spans_lines(joint, own)}" for axis, own in sets)


def _spans_lines(joint: "Joint", spans: "AnySpans") -> str:
    segment = joint.geometry.segment_length
    metres = ", ".join(f"{a * segment:.4g} to {(b + 1) * segment:.4g}" for a, b in spans)
    return f"spans = {[list(span) for span in spans]}\n# metres from the base: {metres}"


def _named(placed: "Placed") -> str:
    """How a method's name begins where the axes are told apart."""
    return f"{placed.axes[0]}: " if len(placed.axes) == 1 and not _one_by_one(placed) else ""


def _answer(joint: "Joint", axis: str, placed: "Placed", wide: "Shapes") -> dict[str, Any]:
    described = [_describe(joint, axis, placed, one, wide) for one in placed.found]
    return {**described[placed.found.index(placed.best)], "methods": described}


def _describe(
    joint: "Joint", axis: str, placed: "Placed", placement: "Placement", wide: "Shapes"
) -> dict[str, Any]:
    from ccgen.placement import told

    found = told(joint, placed, axis, placement.spans, wide)
    seen = None
    if found.faults_percent is not None:
        seen = [
            None if percent != percent else percent for percent in found.faults_percent.tolist()
        ]
    segment = joint.geometry.segment_length
    names = {"sensors": [sensor.name for sensor in joint.sensors]} if _one_by_one(placed) else {}
    return {
        "method": placement.method,
        **names,
        "spans": [list(span) for span in placement.spans],
        "spans_m": [[first * segment, (last + 1) * segment] for first, last in placement.spans],
        "score_percent_rom": found.percent_rom,
        "score_with_noise_percent_rom": found.with_noise_percent_rom,
        "errors": [row.record() for row in found.errors],
        "visible_faults_percent": seen,
        "evaluations": placement.evaluations,
        "optimality": placement.optimality,
        "gap": placement.gap,
    }


def _show_tables(joint: "Joint", placed: "Placed", wide: "Shapes") -> None:
    from rich.table import Table

    judge = "noise-aware" if placed.estimator == "noise-aware" else "WAM"
    sensors = "1 sensor" if placed.problem.sensors == 1 else f"{placed.problem.sensors} sensors"
    table = Table(title=f"{_named(placed)}{sensors}, {judge}: error, % of ROM")
    if _one_by_one(placed):
        table.caption = f"spans of {' '.join(sensor.name for sensor in joint.sensors)}"
    table.add_column("method", no_wrap=True)
    table.add_column("spans")
    for heading in (
        "error",
        "with\nnoise",
        "faults seen\n%",
        "optimality",
        "evaluations",
    ):
        table.add_column(heading, justify="right", no_wrap=True)
    rows = _answer(joint, placed.axes[0], placed, wide)["methods"]
    for row in rows:
        expected = row["score_with_noise_percent_rom"]
        table.add_row(
            row["method"],
            " ".join(f"{first}-{last}" for first, last in row["spans"]),
            f"{row['score_percent_rom']:.4g}",
            "unknown" if expected is None else f"{expected:.4g}",
            _faults(row["visible_faults_percent"]),
            _optimality(row["optimality"], row["gap"]),
            str(row["evaluations"]),
        )
    show_table(table)
    _show_errors(rows)


def _show_errors(rows: Sequence[dict[str, Any]]) -> None:
    """Print what `ccgen fit` would tell of each placement, with noise, by source."""
    from rich.table import Table

    table = Table(title="Errors with noise and tolerances")
    table.add_column("method", no_wrap=True)
    table.add_column("source")
    headings = ("RMS\ndeg", "bend RMS\ndeg", "tip RMS\nmm", "tip worst\nmm")
    stretched = rows[0]["errors"][0]["elongation_rms_percent"] is not None
    for heading in (*headings, *(("elongation\nRMS %",) if stretched else ())):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        for error in (one for one in row["errors"] if one["noise"]):
            stretch = [f"{error['elongation_rms_percent']:.3g}"] if stretched else []
            table.add_row(
                row["method"],
                error["source"],
                f"{max(error['rms_deg'].values()):.3g}",
                f"{max(error['total_bend_rms_deg'].values()):.3g}",
                f"{1e3 * error['tip_rms_m']:.3g}",
                f"{1e3 * error['tip_max_m']:.3g}",
                *stretch,
            )
    show_table(table)


def _faults(percents: list[float | None] | None) -> str:
    """The range of the sensors' smallest visible faults; "none" where one has none."""
    if percents is None:
        return "unknown"
    known = [percent for percent in percents if percent is not None]
    if not known:
        return "none"
    largest = f"{max(known):.3g}" if len(known) == len(percents) else "none"
    return f"{min(known):.3g} to {largest}"


def _optimality(optimality: str, gap: float | None) -> str:
    if optimality != "bound" or gap is None:
        return optimality
    return f"gap {100 * gap:.0f} %" if gap < _TELLING else "not proven"
