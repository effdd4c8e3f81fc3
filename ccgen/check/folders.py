"""Whether exported folders are of their joint file as it is, and as they were written."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from ccgen.check.member import Member
from ccgen.check.problem import Problem
from ccgen.export.manifest import Manifest
from ccgen.fixedpoint.kept import inputs_of, kept_fit
from ccgen.joint import Joint

_SHAPES = "shapes"
"""The input of a folder that was exported in Python, of shapes that its file does not state."""


def folder_problems(members: Sequence[Member]) -> Iterator[Problem]:
    """What is old and what was edited.

    Raises:
        InputError: a recording that a joint file names cannot be read.
    """
    for member in members:
        if member.manifest is None:
            continue
        files = [one for one in members if one.manifest is None and one.name == member.name]
        older = _older(member.manifest, files)
        if older:
            yield Problem(member.path, "older", older)
        elif member.refused and not member.changed:
            yield Problem(member.path, "older", f"{member.refused}; export {member.name} again")
        if member.changed:
            yield Problem(member.path, "edited", _edited(member))


def _older(manifest: Manifest, files: Sequence[Member]) -> str:
    """What is newer than the folder; empty where it is of one of the files, or no file is here."""
    newer = []
    for file in files:
        assert file.joint is not None
        changed = _changed(manifest.inputs, file.joint)
        if changed is None:
            return ""
        newer.append((file.path, changed))
    if not newer:
        return ""
    path, changed = newer[0]
    what = f"{path}" if changed == "joint.toml" else f"{changed} of {path}"
    return f"{manifest.joint} was exported before {what} became what it is; export it again"


def _changed(exported: Mapping[str, str], joint: Joint) -> str | None:
    """The first thing that an export would be made from today and the folder was not."""
    now = inputs_of(joint)
    kept = kept_fit(joint)
    if kept is not None and kept.fit is not None and _SHAPES not in exported:
        now[kept.path.name] = kept.sha256
    return next((name for name in now if exported.get(name) != now[name]), None)


def _edited(member: Member) -> str:
    gone = [file for file in member.changed if not (member.path / file).is_file()]
    differ = [file for file in member.changed if file not in gone]
    parts = [
        f"{_some(files)} {what}"
        for files, what in ((differ, "not as exported"), (gone, "gone"))
        if files
    ]
    refused = f" ({member.refused})" if member.refused else ""
    return f"{member.name}: {' and '.join(parts)}{refused}; export it again to undo"


def _some(files: Sequence[str | Path]) -> str:
    """The first file, and how many more; with the verb."""
    if len(files) == 1:
        return f"{files[0]} is"
    more = len(files) - 1
    return f"{files[0]} and {more} {'other file' if more == 1 else 'other files'} are"
