"""Counts from a log of the bus: BLF, ASC or candump, read by python-can and decoded by cantools.

A sensor's signal is called `length_NAME`, as in the DBC that ccgen exports, or `count_NAME`, or
NAME alone. Where the DBC states an end-to-end profile (`E2EProfile`, `E2EDataId`), frames that fail
its check are left out. Frames of one counter are one sample; without a counter a sample ends where
a frame comes again.
"""

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ccgen.e2e import P01, P05, Profile, ProtectionError
from ccgen.errors import InputError
from ccgen.recordings.log_files import read_frames
from ccgen.recordings.table import read_bytes

Floats = NDArray[np.float64]

LARGEST_LOG = 512 * 2**20
MOST_SAMPLES = 1_000_000
_PREFIXES = ("length_", "count_", "")
_PROFILES = {"P01": P01, "P05": P05}


@dataclass(frozen=True, eq=False)
class CanLog:
    """What the sensors sent."""

    t: Floats
    """Of each sample's first frame, shape (K,), seconds from the log's first frame."""
    counts: Floats
    """Shape (K, n); NaN where a frame is missing or says that there is no reading."""
    damaged: int
    """Frames that failed their end-to-end check."""
    sha256: tuple[str, str]
    """Of the log and of the DBC, hexadecimal."""


@dataclass(frozen=True)
class _Frame:
    """A message of the DBC that holds sensors' signals."""

    message: Any
    sensors: tuple[tuple[int, Any], ...]
    """Index of the sensor and its signal."""
    profile: Profile | None
    data_id: int

    def counter(self, data: bytes) -> int | None:
        """Return the counter of a frame that passes its check; None without one.

        Raises:
            ProtectionError: it does not pass.
        """
        return None if self.profile is None else self.profile.check(self.data_id, data)

    def counts(self, data: bytes) -> list[tuple[int, float]]:
        """Return sensors and their raw counts; NaN for the value that says "no reading"."""
        raw = self.message.decode(data, decode_choices=False, scaling=False, allow_truncated=True)
        return [
            (j, _count(raw[signal.name], signal))
            for j, signal in self.sensors
            if signal.name in raw
        ]


def _count(raw: float, signal: Any) -> float:
    absent = signal.is_signed and raw == -(1 << (signal.length - 1))
    return math.nan if absent else float(raw)


@dataclass
class _Samples:
    """Samples collected so far; the last one is still open."""

    sensors: int
    times: "array[float]" = field(default_factory=lambda: array("d"))
    counts: "array[float]" = field(default_factory=lambda: array("d"))
    open: set[int] = field(default_factory=set)
    counter: int | None = None

    def add(
        self, t: float, frame: int, counter: int | None, counts: list[tuple[int, float]]
    ) -> None:
        """Add a frame to the open sample, or begin another."""
        if not self.open or frame in self.open or counter != self.counter:
            self.times.append(t)
            self.counts.extend([math.nan] * self.sensors)
            self.open, self.counter = set(), counter
        self.open.add(frame)
        first = len(self.counts) - self.sensors
        for j, count in counts:
            self.counts[first + j] = count


def read_can_log(path: Path, dbc: Path, sensors: Sequence[str]) -> CanLog:
    """Read the counts of sensors from a log.

    Args:
        path: the log, of a kind in `ccgen.joint.recordings.CAN_LOGS`.
        dbc: what describes its frames.
        sensors: names, in the joint's order.

    Raises:
        InputError: either file cannot be read, the DBC knows none of the sensors, the log holds
            none of their frames.
    """
    log_data, dbc_data = read_bytes(path, str(path), LARGEST_LOG), read_bytes(dbc, str(dbc))
    hashes = sha256(log_data).hexdigest(), sha256(dbc_data).hexdigest()
    frames = _frames(_database(dbc_data, dbc), dbc, sensors)
    samples, damaged, start = _Samples(len(sensors)), 0, None
    for message in read_frames(path):
        start = message.timestamp if start is None else start
        frame = frames.get((message.arbitration_id, message.is_extended_id))
        if frame is None or message.is_remote_frame or message.is_error_frame:
            continue
        data = bytes(message.data)
        try:
            counter = frame.counter(data)
            counts = frame.counts(data)
        except ProtectionError:
            damaged += 1
            continue
        samples.add(message.timestamp - start, message.arbitration_id, counter, counts)
        if len(samples.times) > MOST_SAMPLES:
            raise InputError(f"{path}: more than {MOST_SAMPLES} samples; cut it into several logs")
    if not samples.times:
        known = ", ".join(f"{identifier:#x}" for identifier, _ in list(frames)[:4])
        spoilt = f" ({damaged} failed their check)" if damaged else ""
        raise InputError(
            f"{path}: holds no frame of the sensors{spoilt}; {dbc.name} describes {known}: "
            "name the log and the DBC of one joint"
        )
    t = np.array(samples.times)
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        raise InputError(
            f"{path}: time runs back after {t[back[0]]:.6f} s; export the log in order of time"
        )
    return CanLog(t, np.array(samples.counts).reshape(len(t), len(sensors)), damaged, hashes)


def _frames(database: Any, dbc: Path, sensors: Sequence[str]) -> dict[tuple[int, bool], _Frame]:
    """Frames of the DBC that hold sensors, by identifier and whether it is extended."""
    found: dict[str, list[tuple[int, Any]]] = {}
    for j, sensor in enumerate(sensors):
        names = [f"{prefix}{sensor}" for prefix in _PREFIXES]
        homes = [
            (names.index(signal.name), message.name, signal)
            for message in database.messages
            for signal in message.signals
            if signal.name in names
        ]
        homes.sort(key=lambda home: home[0])
        if len(homes) > 1 and homes[0][0] == homes[1][0]:
            raise InputError(
                f"{dbc}: signal {homes[0][2].name} is in {homes[0][1]} and in {homes[1][1]}; "
                "keep the messages of one joint"
            )
        if homes:
            found.setdefault(homes[0][1], []).append((j, homes[0][2]))
    if not found:
        wanted = ", ".join(f"length_{sensor}" for sensor in sensors[:4])
        raise InputError(f"{dbc}: describes no signal of the sensors; it needs {wanted}, ...")
    frames = [_frame(database.get_message_by_name(name), tuple(s)) for name, s in found.items()]
    return {(f.message.frame_id, f.message.is_extended_frame): f for f in frames}


def _frame(message: Any, sensors: tuple[tuple[int, Any], ...]) -> _Frame:
    attributes = message.dbc.attributes if message.dbc is not None else {}
    stated = {
        name: attributes[name].value for name in ("E2EProfile", "E2EDataId") if name in attributes
    }
    profile = _PROFILES.get(str(stated.get("E2EProfile")))
    return _Frame(message, sensors, profile, int(stated.get("E2EDataId", 0)))


def _database(data: bytes, dbc: Path) -> Any:
    import cantools

    try:
        return cantools.database.load_string(data.decode("cp1252", "replace"), "dbc")
    except Exception as error:  # textparser and cantools share no base class
        reason = " ".join(str(error).split())
        raise InputError(f"{dbc}: is no DBC file ({reason}); export the joint again") from None
