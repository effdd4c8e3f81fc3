"""Integer poses and their tip Jacobian as JSON records, beside the axes of `model.json`."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from ccgen.fixedpoint.jacobian import JacobianBounds, JacobianModel
from ccgen.fixedpoint.pose import PoseBounds, PoseModel, PoseTask
from ccgen.fixedpoint.storage import load_record
from ccgen.polynomial.storage import compiled_function, compiled_record


def pose_record(jacobian: JacobianModel) -> dict[str, Any]:
    """The keys "poses" and "jacobian"."""
    poses, stretch = jacobian.poses, jacobian.stretch
    return {
        "poses": {
            "task": asdict(poses.task),
            "bounds": asdict(poses.bounds),
            "wide_bounds": asdict(poses.wide_bounds),
            "turn": compiled_record(poses.turn),
            "place": compiled_record(poses.place),
        },
        "jacobian": {
            "bounds": asdict(jacobian.bounds),
            "wide_bounds": asdict(jacobian.wide_bounds),
            "columns": compiled_record(jacobian.columns),
            "column": compiled_record(jacobian.column),
            "stretch": None if stretch is None else compiled_record(stretch),
        },
    }


def load_jacobian(path: Path) -> JacobianModel:
    """Read poses and Jacobian back from `model.json`, equal, bit for bit, to what was written.

    Raises:
        InputError: as of `ccgen.fixedpoint.storage.load_model`.
    """
    return load_record(path, jacobian_model)


def jacobian_model(record: dict[str, Any]) -> JacobianModel:
    """The poses with their Jacobian that a record holds.

    Raises:
        KeyError, TypeError, ValueError, CheckError: no record of them.
    """
    own = record["jacobian"]
    bounds = {key: JacobianBounds(**own[key]) for key in ("bounds", "wide_bounds")}
    columns, column = (compiled_function(own[key]) for key in ("columns", "column"))
    stretch = None if own["stretch"] is None else compiled_function(own["stretch"])
    return JacobianModel(pose_model(record["poses"]), columns, column, stretch, **bounds)


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
