"""Tables 2 to 4 from the joints' results."""

import csv
import io
import json
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ccgen.study.joints import EXTRA_CELLS, PAPER_CALL, all_joints
from ccgen.study.paper import (
    SENSORS,
    TABLE_2,
    TABLE_3_CELLS,
    TABLE_3_DECREASE,
    TABLE_4_CELLS,
    TABLE_4_DECREASE,
    WAM,
    Cell,
    Quartiles,
)
from ccgen.study.run import Record

Row = dict[str, Any]


def table2(records: Sequence[Record]) -> dict[str, Any]:
    """Everything in `table2.json`: the rows of Table 2, further rows, and both without some joints.

    Joints whose s-shape lies beyond the fold of its branch are named, and the rows given without
    them too. The paper's medians are of all 80 joints: those of fewer are not compared with them,
    and `relative_difference` is None.
    """
    compared = is_compared(len(records))
    before = [record for record in records if not record["beyond_fold"]]
    return {
        "joints": len(records),
        "rows": _rows(records, TABLE_2, compared),
        "extra_rows": _rows(records, EXTRA_CELLS, compared),
        "beyond_fold": [
            {key: record[key] for key in ("segments", "range_of_motion_deg")}
            for record in records
            if record["beyond_fold"]
        ],
        "rows_without_beyond_fold": _rows(before, TABLE_2, compared),
        "extra_rows_without_beyond_fold": _rows(before, EXTRA_CELLS, compared),
    }


def is_compared(joints: int) -> bool:
    """Whether a study of so many joints is all that the paper's medians are of."""
    return joints == len(all_joints())


def not_compared(joints: int) -> str:
    """Why the difference from the paper is not given."""
    known = len(all_joints())
    return f"only {joints} of the paper's {known} joints, so no difference from its medians"


def table2_json(table: dict[str, Any]) -> bytes:
    """The contents of `table2.json`; holds no time, so that equal results are equal bytes."""
    return (json.dumps(table, indent=1, allow_nan=False) + "\n").encode()


def table3(rows: Sequence[Row]) -> list[Row]:
    """By how much WAM lowers the median of E-WAM, heuristic overlap (Table 3)."""
    return _decrease(rows, TABLE_3_CELLS, TABLE_3_DECREASE)


def table4(rows: Sequence[Row]) -> list[Row]:
    """By how much the optimised placement lowers the heuristic one's median (Table 4)."""
    return _decrease(rows, TABLE_4_CELLS, TABLE_4_DECREASE)


def find(rows: Iterable[Row], cell: Cell) -> Row:
    """The row of a cell.

    Raises:
        KeyError: there is none.
    """
    for row in rows:
        if (row["placement"], row["method"], row["sensors"]) == cell:
            return row
    raise KeyError(cell)


def table2_csv(rows: Sequence[Row]) -> bytes:
    """Rows of Table 2 as CSV, ours beside the paper's."""
    header = [
        *("placement", "method", "sensors", "median", "q1", "q3"),
        *("paper_median", "paper_q1", "paper_q3", "relative_difference"),
    ]
    return to_csv(header, ([*_values(row)] for row in rows))


def decrease_csv(rows: Sequence[Row]) -> bytes:
    """Table 3 or 4 as CSV."""
    return to_csv(list(rows[0]), (row.values() for row in rows))


def to_csv(header: Sequence[str], lines: Iterable[Iterable[object]]) -> bytes:
    """CSV with a header and Unix line ends."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return text.getvalue().encode()


def _values(row: Row) -> list[object]:
    paper = row["paper"] or {"median": "", "q1": "", "q3": ""}
    difference = "" if row["relative_difference"] is None else row["relative_difference"]
    keys = ("placement", "method", "sensors", "median", "q1", "q3")
    return [*(row[key] for key in keys), paper["median"], paper["q1"], paper["q3"], difference]


def _rows(records: Sequence[Record], cells: Iterable[Cell], compared: bool) -> list[Row]:
    return [_row(records, cell, compared) for cell in cells] if records else []


def _row(records: Sequence[Record], cell: Cell, compared: bool) -> Row:
    placement, method, sensors = cell
    ours = _quartiles([percent(record, cell) for record in records])
    # The paper's own call is what the paper's WAM row comes from.
    paper = TABLE_2.get((placement, WAM, sensors) if method == PAPER_CALL else cell)
    difference = ours.median / paper.median - 1 if paper and compared else None
    return {
        "placement": placement,
        "method": method,
        "sensors": sensors,
        **_as_json(ours),
        "paper": None if paper is None else _as_json(paper),
        "relative_difference": difference,
    }


def percent(record: Record, cell: Cell) -> float:
    """Score of a cell on one joint, % of the range of motion."""
    return float(find(record["scores"], cell)["percent_rom"])


def _quartiles(values: Sequence[float]) -> Quartiles:
    q1, median, q3 = (float(value) for value in np.percentile(values, [25, 50, 75]))
    return Quartiles(median, q1, q3)


def _as_json(quartiles: Quartiles) -> Row:
    return {"median": quartiles.median, "q1": quartiles.q1, "q3": quartiles.q3}


def _decrease(
    rows: Sequence[Row],
    pairs: tuple[tuple[str, str], tuple[str, str]],
    paper: Sequence[float],
) -> list[Row]:
    (before_name, after_name) = (f"{placement} {method}" for placement, method in pairs)
    result = []
    for sensors, paper_decrease in zip(SENSORS, paper, strict=True):
        before, after = (find(rows, (*pair, sensors)) for pair in pairs)
        result.append(
            {
                "sensors": sensors,
                before_name: before["median"],
                after_name: after["median"],
                "decrease": before["median"] - after["median"],
                f"paper {before_name}": before["paper"]["median"],
                f"paper {after_name}": after["paper"]["median"],
                "paper decrease": paper_decrease,
            }
        )
    return result
