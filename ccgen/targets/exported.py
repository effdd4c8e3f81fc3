"""An exported folder as `verify`, `cost` and `bridge` see it."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ccgen.can.fingerprint import fingerprint
from ccgen.can.layout import FrameLayout, layout_for
from ccgen.errors import InputError
from ccgen.export.manifest import changed_files, read_manifest
from ccgen.export.package import CALIBRATION_END
from ccgen.fixedpoint import FixedPointModel
from ccgen.fixedpoint.guarded import GuardedModel
from ccgen.fixedpoint.guarded_storage import load_guarded
from ccgen.fixedpoint.jacobian import JacobianModel
from ccgen.fixedpoint.pose import PoseModel
from ccgen.fixedpoint.pose_storage import load_jacobian
from ccgen.functions import JointFunctions
from ccgen.functions.storage import load_functions
from ccgen.joint import AXES, Joint
from ccgen.joint.file import read_joint
from ccgen.kinematics.bounds import ErrorBounds, error_bounds, largest_angle, largest_elongation

if TYPE_CHECKING:
    from ccgen.can.codec import Codec

MODEL = "model.json"
"""Holds the reference models."""


@dataclass(frozen=True)
class Exported:
    """A folder that `ccgen export` wrote, read back.

    Attributes:
        directory: the folder.
        joint: from its joint.toml.
        guarded: the integer reference model, from its model.json, with what serves and watches
            over sensors that fail.
        jacobian: the integer reference model of the tip's Jacobian, from the same file.
        functions: the user's own, likewise.
        changed: files that differ from what was exported.
    """

    directory: Path
    joint: Joint
    guarded: GuardedModel
    jacobian: JacobianModel
    functions: JointFunctions
    changed: tuple[str, ...]

    @property
    def model(self) -> FixedPointModel:
        """The axes of the integer reference model."""
        return self.guarded.model

    @property
    def poses(self) -> PoseModel:
        """The integer reference model of poses."""
        return self.jacobian.poses

    @cached_property
    def layout(self) -> FrameLayout:
        """Where the signals lie on the bus."""
        return layout_for(self.joint, self.model.readings)

    @cached_property
    def fingerprint(self) -> int:
        """Of model and frames; a node tells its low 16 bits in HEALTH."""
        return fingerprint(self.guarded, self.layout)

    @cached_property
    def codec(self) -> "Codec":
        """Encodes and decodes through the folder's own DBC."""
        from ccgen.can.codec import Codec, read_database

        return Codec(self.layout, read_database(self.directory / f"{self.joint.name}.dbc"))

    @cached_property
    def pose_bounds(self) -> ErrorBounds | None:
        """How far single-precision poses may lie from double precision; None: there are none."""
        if not self.joint.float_kinematics:
            return None
        geometry = self.joint.geometry
        fraction_bits = {axis: own.fraction_bits for axis, own in self.model.axes.items()}
        angle = largest_angle(self.model.precision, fraction_bits)
        elongation = largest_elongation(self.model.precision, fraction_bits)
        return error_bounds(geometry.segments, geometry.length, angle, elongation)


def open_exported(directory: Path) -> Exported:
    """Read an exported folder.

    Raises:
        InputError: it is none, or a file in it is damaged.
    """
    files = read_manifest(directory).files
    joint = read_joint(directory / "joint.toml", lambda _: _calibration(directory, files))
    guarded = load_guarded(directory / MODEL)
    jacobian = load_jacobian(directory / MODEL)
    functions = load_functions(directory / MODEL)
    poses = jacobian.poses
    if not (_is_model_of(joint, guarded.model) and _are_poses_of(joint, guarded.model, poses)):
        raise InputError(
            f"{directory}: {MODEL} is not of the joint in joint.toml; export the joint again"
        )
    return Exported(directory, joint, guarded, jacobian, functions, tuple(changed_files(directory)))


def _calibration(directory: Path, files: Iterable[str]) -> bytes | None:
    """The folder's copy of the calibration; without it, gains are those that joint.toml states."""
    copies = [name for name in files if name.endswith(CALIBRATION_END) and "/" not in name]
    try:
        return (directory / copies[0]).read_bytes() if copies else None
    except FileNotFoundError:
        return None


def _is_model_of(joint: Joint, model: FixedPointModel) -> bool:
    if model.precision != joint.precision or tuple(model.axes) != joint.axes:
        return False
    states = joint.geometry.segments, len(joint.geometry.sections)
    return all(
        axis.weights.shape == (states[name == "h"], len(joint.sensors[joint.own(name)]))
        and axis.part == joint.own(name)
        for name, axis in model.axes.items()
    )


def _are_poses_of(joint: Joint, model: FixedPointModel, poses: PoseModel) -> bool:
    """Whether poses have the joint's segments and the formats of its angles."""
    task = poses.task
    bending = [model.axes[axis].fraction_bits for axis in AXES if axis in model.axes]
    length = model.axes.get("h")
    return (
        task.sections == joint.geometry.sections
        and task.precision == model.precision
        and task.fraction_bits == (bending[0], bending[-1])
        and task.elongation_bits == (None if length is None else length.fraction_bits)
    )
