"""A joint file or an exported folder, as one of those that share a bus."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ccgen import FORMAT_VERSION
from ccgen.can.layout import FrameLayout, layout_for
from ccgen.can.load import load_percent
from ccgen.errors import InputError
from ccgen.export.manifest import Manifest, changed_files, read_manifest
from ccgen.fixedpoint import fit
from ccgen.fixedpoint.beforehand import check_counts
from ccgen.fixedpoint.kept import kept_fit
from ccgen.fixedpoint.model import SensorRanges
from ccgen.joint import Joint
from ccgen.joint.file import read_joint
from ccgen.joint.specification import count_limits
from ccgen.targets.exported import open_exported


@dataclass(frozen=True, eq=False)
class Member:
    """One path, read.

    Attributes:
        path: as it was given.
        name: of the joint.
        joint: what the file, or the folder's copy of it, says; None where a folder cannot be read.
        layout: the joint's frames; None as `joint`.
        manifest: of a folder; None for a joint file.
        changed: files of a folder that are not what was written.
        refused: why a folder cannot be read; empty where it can.
    """

    path: Path
    name: str
    joint: Joint | None
    layout: FrameLayout | None
    manifest: Manifest | None = None
    changed: Sequence[str] = ()
    refused: str = ""


@dataclass(frozen=True, eq=False)
class Resident:
    """A joint on the bus, with all the paths that it stands at.

    Attributes:
        joint: as its file has it; as its folder has it where no file is given.
        layout: its frames.
        path: of what these are of.
    """

    joint: Joint
    layout: FrameLayout
    path: Path

    @property
    def name(self) -> str:
        """The joint's name."""
        return self.joint.name

    @property
    def identifiers(self) -> range:
        """The identifiers that are the joint's, those of frames that it leaves out included."""
        return range(self.layout.base_id, self.layout.last_id + 1)

    @cached_property
    def data_ids(self) -> frozenset[int]:
        """The data IDs of the joint's frames."""
        return frozenset(frame.data_id for frame in self.layout.frames)

    @cached_property
    def load(self) -> float:
        """Share of the bus that the joint takes at most, at its own bit rate."""
        return load_percent(self.layout, self.joint.can.bitrate) / 100.0


def read_members(paths: Sequence[Path]) -> list[Member]:
    """Read joint files and exported folders; a path that is given twice counts once.

    Raises:
        InputError: a joint file is wrong, or a folder was not written by ccgen.
    """
    different = {os.path.realpath(path): path for path in reversed(paths)}
    return [
        _folder(path) if path.is_dir() else _file(path) for path in reversed(different.values())
    ]


def residents(members: Sequence[Member]) -> list[Resident]:
    """The joints of the bus: those of the files, and of folders whose joint has no file here.

    Copies of one joint count once.
    """
    found: dict[tuple[str, bytes], Resident] = {}
    filed = {member.name for member in members if member.manifest is None}
    for member in members:
        if member.joint is None or member.layout is None:
            continue
        if member.manifest is None or member.name not in filed:
            key = member.name, member.joint.content
            found.setdefault(key, Resident(member.joint, member.layout, member.path))
    return list(found.values())


def _file(path: Path) -> Member:
    joint = read_joint(path)
    return Member(path, joint.name, joint, _layout(joint))


def _folder(path: Path) -> Member:
    manifest = read_manifest(path)
    changed = changed_files(path)
    if manifest.format != FORMAT_VERSION:
        refused = f"is of format {manifest.format}, this ccgen has {FORMAT_VERSION}"
        return Member(path, manifest.joint, None, None, manifest, changed, refused)
    try:
        exported = open_exported(path)
        joint, layout = exported.joint, exported.layout
    except InputError as error:
        if not changed:
            raise
        return Member(path, manifest.joint, None, None, manifest, changed, str(error))
    return Member(path, joint.name, joint, layout, manifest, changed)


def _layout(joint: Joint) -> FrameLayout:
    """The frames of a joint that is not exported; fitted where they depend on it."""
    ends = [one.range or count_limits(one.bits, one.signed) for one in joint.sensors]
    low, high = np.array(ends, dtype=np.int64).T
    widest = layout_for(joint, SensorRanges(low, high, low))
    if joint.precision == 16 or widest.count_bytes == 3:
        return widest  # narrower ranges give the same frames
    kept = kept_fit(joint)
    if kept is not None and kept.fit is not None:
        return layout_for(joint, kept.fit.model.readings)
    check_counts(joint)
    return layout_for(joint, fit(joint).model.readings)
