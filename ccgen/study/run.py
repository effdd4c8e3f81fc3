"""All joints of the study, each stored as soon as it is done, so that a run can be resumed."""

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ccgen import __version__
from ccgen.outputs import write_file
from ccgen.study.joints import Settings, StudyJoint, is_result, study_joint
from ccgen.study.sources import fingerprint

Record = Mapping[str, Any]


class Store:
    """A folder with one file for each finished joint."""

    def __init__(self, folder: Path, settings: Settings) -> None:
        self._folder = folder
        # What else the numbers depend on: results that differ in any of it do not count.
        self._made_with = {
            "version": __version__,
            "sources_sha256": fingerprint(),
            **asdict(settings),
        }

    def load(self, joint: StudyJoint) -> Record | None:
        """Return a joint's results, or None if they are not there, or not whole, or not its own.

        Results by other settings, another version or other sources are not there.
        """
        try:
            stored = json.loads(self._path(joint).read_bytes())
        except (FileNotFoundError, ValueError):
            return None
        if not isinstance(stored, dict) or stored.get("made_with") != self._made_with:
            return None
        return stored if is_result(stored, joint) else None

    def save(self, joint: StudyJoint, results: Record) -> Record:
        """Store a joint's results in one step, and return what `load` will."""
        stored = {**results, "made_with": self._made_with}
        text = json.dumps(stored, indent=1, allow_nan=False) + "\n"
        write_file(self._path(joint), text.encode())
        return stored

    def _path(self, joint: StudyJoint) -> Path:
        return self._folder / f"{joint.name}.json"


def run_study(
    joints: Sequence[StudyJoint],
    settings: Settings,
    store: Store,
    executor: Executor,
    finished: Callable[[StudyJoint, bool], None],
) -> list[Record]:
    """Study the joints that are not finished yet.

    Args:
        joints: which joints.
        settings: what the results depend on besides.
        store: finished joints.
        executor: where the work is done.
        finished: called for each joint that is done, with whether it was done before.

    Returns:
        The joints' results, in the order of the joints whatever the order they finish in.
    """
    records = {joint: record for joint in joints if (record := store.load(joint)) is not None}
    for joint in records:
        finished(joint, True)
    # Long joints first: what finishes last should be short.
    waiting = sorted(set(joints) - set(records), key=lambda j: (-j.segments, j))
    futures = {executor.submit(study_joint, joint, settings): joint for joint in waiting}
    for future in as_completed(futures):
        joint = futures[future]
        records[joint] = store.save(joint, future.result())
        finished(joint, False)
    return [records[joint] for joint in joints]
