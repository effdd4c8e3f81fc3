"""Integer poses: within their proven bounds, and the same bits in C on every core."""

import ctypes
import json
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from exact_poses import exact_pose
from joint_files import joint_text
from provers import errors, proven, script, widths
from runtime_c import COMPILERS, UNDEFINED, compile_c

import ccgen
from ccgen import kinematics as kin
from ccgen import resources
from ccgen.cost.emulator import CORES, Program
from ccgen.cost.link import link
from ccgen.errors import CheckError, FormatError
from ccgen.export.pose_c import pose_files
from ccgen.fixedpoint.jacobian import JacobianModel
from ccgen.fixedpoint.jacobian_plan import jacobian_model
from ccgen.fixedpoint.pose import PoseModel, PoseTask
from ccgen.fixedpoint.pose_bounds import norm, root, truncations
from ccgen.fixedpoint.pose_plan import TARGETS, closest_poses, pose_model
from ccgen.fixedpoint.pose_storage import jacobian_model as jacobian_of
from ccgen.fixedpoint.pose_storage import pose_record
from ccgen.kinematics.symbolic import TurnDegrees, turn_function
from ccgen.polynomial.proof import prove
from ccgen.polynomial.storage import compiled_function
from ccgen.targets.compiler import WARNINGS
from ccgen.targets.cores import core_named, require_tools

TASKS = {
    "shoulder": PoseTask((12,), 0.02, 16, (18, 18), 0.0655),
    "spine": PoseTask((48,), 0.02, 32, (34, 35), 0.0437),
    "bellows": PoseTask((5, 7), 0.0175, 16, (17, 16), 0.1637, 18, 0.05),
}
NAMES = tuple(TASKS)


@cache
def model(name: str) -> PoseModel:
    return pose_model(TASKS[name])


def states(task: PoseTask, count: int, whole: bool, seed: int = 1) -> list[np.ndarray]:
    """Integers of u, v and h, shape (count, …): corners, alike in all segments, and anything."""
    random = np.random.default_rng(seed)
    found = []
    for bits in task.fraction_bits:
        most = task.largest if whole else min(task.largest, int(task.angle * 2.0**bits))
        values = random.integers(-most, most + 1, (count, task.segments))
        values[: count // 3] = random.choice([-most, most], (count // 3, 1))
        alike = random.integers(-most, most + 1, (count // 3, 1))
        values[count // 3 : 2 * (count // 3)] = alike
        found.append(values)
    most = 0
    if task.elongation_bits is not None:
        most = task.largest if whole else int(task.elongation * 2.0**task.elongation_bits)
    found.append(random.integers(-most, most + 1, (count, len(task.sections))))
    return found


@cache
def jacobian(name: str) -> JacobianModel:
    return jacobian_model(model(name))


def exact_columns(task: PoseTask, u, v, h) -> np.ndarray:
    """Tip Jacobians in double precision, shape (N, 6, columns)."""
    share = h * 2.0 ** -(task.elongation_bits or 0)
    lengths = task.segment_length * (1 + np.repeat(share, task.sections, axis=1))
    first, second = (x * 2.0**-bits for x, bits in zip((u, v), task.fraction_bits, strict=True))
    columns = [kin.tip_jacobian(first, second, lengths)]
    if task.elongation_bits is not None:
        length = task.segment_length
        columns.append(kin.elongation_columns(first, second, length, task.sections))
    return np.concatenate(columns, axis=2)


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_jacobians_are_within_their_bounds_which_are_of_use(name, whole):
    task, found = TASKS[name], jacobian(name)
    drawn = states(task, 300, whole)
    got = found.jacobian(*drawn).astype(float)
    got[:, :3] *= 2.0**-found.linear_bits
    got[:, 3:] *= 2.0**-found.angular_bits
    off = got - exact_columns(task, *drawn)
    bounds = found.wide_bounds if whole else found.bounds
    linear, angular = (np.linalg.norm(off[:, k : k + 3], axis=1).max() for k in (0, 3))
    assert bounds.linear / 100 < linear <= bounds.linear
    assert bounds.angular / 100 < angular <= bounds.angular
    if not whole:
        assert bounds.angular < 2 * found.poses.bounds.rotation
        assert bounds.linear < 4 * (
            found.poses.bounds.position + found.poses.bounds.rotation * task.length
        )


def test_jacobians_follow_the_poses_of_the_integers():
    """A step of an angle moves the tip as its column says."""
    task, found = TASKS["bellows"], jacobian("bellows")
    u, v, h = states(task, 40, whole=False)
    column = found.jacobian(u, v, h)[:, :3, 3] * 2.0**-found.linear_bits
    step = 512
    moved = [u + sign * step * (np.arange(task.segments) == 3) for sign in (1, -1)]
    ends = [found.poses.pose(one, v, h)[1] for one in moved]
    rate = (ends[0] - ends[1]) * 2.0 ** (task.fraction_bits[0] - found.poses.position_bits)
    np.testing.assert_allclose(rate / (2 * step), column, atol=2e-4 * task.length)


def test_poses_and_jacobians_read_back_from_json_are_the_same():
    for name in NAMES:
        record = json.loads(json.dumps(pose_record(jacobian(name))))
        whole = jacobian_of(record)
        again = whole.poses
        assert again.task == model(name).task
        assert (again.bounds, again.wide_bounds) == (model(name).bounds, model(name).wide_bounds)
        assert again.turn.plan == model(name).turn.plan
        assert prove(again.place.plan) == again.place.proof == model(name).place.proof
        drawn = states(TASKS[name], 30, whole=True)
        np.testing.assert_array_equal(again.chain(*drawn), model(name).chain(*drawn))
        np.testing.assert_array_equal(again.chain(*drawn)[:, -1], again.entries(*drawn))
        np.testing.assert_array_equal(whole.jacobian(*drawn), jacobian(name).jacobian(*drawn))
        assert (whole.bounds, whole.wide_bounds) == (
            jacobian(name).bounds,
            jacobian(name).wide_bounds,
        )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda step: step.replace("subtract", "divide"), "step 13 of a plan: divide"),
        (lambda step: step.replace("subtract 1", "subtract 9"), "step 13 of a plan"),
        (lambda step: step.replace("subtract", "word"), "its format is not its operands'"),
        (lambda step: step + "0000000000", "may leave 32 bits"),
    ],
)
def test_a_plan_that_no_integers_have_is_refused_when_read(change, said):
    record = pose_record(jacobian("shoulder"))["poses"]["turn"]
    place = next(k for k, step in enumerate(record["steps"]) if step.startswith("subtract 1"))
    record["steps"][place] = change(record["steps"][place])
    with pytest.raises((ValueError, CheckError), match=said):
        compiled_function(record)


def floats(task: PoseTask, u, v, h) -> np.ndarray:
    """Poses in double precision, shape (N, 4, 4)."""
    stretch = 1 + np.repeat(h * 2.0 ** -(task.elongation_bits or 0), task.sections, axis=1)
    first, second = (x * 2.0**-bits for x, bits in zip((u, v), task.fraction_bits, strict=True))
    return kin.tip_pose(first, second, task.segment_length * stretch)


def seen(name: str, count: int, whole: bool) -> tuple[float, float]:
    """Largest errors of position (m) and rotation beside double precision."""
    task, found = TASKS[name], model(name)
    u, v, h = states(task, count, whole)
    rotation, position = found.pose(u, v, h)
    expected = floats(task, u, v, h)
    off = position * 2.0**-found.position_bits - expected[:, :3, 3]
    turned = rotation * 2.0**-found.frame_bits - expected[:, :3, :3]
    return float(np.linalg.norm(off, axis=1).max()), float(
        np.linalg.norm(turned, axis=(1, 2)).max()
    )


@pytest.mark.parametrize("name", NAMES)
def test_bounds_are_as_small_as_aimed_at_and_hold_over_what_shapes_need(name):
    bounds, task = model(name).bounds, TASKS[name]
    position, rotation = seen(name, 6000, whole=False)
    assert position < bounds.position <= TARGETS[task.precision] * task.length
    assert rotation < bounds.rotation


@pytest.mark.parametrize("name", NAMES)
def test_a_second_bound_holds_over_all_that_the_formats_hold(name):
    bounds = model(name).wide_bounds
    position, rotation = seen(name, 6000, whole=True)
    assert position < bounds.position
    assert rotation < bounds.rotation


@pytest.mark.parametrize(("name", "times"), [("shoulder", 8), ("spine", 20), ("bellows", 16)])
def test_bounds_are_not_far_above_what_is_met(name, times):
    assert model(name).bounds.position <= times * seen(name, 6000, whole=False)[0]


@pytest.mark.parametrize(("name", "count"), [("shoulder", 120), ("spine", 30), ("bellows", 120)])
def test_bounds_hold_against_60_digits(name, count):
    task, found = TASKS[name], model(name)
    u, v, h = states(task, count, whole=False, seed=2)
    rotation, position = found.pose(u, v, h)
    for row in range(count):
        elongation = None if task.elongation_bits is None else h[row]
        frame, place = exact_pose(task, u[row], v[row], elongation)
        off = (position[row] * 2.0**-found.position_bits - place.astype(float)).tolist()
        turned = rotation[row] * 2.0**-found.frame_bits - frame.astype(float)
        assert np.linalg.norm(off) < found.bounds.position
        assert np.linalg.norm(turned) < found.bounds.rotation


def test_the_straight_joint_is_straight_to_the_last_bit_but_rounding():
    for name in NAMES:
        task, found = TASKS[name], model(name)
        zero = np.zeros((1, task.segments), dtype=np.int64)
        _, position = found.pose(zero, zero, np.zeros((1, len(task.sections)), dtype=np.int64))
        off = position[0] * 2.0**-found.position_bits - [0, 0, task.length]
        assert np.abs(off).max() <= found.bounds.position


def test_poses_of_segments_are_those_of_shorter_joints():
    task, found = TASKS["bellows"], model("bellows")
    u, v, h = states(task, 50, whole=False)
    for segment in (0, 4, 5, 11):
        rotation, position = found.pose(u, v, h, segment)
        stretch = 1 + np.repeat(h * 2.0**-task.elongation_bits, task.sections, axis=1)
        poses = kin.chain(
            u * 2.0 ** -task.fraction_bits[0], v * 2.0 ** -task.fraction_bits[1],
            task.segment_length * stretch,
        )[:, segment]  # fmt: skip
        off = position * 2.0**-found.position_bits - poses[:, :3, 3]
        assert np.linalg.norm(off, axis=1).max() < found.bounds.position
        turned = rotation * 2.0**-found.frame_bits - poses[:, :3, :3]
        assert np.linalg.norm(turned, axis=(1, 2)).max() < found.bounds.rotation


def c_sources(name: str, folder: Path) -> Path:
    for file, text in pose_files(name, model(name)).items():
        (folder / file).write_text(text)
    return folder / f"{name}_pose.c"


@cache
def library(name: str, compiler: str, flags: tuple[str, ...]) -> ctypes.CDLL:
    with TemporaryDirectory() as folder:
        source = c_sources(name, Path(folder))
        return ctypes.CDLL(str(compile_c([source], ("-shared", "-fPIC", *flags), compiler)))


def run_c(name: str, dll: ctypes.CDLL, u, v, h, segment: int) -> tuple[np.ndarray, np.ndarray]:
    task = TASKS[name]
    kind = f"int{task.precision}"
    arrays = [np.ascontiguousarray(x.astype(kind)) for x in (u, v, h)]
    arrays = arrays[: 2 if task.elongation_bits is None else 3]
    frames, places = np.zeros((len(u), 9), "int32"), np.zeros((len(u), 3), "int32")
    for row in range(len(u)):
        given = [ctypes.c_void_p(a[row].ctypes.data) for a in arrays]
        taken = [ctypes.c_void_p(a[row].ctypes.data) for a in (frames, places)]
        function = getattr(dll, f"{name}_integer_pose")
        assert function(*given, ctypes.c_uint16(segment), *taken) == 0
    return frames.reshape(-1, 3, 3).swapaxes(1, 2), places


BUILDS = [
    *((compiler, (level,)) for compiler in COMPILERS for level in ("-O0", "-O1", "-O2", "-O3")),
    (COMPILERS[0], ("-O1", "-DCCGEN_LONG_PRODUCTS=0", *UNDEFINED)),
    (COMPILERS[0], ("-O1", *UNDEFINED)),
]


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: " ".join((build[0], *build[1][:2])))
def test_c_gives_the_models_bits_for_any_angles_of_its_types(build):
    for name in NAMES:
        task = TASKS[name]
        u, v, h = states(task, 60, whole=True)
        u[-1], v[-1] = -task.largest - 1, -task.largest - 1  # no reading
        for segment in (task.segments - 1, 5):
            expected = model(name).pose(u, v, h, segment)
            for got, wanted in zip(
                run_c(name, library(name, *build), u, v, h, segment), expected, strict=True
            ):
                np.testing.assert_array_equal(got, wanted, name)


def test_null_pointers_and_segments_that_are_not_there_are_refused():
    dll = library("shoulder", COMPILERS[0], ("-O2",))
    array = (ctypes.c_int32 * 12)()
    for k in range(4):
        pointers = [None if j == k else array for j in range(4)]
        call = (*pointers[:2], ctypes.c_uint16(0), *pointers[2:])
        assert dll.shoulder_integer_pose(*call) == -1
    assert dll.shoulder_integer_pose(array, array, ctypes.c_uint16(12), array, array) == -1


def exported_pose(folder: Path, fit: ccgen.Fit) -> ctypes.CDLL:
    """The integer poses of an exported joint as a library."""
    source = ccgen.export(fit, folder).directory / "src"
    name = fit.joint.name
    flags = ("-shared", "-fPIC", "-O1", *UNDEFINED, f"-I{source}")
    return ctypes.CDLL(str(compile_c([source / f"{name}_pose.c"], flags)))


@pytest.mark.parametrize("axes", [("u", "v"), ("u",), ("v",)])
def test_the_tips_pose_of_an_exported_joint_takes_its_angles_as_they_stand(axes, tmp_path):
    listed = ", ".join(f'"{axis}"' for axis in axes)
    text = joint_text(tables=f"[estimator]\naxes = [{listed}]")
    fit = ccgen.fit(ccgen.parse(text))
    dll, poses = exported_pose(tmp_path / "out", fit), fit.poses
    m = poses.task.segments
    random = np.random.default_rng(5)
    angles = {axis: random.integers(-3000, 3000, m).astype("int16") for axis in axes}
    held = np.concatenate([angles[axis] for axis in axes])
    pose = np.zeros(12, "int32")
    function = getattr(dll, f"{fit.joint.name}_integer_tip_pose")
    assert function(ctypes.c_void_p(held.ctypes.data), ctypes.c_void_p(pose.ctypes.data)) == 0
    zero = np.zeros(m, dtype=np.int64)
    u, v = (angles.get(axis, zero).astype(np.int64)[None] for axis in ("u", "v"))
    rotation, position = poses.pose(u, v)
    np.testing.assert_array_equal(pose[:9].reshape(3, 3).T, rotation[0])
    np.testing.assert_array_equal(pose[9:], position[0])
    assert function(None, ctypes.c_void_p(pose.ctypes.data)) == -1
    assert function(ctypes.c_void_p(held.ctypes.data), None) == -1


RUN = """
#include "{name}_pose.h"
int{precision}_t u[{segments}], v[{segments}], h[{sections}];
int32_t frame[9], place[3];
int run(void);
int run(void) {{ return {name}_integer_pose(u, v, {h}{last}, frame, place); }}
"""


def on_core(name: str, core: str, level: str, folder: Path) -> int:
    """Instructions of one pose, whose bits are held against the model."""
    task = TASKS[name]
    sources = [c_sources(name, folder), folder / "run.c"]
    sources[1].write_text(
        RUN.format(
            name=name, precision=task.precision, segments=task.segments,
            sections=len(task.sections), last=task.segments - 1,
            h="" if task.elongation_bits is None else "h, ",
        )
    )  # fmt: skip
    target = core_named(core)
    require_tools(target)
    include = f"-I{resources.firmware() / 'include'}"
    compiler = [*target.compile, "-std=c99", level, *WARNINGS, include]
    roots = ["run", "u", "v", "h", "frame", "place"]
    program = Program(link(compiler, sources, roots, folder / "pose.elf"), CORES[core])
    u, v, h = states(task, 12, whole=True)
    expected = model(name).pose(u, v, h)
    count = 0
    for row in range(12):
        for symbol, values in (("u", u), ("v", v), ("h", h)):
            program.write(symbol, values[row].astype(f"<i{task.precision // 8}").tobytes())
        call = program.call("run", counted=row == 0)
        count = max(count, call.instructions)
        assert call.result == 0
        frame = np.frombuffer(program.read("frame", 36), "<i4").reshape(3, 3).T
        np.testing.assert_array_equal(frame, expected[0][row])
        place = np.frombuffer(program.read("place", 12), "<i4")
        np.testing.assert_array_equal(place, expected[1][row])
    return count


@pytest.mark.parametrize(
    ("name", "core", "level", "budget"),
    [
        ("shoulder", "cortex-m0", "-O2", 5000),
        ("shoulder", "cortex-m0", "-O0", 35_000),
        ("shoulder", "cortex-m3", "-Os", 2400),
        ("shoulder", "cortex-m4", "-O2", 1700),
        ("shoulder", "riscv32", "-O2", 2800),
        ("spine", "cortex-m4", "-O2", 7500),
        ("bellows", "cortex-m0", "-O2", 7000),
        ("bellows", "cortex-m4", "-O2", 2200),
    ],
)
def test_every_core_gives_the_models_bits_within_a_budget(name, core, level, budget, tmp_path):
    assert on_core(name, core, level, tmp_path) <= budget


@pytest.mark.slow
@pytest.mark.parametrize("name", ["shoulder", "spine"])
def test_gappa_confirms_bounds_and_widths_of_a_segment(name):
    """Of one entry of X, of Z and of the chord; the others are computed alike.

    Gappa takes a rounding that reaches a result by two ways for two: its bounds are a bit wider.
    """
    found = model(name).turn
    bounds = [bound * 105 / 100 for bound in found.proof.bounds()]
    claims = errors(found.plan, bounds)
    assert proven(script(found, [*widths(found.plan), *(claims[k] for k in (0, 6, 9))]))


def test_roots_and_truncations_are_rounded_up():
    assert root(Fraction(2)) ** 2 > 2
    assert norm([Fraction(3), Fraction(4)]) >= 5
    angle, degrees = 0.5, TurnDegrees(2, 1, 0)
    turn, chord = truncations(Fraction(1, 2), degrees)
    exact = kin.tip_pose(np.array([[angle]]), np.array([[angle]]), 1.0)[0]
    distal, short = turn_function(degrees)(np.eye(3), angle, angle)
    off = np.linalg.norm(np.array(distal) - exact[:3, :3])
    assert turn / 1.3 < off <= turn
    lacking = np.linalg.norm(np.array(short).ravel() - exact[:3, 3])
    assert chord / 1.3 < lacking <= chord


def test_a_fitted_joint_has_poses_in_the_formats_of_its_angles():
    fit = ccgen.fit(ccgen.parse(joint_text()))
    poses, axes = fit.poses, fit.model.axes
    assert poses.task.fraction_bits == (axes["u"].fraction_bits, axes["v"].fraction_bits)
    assert poses.task.angle > np.deg2rad(3.0)
    assert poses.bounds.position <= 4e-6 * 0.24


def test_segments_that_bend_far_about_both_axes_have_poses_as_exact():
    """Intervals then need a bit more of room than a turn about one axis does."""
    found = pose_model(PoseTask((12,), 0.02, 16, (16, 16), 0.278))
    assert found.frame_bits == 29
    assert found.bounds.position <= TARGETS[16] * found.task.length


def test_angles_that_reach_too_far_are_refused():
    with pytest.raises(FormatError, match=r"format reaches 7\.99976 rad a segment"):
        pose_model(PoseTask((2,), 0.1, 16, (12, 15), 3.0))


@pytest.mark.slow
def test_angles_whose_series_does_not_end_in_time_are_refused_too():
    with pytest.raises(FormatError, match=r"for angles up to 4 rad; use fewer segments or"):
        closest_poses(PoseTask((3,), 0.1, 16, (13, 13), 2.0))


def test_a_chain_that_is_too_long_for_its_precision_is_refused():
    with pytest.raises(FormatError) as caught:
        pose_model(PoseTask((64,), 0.1, 32, (30, 30), 1.9))
    assert str(caught.value) == (
        "no plan of 32 bits has poses of 64 segments within 5e-07 of the length for angles up to "
        "2 rad; use fewer segments or a smaller range of motion"
    )


def test_segments_that_bend_far_have_poses_too():
    task = PoseTask((4,), 0.05, 16, (14, 14), 1.1)
    found = pose_model(task)
    u, v, h = states(task, 300, whole=False)
    _, position = found.pose(u, v, h)
    off = position * 2.0**-found.position_bits - floats(task, u, v, h)[:, :3, 3]
    assert np.linalg.norm(off, axis=1).max() < found.bounds.position <= 4e-6 * task.length
