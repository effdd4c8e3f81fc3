"""The files of a finished study."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ccgen.figures.style import figure_bytes
from ccgen.figures.table import table_figure
from ccgen.outputs import write_file
from ccgen.study.figure7 import figure7, figure7_csv
from ccgen.study.figure8 import figure8, figure8_csv
from ccgen.study.report import number, report
from ccgen.study.run import Record
from ccgen.study.tables import (
    Row,
    decrease_csv,
    table2,
    table2_csv,
    table2_json,
    table3,
    table4,
)

FORMATS = ("svg", "png")


def write_files(folder: Path, records: Sequence[Record]) -> dict[str, Any]:
    """Write tables, figures and report of a study; the same results give the same bytes.

    Args:
        folder: where to.
        records: results of the joints, in order.

    Returns:
        What stands in `table2.json`.

    Raises:
        InputError: the folder cannot be written.
    """
    table = table2(records)
    rows, all_rows = table["rows"], table["rows"] + table["extra_rows"]
    csvs = {"table2": table2_csv(all_rows), "figure7": figure7_csv(rows), "figure8": figure8_csv()}
    figures = {
        "figure7": figure7(rows, table["joints"]),
        "figure8": figure8(),
    }
    for name, title, lines in (
        ("table3", "Table 3: median, heuristic overlap, % of range of motion", table3(rows)),
        ("table4", "Table 4: median, WAM, % of range of motion", table4(rows)),
    ):
        csvs[name] = decrease_csv(lines)
        figures[name] = _decrease_figure(title, lines)
    drawn = {
        (name, kind): figure_bytes(figure, kind)
        for name, figure in figures.items()
        for kind in FORMATS
    }
    for name, data in csvs.items():
        write_file(folder / f"{name}.csv", data)
    for (name, kind), data in drawn.items():
        write_file(folder / f"{name}.{kind}", data)
    html = report(records, table, drawn["figure7", "svg"], drawn["figure8", "svg"])
    write_file(folder / "report.html", html)
    write_file(folder / "table2.json", table2_json(table))
    return table


def _decrease_figure(title: str, rows: Sequence[Row]) -> Any:
    header = [key.replace(" ", "\n", 1) for key in rows[0]]
    lines = [
        [str(row["sensors"]), *(number(value) for key, value in row.items() if key != "sensors")]
        for row in rows
    ]
    return table_figure(title, header, lines)
