"""One recording of a joint: what its files hold, in radians and metres, checked for sense."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.joint import RecordingFile
from ccgen.joint.recordings import CAN_LOGS
from ccgen.kinematics.rotations import from_quaternions
from ccgen.recordings import checks
from ccgen.recordings.columns import Columns, Expected, sorted_columns
from ccgen.recordings.movement import check_motion
from ccgen.recordings.sensors import RecordedSensors
from ccgen.recordings.table import Table, read_table

Floats = NDArray[np.float64]

BASE = "base"
"""The body whose axes are those of the base; where it has an orientation, at 0 unless stated."""


@dataclass(frozen=True)
class Extent:
    """What a recording is held against."""

    segments: int
    sections: int
    length: float
    """Of the unbent joint, metres."""
    range_of_motion: float
    """Largest bending per segment and axis, radians."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body or marker that was followed; NaN where it was not seen."""

    name: str
    station: float | None
    """Its place along the neutral axis, metres from the base; None for a marker of the base."""
    position: Floats
    """Shape (N, 3), metres, in the recording's frame."""
    orientation: Floats | None
    """Shape (N, 3, 3), rotation matrices; None where it has none."""


@dataclass(frozen=True, eq=False)
class Counts:
    """Raw counts with the times at which they were read."""

    t: Floats
    """Shape (K,), seconds, never running back."""
    values: Floats
    """Shape (K, n), counts in the joint's order of sensors; NaN for no reading."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording as its files hold it: reference and counts on clocks of their own."""

    file: RecordingFile
    """What the joint file says of it."""
    hashes: tuple[tuple[str, str], ...]
    """Every file that was read, as the joint file names it, with its SHA-256."""
    t: Floats
    """Of the reference, shape (N,), seconds; the number of the row where the file has no times."""
    timed: bool
    """Whether `t` are seconds."""
    u: Floats | None
    """Segment angles about x, shape (N, segments), radians; None without."""
    v: Floats | None
    """Segment angles about y, shape (N, segments), radians; None without."""
    h: Floats | None
    """Elongation, shape (N, sections), share of the length; None without."""
    bodies: tuple[Body, ...]
    """Those that the joint file names: markers of the base alone, then in order of stations."""
    counts: Counts | None
    """None where nothing was read by sensors."""
    notes: tuple[str, ...] = field(default=())
    """What a reader of results should know, a line each."""

    @property
    def rows(self) -> int:
        """Rows N of the reference."""
        return len(self.t)

    @property
    def dense(self) -> bool:
        """Whether segment angles are given rather than bodies."""
        return self.u is not None

    @property
    def source(self) -> str:
        """How messages name the recording."""
        return str(self.file.path(self.file.file))

    def within(self, interval: tuple[float, float], t: Floats | None = None) -> NDArray[np.bool_]:
        """Return which rows lie within an interval of time, shape (N,) or that of `t`."""
        times = self.t if t is None else t
        return (times >= interval[0]) & (times <= interval[1])


def read_recording(
    file: RecordingFile, sensors: RecordedSensors, extent: Extent, poses: bool = False
) -> Recording:
    """Read the files of a recording.

    Args:
        file: which they are, and what the joint file says of them.
        sensors: those of the joint.
        extent: how long the joint is and how far it bends.
        poses: whether a few rows of angles will do, poses that the joint was held in.

    Raises:
        InputError: in one line file, line or column, what is wrong, what would be right.
    """
    path = file.path(file.file)
    table = read_table(path)
    expected = Expected(sensors.names, extent.segments, extent.sections, _named_bodies(file))
    if file.rows is not None:
        table = _chosen(table, file.rows)
    columns = sorted_columns(table, expected)
    few = poses and columns.u is not None and 0 < len(table.values) < checks.FEWEST_ROWS
    if not few:
        checks.check_rows(table)
    if columns.t is not None:
        checks.check_time(table, columns.t)
    u, v = _angles(table, columns, extent)
    recording = Recording(
        file=file,
        hashes=((file.file, table.sha256),),
        t=np.arange(len(table.values), dtype=np.float64) if columns.t is None else columns.t,
        timed=columns.t is not None,
        u=u,
        v=v,
        h=columns.h,
        bodies=_bodies(table, columns, file, extent),
        counts=None,
    )
    recording = _with_counts(recording, table, columns, sensors, expected)
    _check_stated(recording)
    if not few:
        _check_moves(recording, extent)
    return recording


def _named_bodies(file: RecordingFile) -> tuple[str, ...]:
    """Names of bodies in the joint file."""
    return tuple(dict.fromkeys((*(file.base or ()), *dict(file.stations))))


def _stations(file: RecordingFile, columns: Columns) -> dict[str, float]:
    """Stations of bodies in their order, that of the base among them where it shows its axes."""
    stations = dict(sorted(file.stations, key=lambda item: item[1]))
    if not stations or file.base is not None or BASE in stations:
        return stations
    shown = bool(np.isfinite(columns.orientations.get(BASE, np.nan)).any())
    return ({BASE: 0.0} if shown else {}) | stations


def _chosen(table: Table, rows: tuple[int, int]) -> Table:
    first, last = rows
    if last >= len(table.values):
        raise InputError(
            f"{table.source}: rows = [{first}, {last}] asks for more than its "
            f"{len(table.values)} rows; write rows from 0 to {len(table.values) - 1}"
        )
    return table.rows(first, last)


def _angles(table: Table, columns: Columns, extent: Extent) -> tuple[Floats | None, Floats | None]:
    """Segment angles of both axes, in radians; checks the elongation beside them."""
    if columns.h is not None:
        checks.check_elongation(table, columns.h)
    if columns.u is None or columns.v is None:
        return None, None
    checks.check_angles(table, columns.u, columns.v, extent.range_of_motion)
    return np.radians(columns.u), np.radians(columns.v)


def _bodies(
    table: Table, columns: Columns, file: RecordingFile, extent: Extent
) -> tuple[Body, ...]:
    stations = _stations(file, columns)
    bodies = []
    for name in (*(name for name in file.base or () if name not in stations), *stations):
        checks.check_appears(table, name, columns.positions)
        checks.check_places(table, name, columns.positions[name])
        quaternions = columns.orientations.get(name)
        if quaternions is not None:
            checks.check_quaternions(table, name, quaternions)
        seen = quaternions is not None and not np.isnan(quaternions).all()
        bodies.append(
            Body(
                name=name,
                station=stations.get(name),
                position=columns.positions[name],
                orientation=from_quaternions(quaternions)
                if seen and quaternions is not None
                else None,
            )
        )
    checks.check_distances(
        table.source, [(b.name, b.station, b.position) for b in bodies], extent.length
    )
    return tuple(bodies)


def _with_counts(
    recording: Recording,
    table: Table,
    columns: Columns,
    sensors: RecordedSensors,
    expected: Expected,
) -> Recording:
    """Add the counts, from the table itself or from the file beside it."""
    file = recording.file
    bends = recording.u is not None or recording.v is not None or bool(recording.bodies)
    if file.counts is None:
        if columns.counts is None:
            return recording
        values, notes = checks.usable_counts(table.source, columns.counts, sensors, bends)
        return replace(recording, counts=Counts(recording.t, values), notes=notes)
    if columns.counts is not None:
        raise InputError(
            f"{table.source}: holds counts, and so does {file.counts}; remove counts from "
            "[[recordings]], or the columns from the file"
        )
    if not recording.timed:
        raise InputError(
            f"{table.source}: has no column t, without which {file.counts} cannot be laid beside "
            "it; add the times in seconds"
        )
    counts, hashes, logged = _separate_counts(file, sensors, expected)
    values, notes = checks.usable_counts(str(file.path(file.counts)), counts.values, sensors, bends)
    return replace(
        recording,
        counts=Counts(counts.t, values),
        hashes=recording.hashes + hashes,
        notes=logged + notes,
    )


def _separate_counts(
    file: RecordingFile, sensors: RecordedSensors, expected: Expected
) -> tuple[Counts, tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Counts of the file beside, the hashes of what was read, and what to say of it."""
    assert file.counts is not None
    path = file.path(file.counts)
    if path.suffix.lower() in CAN_LOGS:
        return _logged_counts(file, sensors)
    table = read_table(path)
    columns = sorted_columns(table, expected)
    if columns.t is None:
        raise InputError(f"{table.source}: has no column t; add the times in seconds")
    if columns.counts is None:
        raise InputError(
            f"{table.source}: has no counts; write columns such as count_{sensors.names[0]}"
        )
    checks.check_rows(table)
    checks.check_time(table, columns.t)
    return Counts(columns.t, columns.counts), ((file.counts, table.sha256),), ()


def _logged_counts(
    file: RecordingFile, sensors: RecordedSensors
) -> tuple[Counts, tuple[tuple[str, str], ...], tuple[str, ...]]:
    from ccgen.recordings.can_log import read_can_log

    assert file.counts is not None
    assert file.dbc is not None
    path = file.path(file.counts)
    log = read_can_log(path, file.path(file.dbc), sensors.names)
    hashes = tuple(zip((file.counts, file.dbc), log.sha256, strict=True))
    notes = (f"{path}: {log.damaged} frames failed their check",) if log.damaged else ()
    return Counts(log.t, log.counts), hashes, notes


def _check_stated(recording: Recording) -> None:
    """Check what the joint file says of the recording, and that it holds anything of use."""
    file = recording.file
    stated = {name: getattr(file, name) for name in ("straight", "zero_from", "delay")}
    for name, value in stated.items():
        if value is not None and not recording.timed:
            raise InputError(
                f"{recording.source}: has no column t, but {name} is stated in seconds; "
                f"add the times, or remove {name}"
            )
    if not recording.dense and not recording.bodies and recording.counts is None:
        raise InputError(
            f"{recording.source}: has neither angles nor counts, and [[recordings]] names no "
            "stations; write stations = { tip = ... } for the bodies in it"
        )
    for name in ("straight", "zero_from"):
        interval = getattr(file, name)
        if interval is not None:
            checks.check_interval(recording.source, name, interval, recording.t)
    if file.delay is not None and recording.counts is not None:
        checks.check_delay(recording.source, file.delay, recording.t, recording.counts.t)


def _check_moves(recording: Recording, extent: Extent) -> None:
    if recording.dense or recording.bodies:
        check_motion(
            recording.source,
            [recording.u, recording.v],
            [body.position for body in recording.bodies],
            extent.length,
            extent.range_of_motion,
        )
