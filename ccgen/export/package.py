"""The exported folder: every file of it rendered in memory, then written whole or not at all."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ccgen import resources
from ccgen.can.layout import FrameLayout, layout_for
from ccgen.errors import ArgumentError, InputError
from ccgen.estimation.sources import CASES, LOADS, RECORDING
from ccgen.export.arrangement import arrangement_context
from ccgen.export.context import can_context, common_context
from ccgen.export.dbc import dbc_text
from ccgen.export.errors_context import errors_context
from ccgen.export.examples import check_kinds, example_files
from ccgen.export.functions_c import functions_context, functions_files, require_free
from ccgen.export.guard_context import guard_context
from ccgen.export.jacobian_c import jacobian_files
from ccgen.export.kinematics_c import kinematics_context
from ccgen.export.manifest import FILE_NAME, foreign_files, manifest_json
from ccgen.export.model_context import model_context
from ccgen.export.pose_c import pose_files
from ccgen.export.selftest_context import selftest_context
from ccgen.fixedpoint import Fit, FixedPointModel, fit
from ccgen.fixedpoint.beforehand import check_counts
from ccgen.fixedpoint.guarded_storage import guarded_json
from ccgen.fixedpoint.kept import Kept, inputs_of, kept_fit
from ccgen.fixedpoint.pose_storage import pose_record
from ccgen.functions import JointFunctions, Module, compile_functions, read_module
from ccgen.functions.storage import functions_record
from ccgen.joint import Joint
from ccgen.joint.file import load, parse_joint
from ccgen.outputs import new_folder
from ccgen.recordings.progress import Report, in_silence

JOINT_FILES = {
    "src/{name}.h": "model.h.j2",
    "src/{name}.c": "model.c.j2",
    "src/{name}_can.h": "can.h.j2",
    "src/{name}_can.c": "can.c.j2",
    "selftest/{name}_selftest.h": "selftest.h.j2",
    "selftest/{name}_selftest.c": "selftest.c.j2",
    "selftest/main.c": "selftest_main.c.j2",
    "ports/port_joint.h": "port_joint.h.j2",
    "ports/port_selftest.h": "port_selftest.h.j2",
    "CMakeLists.txt": "CMakeLists.txt.j2",
    "cmake/{name}-config.cmake": "cmake_config.cmake.j2",
    "zephyr/module.yml": "zephyr_module.yml.j2",
    "zephyr/CMakeLists.txt": "zephyr_CMakeLists.txt.j2",
    "zephyr/Kconfig": "zephyr_Kconfig.j2",
    "idf_component.yml": "idf_component.yml.j2",
    "library.json": "library.json.j2",
    "library.properties": "library.properties.j2",
    "README.md": "README.md.j2",
    "sensors.svg": "sensors.svg.j2",
}
"""Generated files of the folder and their templates."""

FLOAT_FILES = {
    "src/{name}_kinematics.h": "kinematics.h.j2",
    "src/{name}_kinematics.c": "kinematics.c.j2",
}
"""Likewise, of joints that have kinematics in single precision."""

CALIBRATION_END = ".calibration.toml"
"""Behind the joint's name: the copy of its calibration file, whatever path joint.toml gives."""

RUNTIME_FILES = (("include/ccgen", "src/ccgen"), ("src", "src/ccgen"), ("ports", "ports"))
"""Folders of the C runtime and where they go."""


@dataclass(frozen=True)
class Export:
    """What was exported, and where to."""

    directory: Path
    files: tuple[str, ...]
    joint: Joint
    model: FixedPointModel
    layout: FrameLayout
    fallback_bytes: int
    """Flash that what serves while a sensor is missing takes."""
    doubts: tuple[str, ...] = ()
    """What is odd of the joint's numbers and of its fixed point, a sentence each."""
    notes: tuple[str, ...] = ()
    """What is to be said of the fit that was exported, a sentence each."""


def export(
    fitted: Fit | Joint | str | Path,
    directory: str | Path,
    report: Report = in_silence,
    examples: Sequence[str] = (),
    functions: str | Path | None = None,
) -> Export:
    """Write the folder for a joint; an older export in its place is replaced in one step.

    Args:
        fitted: a fit, which is exported as it was fitted; a joint, or the path of its file, which
            is fitted first unless its fit is kept beside the file (`ccgen.fixedpoint.kept`).
        directory: the folder to write.
        report: told of progress where something takes long: what, steps done, steps in all.
        examples: kinds of complete projects to write beside it, of `ccgen.export.examples`.
        functions: a Python file of CasADi functions of the joint's angles, which are exported in
            integers (`ccgen.functions`).

    Raises:
        InputError: the joint's file or a function is wrong, no format fits, the controller of an
            example does not speak CAN FD, or the folder cannot be written or holds files that are
            not ours.
    """
    check_kinds(examples)
    module = None if functions is None else read_module(functions)
    joint = load(fitted) if isinstance(fitted, str | Path) else fitted
    kept = None if isinstance(joint, Fit) else kept_fit(_as_filed(joint))
    if isinstance(joint, Fit):
        whole = joint
    elif kept is not None and kept.fit is not None:
        whole = kept.fit
    else:
        check_counts(joint)
        whole = fit(joint, report=report)
    layout, files = render(whole, kept, examples, module)
    with new_folder(Path(directory), _only_ours) as folder:
        for path, content in files.items():
            target = folder / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
    return Export(
        directory=Path(directory),
        files=tuple(sorted(files)),
        joint=whole.joint,
        model=whole.model,
        fallback_bytes=whole.guarded.flash_bytes,
        layout=layout,
        doubts=whole.doubts,
        notes=() if kept is None else (kept.note,),
    )


def render(
    fitted: Fit,
    kept: Kept | None = None,
    examples: Sequence[str] = (),
    module: Module | None = None,
) -> tuple[FrameLayout, dict[str, bytes]]:
    """The frames, and every file's content by path; the same input, the same bytes.

    Args:
        fitted: what to export.
        kept: where it comes from.
        examples: as of `export`.
        module: of the user's own functions.
    """
    _as_filed(fitted.joint)
    joint, model = fitted.sensed, fitted.model
    functions = JointFunctions() if module is None else compile_functions(module, model)
    parts = _parts(joint, bool(functions))
    layout = layout_for(joint, model.readings)
    runtime, poses = runtime_files(), fitted.poses
    values: dict[str, Any] = {
        **common_context(joint, fitted.method),
        **model_context(fitted, layout),
        **guard_context(fitted, layout),
        **can_context(layout, joint, fitted.guarded),
        **errors_context(fitted),
        "drawing": arrangement_context(joint),
        **selftest_context(joint, fitted.guarded, poses, layout, fitted.shapes),
        "zeros": model.readings.zero.tolist(),
        "tip_shift": poses.position_bits - layout.tip_fraction_bits,
        "kinematics": _kinematics(joint, model),
        "pose_position_bits": poses.position_bits,
        "runtime_sources": sorted(f for f in runtime if f.endswith(".c") and f.startswith("src/")),
        "joint_sources": [f"src/{joint.name}{part}.c" for part in parts],
        "joint_headers": [f"src/{joint.name}{part}.h" for part in parts],
        "functions": functions_context(joint.name, functions),
        "functions_source": functions.source,
        "function_words": functions.words,
    }
    templates = JOINT_FILES | (FLOAT_FILES if joint.float_kinematics else {})
    texts = {
        path.format(name=joint.name): resources.template(template).render(values)
        for path, template in templates.items()
    }
    integers = pose_files(joint.name, poses, tuple(model.axes))
    integers |= jacobian_files(joint.name, fitted.jacobian, model)
    for file, text in integers.items():
        texts[f"src/{file}"] = text
    if functions:
        require_free(joint.name, functions, texts)
        for file, text in functions_files(joint.name, functions).items():
            texts[f"src/{file}"] = text
    texts[f"{joint.name}.dbc"] = dbc_text(layout, joint, model)
    texts["model.json"] = guarded_json(
        fitted.guarded, pose_record(fitted.jacobian) | functions_record(functions)
    )
    files = runtime | {"joint.toml": joint.content, "LICENSE": resources.licence().read_bytes()}
    if joint.calibration_content:
        files[f"{joint.name}{CALIBRATION_END}"] = joint.calibration_content
    files |= {path: text.encode("utf-8") for path, text in texts.items()}
    files |= example_files(examples, layout, joint.source, values)
    inputs = _inputs(fitted, kept) | ({functions.source: functions.sha256} if functions else {})
    files[FILE_NAME] = manifest_json(joint.name, inputs, files).encode("utf-8")
    return layout, files


def _parts(joint: Joint, has_functions: bool) -> tuple[str, ...]:
    """What stands behind the joint's name in the names of its sources."""
    single_precision = ("_kinematics",) if joint.float_kinematics else ()
    own = ("_functions",) if has_functions else ()
    return ("", "_can", *single_precision, "_pose", "_jacobian", *own)


def _kinematics(joint: Joint, model: FixedPointModel) -> dict[str, Any] | None:
    """What the templates know of the single-precision kinematics; None where there are none."""
    if not joint.float_kinematics:
        return None
    return kinematics_context(
        f"{joint.source}: geometry.range_of_motion",
        joint.geometry.segments,
        joint.geometry.segment_length,
        joint.precision,
        {axis: own.fraction_bits for axis, own in model.axes.items()},
        joint.geometry.sections if "h" in model.axes else (),
    )


def _inputs(fitted: Fit, kept: Kept | None) -> dict[str, str]:
    """Fingerprints of what the folder was made from, by name.

    They are the joint's file with all that it names, shapes that it does not state, and the file
    of a fit that was kept.
    """
    inputs = inputs_of(fitted.joint)
    if any(not _is_stated(name) for name in fitted.shapes.source):
        shapes = fitted.shapes.state.astype("<f8").tobytes()
        inputs["shapes"] = hashlib.sha256(shapes).hexdigest()
    if kept is not None and kept.fit is not None:
        inputs[kept.path.name] = kept.sha256
    return inputs


def _is_stated(source: str) -> bool:
    """Whether shapes follow from the joint's file and what it names."""
    return source in (CASES, LOADS) or source.startswith(RECORDING)


def _as_filed(joint: Joint) -> Joint:
    """The joint, once it is clear that its file says what it is."""
    try:
        stated = parse_joint(
            joint.content.decode("utf-8-sig"),
            joint.source,
            calibrations=lambda _: joint.calibration_content or None,
        )
    except (InputError, UnicodeDecodeError):
        stated = None
    if stated != joint:
        raise ArgumentError(
            f"joint {joint.name} is not what its file says, which is exported with it; change the "
            "text of the file, and parse that",
            "fitted",
        )
    return joint


def runtime_files() -> dict[str, bytes]:
    """The C runtime and its ports, by path in the exported folder."""
    root = resources.firmware()
    return {
        f"{target}/{file.relative_to(root / source).as_posix()}": file.read_bytes()
        for source, target in RUNTIME_FILES
        for file in sorted((root / source).rglob("*"))
        if file.is_file()
    }


def _only_ours(directory: Path) -> bool:
    foreign = foreign_files(directory)
    if foreign:
        raise InputError(
            f"{directory}: holds {foreign[0]}, which ccgen did not write; "
            f"choose another folder or remove it"
        )
    return True
