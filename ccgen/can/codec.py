"""Counts to protected frames and frames to angles, tip and status, all through the joint's DBC.

Values are the raw integers of the DBC's signals, the same numbers the estimator works with; what
a step is worth in metres or radians stands in the DBC.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import can
import cantools
from cantools.database import Database
from cantools.database.can import Message as DbcMessage

from ccgen.can.layout import FrameLayout, FrameSpec, Kind
from ccgen.e2e import P01, P05, ProtectionError
from ccgen.errors import InputError


@dataclass(frozen=True, slots=True)
class Decoded:
    """A frame that passed its checks.

    Attributes:
        kind: which sort of frame.
        index: which one of its kind, from 0.
        number: of its snapshot; the own counter of STATUS, HEALTH and COMMAND frames.
        values: the payload's raw values in the order of the layout.
    """

    kind: Kind
    index: int
    number: int
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Refused:
    """A frame under one of the joint's identifiers that failed its checks.

    Attributes:
        kind: which sort of frame its identifier is of.
        reason: as the keys of `Codec.errors`; "remote" for a request, which is nobody's data.
    """

    kind: Kind
    reason: Literal["crc", "format", "remote"]


@dataclass(frozen=True)
class Status:
    """A decoded STATUS frame."""

    sample_counter: int
    missing_sensors: int
    faults: int
    age_ms: int


@dataclass(frozen=True)
class Health:
    """A decoded HEALTH frame: what `ccgen.can.layout` says of its signals."""

    fingerprint: int
    suspected_sensors: int
    axis_u: int
    axis_v: int
    axis_h: int
    zero: int
    last_command: int
    result: int


@dataclass(frozen=True)
class _Entry:
    spec: FrameSpec
    index: int
    message: DbcMessage
    names: tuple[str, ...]

    @property
    def has_turn(self) -> bool:
        return any(signal.quantity == "turn" for signal in self.spec.signals)


def read_database(path: Path) -> Database:
    """Read a DBC file.

    Raises:
        InputError: it is missing or is no DBC.
    """
    try:
        database = cantools.database.load_file(path, database_format="dbc", strict=True)
    except OSError as error:
        raise InputError(
            f"{path}: {error.strerror}; name a folder that `ccgen export` wrote"
        ) from error
    except (cantools.Error, UnicodeDecodeError) as error:
        raise InputError(f"{path}: damaged ({error}); export the joint again") from error
    if not isinstance(database, Database):
        raise InputError(f"{path}: describes no CAN frames; export the joint again")
    return database


class Codec:
    """Encodes and decodes the frames of one joint; counts what it refuses in `errors`.

    `errors` has the keys "crc" (a checksum that does not hold) and "format" (a wrong length, kind
    of frame or counter). Frames of other identifiers are none of the joint's and not counted.
    """

    def __init__(self, layout: FrameLayout, database: Database) -> None:
        """Check once that the DBC describes the layout.

        Raises:
            InputError: it does not; the message names the frame.
        """
        self.layout = layout
        self.errors: Counter[str] = Counter()
        self._profile = P05 if layout.fd else P01
        self._entries = {entry.spec.id: entry for entry in _entries(layout, database)}
        self._lengths = [e for e in self._entries.values() if e.spec.kind == "lengths"]

    def encode(self, counts: Sequence[int], number: int) -> list[can.Message]:
        """LENGTHS frames of one snapshot.

        Args:
            counts: shape (n,), Python integers, in the order of the sensors.
            number: of the snapshot, 0..`numbers` - 1 of the layout.

        Raises:
            ValueError: wrong number of counts, one that its signal cannot hold, or a number that
                there is not.
        """
        if len(counts) != len(self.layout.sensors):
            raise ValueError(f"{len(counts)} counts for {len(self._lengths)} LENGTHS frames")
        messages, first = [], 0
        for entry in self._lengths:
            part = counts[first : first + len(entry.names)]
            first += len(entry.names)
            messages.append(self._message(entry, part, number))
        return messages

    def encode_frame(
        self, kind: Kind, index: int, values: Sequence[int], number: int
    ) -> can.Message:
        """One frame of any kind, for what plays the node's part."""
        entry = self._entries[self.layout.frames_of(kind)[index].id]
        return self._message(entry, values, number)

    def decode(self, message: can.Message) -> Decoded | None:
        """Check and decode one frame.

        Returns:
            None for a frame that is not the joint's, or that is refused and counted.
        """
        found = self.examine(message)
        if isinstance(found, Refused):
            if found.reason != "remote":
                self.errors[found.reason] += 1
            return None
        return found

    def examine(self, message: can.Message) -> Decoded | Refused | None:
        """Check and decode one frame, and say what is wrong with it; counts nothing.

        Returns:
            None for a frame that is not the joint's.
        """
        entry = self._entries.get(message.arbitration_id)
        if entry is None or message.is_extended_id != self.layout.extended:
            return None
        if message.is_error_frame:
            return None  # the bus itself
        if message.is_remote_frame:
            return Refused(entry.spec.kind, "remote")
        if not self._well_formed(message, entry):
            return Refused(entry.spec.kind, "format")
        try:
            counter = self._profile.check(entry.spec.data_id, message.data)
        except ProtectionError as error:
            return Refused(entry.spec.kind, error.kind)
        signals = entry.message.decode_simple(
            bytes(message.data), decode_choices=False, scaling=False
        )
        values = cast("tuple[int, ...]", tuple([signals[name] for name in entry.names]))
        turn = cast("int", signals.get("turn", 0))
        number = turn * self.layout.counter_modulus + counter
        return Decoded(entry.spec.kind, entry.index, number, values)

    def _well_formed(self, message: can.Message, entry: _Entry) -> bool:
        return len(message.data) == entry.spec.length and message.is_fd == self.layout.fd

    def _message(self, entry: _Entry, values: Sequence[int], number: int) -> can.Message:
        turn, counter = divmod(number, self.layout.counter_modulus)
        signals = dict(zip(entry.names, values, strict=True), crc=0, counter=counter)
        if entry.has_turn:
            signals["turn"] = turn
        elif turn != 0:
            raise ValueError(f"{entry.spec.name} has no number {number}")
        try:
            data = entry.message.encode(signals, scaling=False, strict=False)
        except (OverflowError, cantools.Error) as error:
            raise ValueError(f"{entry.spec.name}: {error}") from error
        return can.Message(
            arbitration_id=entry.spec.id,
            is_extended_id=self.layout.extended,
            is_fd=self.layout.fd,
            bitrate_switch=self.layout.rate_switch,
            data=self._profile.protect(entry.spec.data_id, counter, data),
        )


def status_of(decoded: Decoded) -> Status:
    """Return the fields of a decoded STATUS frame."""
    return Status(*decoded.values)


def health_of(decoded: Decoded) -> Health:
    """Return the fields of a decoded HEALTH frame."""
    return Health(*decoded.values)


def _entries(layout: FrameLayout, database: Database) -> list[_Entry]:
    found: list[_Entry] = []
    for spec in layout.used_frames:
        try:
            message = database.get_message_by_name(spec.name)
        except KeyError as error:
            raise InputError(
                f"the DBC lacks the frame {spec.name}; export the joint again"
            ) from error
        described = [(s.name, s.start, s.length, s.is_signed) for s in message.signals]
        expected = [(s.name, s.start, s.bits, s.signed) for s in spec.signals]
        if (message.frame_id, message.length, described) != (spec.id, spec.length, expected):
            raise InputError(f"the DBC describes {spec.name} otherwise; export the joint again")
        index = sum(entry.spec.kind == spec.kind for entry in found)
        found.append(_Entry(spec, index, message, tuple(s.name for s in spec.payload)))
    return found
