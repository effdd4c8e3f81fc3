"""The counts of a recording's table by themselves, as raw as they were read."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.recordings.checks import check_time
from ccgen.recordings.columns import Expected, sorted_columns
from ccgen.recordings.table import read_table

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]


def read_counts(path: Path, joint: "Joint") -> tuple[Floats | None, Floats]:
    """Read times, shape (N,) in seconds, None without a column, and counts, shape (N, n).

    Args:
        path: a recording's CSV.
        joint: whose sensors it names.

    Raises:
        InputError: as of `ccgen.recordings.table.read_table`; or it names no sensor of the joint.
    """
    table = read_table(path)
    names = tuple(sensor.name for sensor in joint.sensors)
    geometry = joint.geometry
    columns = sorted_columns(table, Expected(names, geometry.segments, len(geometry.sections)))
    if columns.counts is None or not len(table.values):
        raise InputError(
            f"{path}: holds no counts; write a column a sensor, such as count_{names[0]}"
        )
    if columns.t is not None:
        check_time(table, columns.t)
    return columns.t, columns.counts
