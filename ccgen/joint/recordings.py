"""The recordings that a joint file names: what concerns several keys of [[recordings]] at once."""

import math
from pathlib import Path, PurePath

from ccgen.joint.messages import KeyProblemError, toml_value
from ccgen.joint.specification import RecordingFile
from ccgen.joint.tables import JointTable, RecordingTable

CAN_LOGS = (".blf", ".asc", ".log")
"""Endings of files that python-can reads: Vector's binary and text logs, and candump's."""


def recording_files(table: JointTable, folder: Path) -> tuple[RecordingFile, ...]:
    """Return the recordings of a joint file.

    Args:
        table: the whole file.
        folder: where paths in it lead from.

    Raises:
        KeyProblemError: "KEY: what is wrong; what would be right".
    """
    return tuple(
        _recording(recording, f"recordings[{i}]", table.geometry.length, folder)
        for i, recording in enumerate(table.recordings)
    )


def _recording(table: RecordingTable, key: str, length: float, folder: Path) -> RecordingFile:
    _check_log(table, key)
    for name, at in table.stations.items():
        if at > length * (1 + 1e-9):
            raise KeyProblemError(
                f"{key}.stations.{name}: {at} m lies outside the joint; write metres from 0 at "
                f"the base to {length} at the tip (geometry.length)"
            )
    if table.base is not None and table.base[0] == table.base[1]:
        raise KeyProblemError(
            f'{key}.base: {toml_value(table.base)} is one marker; write two, such as ["m0", "m1"]'
        )
    noise = table.orientation_noise
    return RecordingFile(
        file=table.file,
        folder=folder,
        use=table.use,
        counts=table.counts,
        dbc=table.dbc,
        stations=tuple((name, float(at)) for name, at in table.stations.items()),
        straight=_interval(table.straight, f"{key}.straight"),
        zero_from=_interval(table.zero_from, f"{key}.zero_from"),
        base=None if table.base is None else (table.base[0], table.base[1]),
        position_noise=table.position_noise,
        orientation_noise=None if noise is None else math.radians(noise),
        delay=None if table.delay is None else float(table.delay),
        rows=_rows(table.rows, f"{key}.rows"),
    )


def _check_log(table: RecordingTable, key: str) -> None:
    """Check that a CAN log has its DBC, and that a DBC has its log."""
    if PurePath(table.file).suffix.lower() in CAN_LOGS:
        raise KeyProblemError(
            f"{key}.file: {toml_value(table.file)} is a CAN log; write the CSV file of the "
            "reference there, and the log as counts"
        )
    log = table.counts is not None and PurePath(table.counts).suffix.lower() in CAN_LOGS
    if log and table.dbc is None:
        raise KeyProblemError(
            f"{key}.dbc: missing, but counts is a CAN log; write the DBC file that describes it, "
            'such as dbc = "finger.dbc"'
        )
    if table.dbc is not None and not log:
        raise KeyProblemError(
            f"{key}.dbc: describes CAN logs, but counts is none; write a file that ends in "
            f"{', '.join(CAN_LOGS)} there, or remove dbc"
        )


def _interval(ends: list[float] | None, key: str) -> tuple[float, float] | None:
    if ends is None:
        return None
    first, last = ends
    if first >= last:
        what = "is empty" if first == last else "is reversed"
        raise KeyProblemError(
            f"{key}: {toml_value(ends)} {what}; write the earlier time first, in seconds"
        )
    return float(first), float(last)


def _rows(rows: list[int] | None, key: str) -> tuple[int, int] | None:
    if rows is None:
        return None
    first, last = rows
    if first > last:
        raise KeyProblemError(f"{key}: [{first}, {last}] is reversed; write [{last}, {first}]")
    return first, last
