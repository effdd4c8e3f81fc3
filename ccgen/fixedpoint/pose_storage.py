"""Integer poses as a JSON record, beside the axes of `model.json`."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from ccgen.fixedpoint.pose import PoseBounds, PoseModel, PoseTask
from ccgen.fixedpoint.storage import load_record
from ccgen.polynomial.storage import compiled_function, compiled_record


def pose_record(poses: PoseModel) -> dict[str, Any]:
    """The key "poses"."""
    return {
        "poses": {
            "task": asdict(poses.task),
            "bounds": asdict(poses.bounds),
            "wide_bounds": asdict(poses.wide_bounds),
            "turn": compiled_record(poses.turn),
            "place": compiled_record(poses.place),
        }
    }


def load_poses(path: Path) -> PoseModel:
    """Read poses back from `model.json`; they are equal, bit for bit, to those that were written.

    Raises:
        InputError: as of `ccgen.fixedpoint.storage.load_model`.
    """
    return load_record(path, lambda record: pose_model(record["poses"]))


def pose_model(record: dict[str, Any]) -> PoseModel:
    """The poses that a record holds.

    Raises:
        KeyError, TypeError, ValueError, CheckError: no record of poses.
    """
    task = dict(record["task"])
    for key in ("sections", "fraction_bits"):
        task[key] = tuple(int(one) for one in task[key])
    bounds = {key: PoseBounds(**record[key]) for key in ("bounds", "wide_bounds")}
    turn, place = (compiled_function(record[key]) for key in ("turn", "place"))
    return PoseModel(PoseTask(**task), turn, place, **bounds)
