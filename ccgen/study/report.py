"""The report: the paper's values beside ours, in one self-contained HTML file."""

from base64 import b64encode
from collections.abc import Sequence
from itertools import groupby
from typing import Any

from ccgen import resources
from ccgen.study.figure8 import LENGTH
from ccgen.study.paper import DEM, E_WAM, EE, HO, OO, SENSORS, WAM
from ccgen.study.run import Record
from ccgen.study.tables import Row, find, is_compared, not_compared, percent, table3, table4

_COLUMNS = (1, *SENSORS)
_JOINT_CELLS = ((HO, WAM, 2), (HO, WAM, 3), (HO, WAM, 4), (OO, WAM, 3), (OO, WAM, 4))


def report(
    records: Sequence[Record], table: dict[str, Any], figure7: bytes, figure8: bytes
) -> bytes:
    """The report as HTML.

    Args:
        records: results of the joints.
        table: what `table2` made of them.
        figure7: SVG.
        figure8: SVG.
    """
    html = resources.template("report.html.j2").render(
        joints=table["joints"],
        not_compared=None if is_compared(table["joints"]) else not_compared(table["joints"]),
        segments=_extent(record["segments"] for record in records),
        degrees=_extent(record["range_of_motion_deg"] for record in records),
        sensors=_COLUMNS,
        groups=_groups(table["rows"]),
        extra_groups=_groups(table["extra_rows"]),
        shares=_shares(table["rows"] + table["extra_rows"]),
        decreases=_decreases(table["rows"]),
        figure7=b64encode(figure7).decode(),
        figure8=b64encode(figure8).decode(),
        length=LENGTH,
        beyond_fold=table["beyond_fold"],
        groups_before=_groups(table["rows_without_beyond_fold"]),
        extra_groups_before=_groups(table["extra_rows_without_beyond_fold"]),
        joint_header=[f"{placement}, {method}, {n}" for placement, method, n in _JOINT_CELLS],
        joint_lines=[_joint_line(record) for record in records],
    )
    return html.encode()


def number(value: float) -> str:
    """A percentage as text, three to four digits."""
    return f"{value:.2e}" if 0 < abs(value) < 1e-3 else f"{value:.4g}"


def difference(value: float | None) -> str:
    """A relative difference as text."""
    return "" if value is None else f"{100 * value:+.1f} %"


def _extent(values: Any) -> str:
    distinct = sorted(set(values))
    return str(distinct[0]) if len(distinct) == 1 else f"{distinct[0]} to {distinct[-1]}"


def _groups(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Rows as lines of a table: one for each placement and method, one cell for each count."""
    groups = []
    for (placement, method), group in groupby(rows, lambda row: (row["placement"], row["method"])):
        cells = {row["sensors"]: _cell(row) for row in group}
        empty = {"ours": "", "paper": "", "difference": ""}
        groups.append(
            {
                "name": f"{placement}, {method}",
                "cells": [cells.get(n, empty) for n in _COLUMNS],
                "has_paper": any(cell["paper"] for cell in cells.values()),
                "has_difference": any(cell["difference"] for cell in cells.values()),
            }
        )
    return groups


def _cell(row: Row) -> dict[str, str]:
    return {
        "ours": number(row["median"]),
        "paper": "" if row["paper"] is None else f"{row['paper']['median']:g}",
        "difference": difference(row["relative_difference"]),
    }


def _shares(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """By which share of the median overlap and weights lower the error."""
    steps = (
        ("overlap alone (EE, DEM → HO, E-WAM)", (EE, DEM), (HO, E_WAM)),
        ("weights alone (EE, DEM → EE, WAM)", (EE, DEM), (EE, WAM)),
        ("overlap added to weights (EE, WAM → HO, WAM)", (EE, WAM), (HO, WAM)),
    )
    return [
        {"name": name, "texts": [_share(rows, before, after, n) for n in SENSORS]}
        for name, before, after in steps
    ]


def _share(rows: Sequence[Row], before: tuple[str, str], after: tuple[str, str], n: int) -> str:
    ratio = find(rows, (*after, n))["median"] / find(rows, (*before, n))["median"]
    return f"{100 * (1 - ratio):.2f} %"


def _decreases(rows: Sequence[Row]) -> list[dict[str, Any]]:
    captions = {
        "Table 3: what fitted weights give over equal ones": table3(rows),
        "Table 4: what the optimised placement gives over the heuristic one": table4(rows),
    }
    return [
        {
            "caption": caption,
            "header": list(lines[0]),
            "lines": [
                [str(line["sensors"]), *(number(v) for k, v in line.items() if k != "sensors")]
                for line in lines
            ],
        }
        for caption, lines in captions.items()
    ]


def _joint_line(record: Record) -> list[str]:
    mark = " *" if record["beyond_fold"] else ""
    name = f"{record['segments']} × {record['range_of_motion_deg']}°{mark}"
    return [name, *(number(percent(record, cell)) for cell in _JOINT_CELLS)]
