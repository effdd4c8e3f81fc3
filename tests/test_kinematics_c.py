"""The generated C kinematics: within their bounds, clean, free of double arithmetic."""

import ctypes
import itertools
import math
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen import kinematics as kin
from ccgen import resources
from ccgen.errors import FormatError, ToolError
from ccgen.export import casadi_c
from ccgen.export.kinematics_c import (
    advance_function,
    columns_function,
    degrees,
    kinematics_context,
)
from ccgen.export.literals import float_literal
from ccgen.kinematics.bounds import error_bounds, largest_angle

WARNINGS = (
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wfloat-conversion",
    "-Wdouble-promotion", "-Wshadow", "-Wundef", "-Wvla", "-Werror",
)  # fmt: skip

HEADER = """\
#ifndef ARM_H
#define ARM_H
#include <stdint.h>
#define ARM_SEGMENTS {segments}
#define ARM_VALUES (2 * ARM_SEGMENTS)
#define ARM_RADIANS_PER_STEP_U {scale_u}
#define ARM_RADIANS_PER_STEP_V {scale_v}
typedef struct {{
    int{precision}_t u[ARM_SEGMENTS], v[ARM_SEGMENTS];
}} arm_angles_t;
#endif
"""


@dataclass(frozen=True)
class Arm:
    segments: int
    length: float
    precision: int
    fraction_bits: dict[str, int]

    @property
    def h(self) -> float:
        return self.length / self.segments

    @property
    def angle(self) -> float:
        return largest_angle(self.precision, self.fraction_bits)

    def steps(self, count: int, seed: int = 7) -> tuple[np.ndarray, np.ndarray]:
        """Random integers over the whole format; the first rows are its corners."""
        full = 2 ** (self.precision - 1)
        generator = np.random.default_rng(seed)
        drawn = generator.integers(-full, full, (2, count, self.segments))
        for row, signs in enumerate(itertools.product((-full, full - 1), repeat=2)):
            drawn[:, row, :] = np.array(signs)[:, None]
        return drawn[0], drawn[1]

    def radians(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return u * 2.0 ** -self.fraction_bits["u"], v * 2.0 ** -self.fraction_bits["v"]


ARMS = [
    Arm(12, 0.24, 16, {"u": 18, "v": 18}),
    Arm(48, 1.2, 16, {"u": 17, "v": 19}),
    Arm(3, 0.3, 16, {"u": 14, "v": 13}),
    Arm(24, 0.24, 32, {"u": 34, "v": 34}),
    Arm(64, 2.0, 32, {"u": 31, "v": 31}),
    Arm(1, 0.05, 16, {"u": 15, "v": 15}),
]
IDS = [f"{arm.segments}x{arm.precision}bit" for arm in ARMS]


def render(arm: Arm) -> dict[str, str]:
    values = {
        "name": "arm",
        "NAME": "ARM",
        "version": "1",
        "axes": {
            axis: {"axis": axis, "first_value": k * arm.segments} for k, axis in enumerate("uv")
        },
        "columns_said": "u, then v",
        "kinematics": kinematics_context(
            "arm", arm.segments, arm.h, arm.precision, arm.fraction_bits
        ),
    }
    return {
        f"arm_kinematics.{ending}": resources.template(f"kinematics.{ending}.j2").render(values)
        for ending in ("h", "c")
    }


def write(arm: Arm, folder: Path) -> Path:
    for name, text in render(arm).items():
        (folder / name).write_text(text)
    scales = (float_literal(2.0 ** -arm.fraction_bits[axis]) for axis in "uv")
    header = HEADER.format(
        segments=arm.segments,
        precision=arm.precision,
        **dict(zip(("scale_u", "scale_v"), scales, strict=True)),
    )
    (folder / "arm.h").write_text(header)
    return folder / "arm_kinematics.c"


def compile_c(compiler: str, source: Path, *options: str) -> None:
    include = resources.firmware() / "include"
    subprocess.run(
        [compiler, *WARNINGS, f"-I{source.parent}", f"-I{include}", *options, str(source)],
        check=True,
        capture_output=True,
        text=True,
    )


class Library:
    """The compiled kinematics behind NumPy arrays."""

    def __init__(self, arm: Arm, folder: Path, *options: str) -> None:
        path = folder / "arm.so"
        compile_c(
            "gcc", write(arm, folder), "-std=c99", "-O2", *options, "-shared", "-fPIC", "-o",
            str(path),
        )  # fmt: skip
        self.arm = arm
        self.dll = ctypes.CDLL(str(path))
        self.integer = np.int16 if arm.precision == 16 else np.int32

    def angles(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.concatenate((u, v)).astype(self.integer)

    def pose(self, u: np.ndarray, v: np.ndarray, segment: int) -> np.ndarray:
        angles, pose = self.angles(u, v), np.zeros(12, np.float32)
        segment_ = ctypes.c_uint16(segment)
        assert self.dll.arm_segment_pose(pointer(angles), segment_, pointer(pose)) == 0
        return np.column_stack((pose[:9].reshape(3, 3), pose[9:])).astype(float)

    def jacobian(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        angles, result = self.angles(u, v), np.zeros((6, 2 * self.arm.segments), np.float32)
        assert self.dll.arm_tip_jacobian(pointer(angles), pointer(result)) == 0
        return result.astype(float)


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


@pytest.fixture(scope="module", params=ARMS, ids=IDS)
def library(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Library:
    return Library(request.param, tmp_path_factory.mktemp("arm"), "-ffp-contract=off")


def pose_errors(library: Library, count: int) -> tuple[float, float]:
    """Worst position (metres) and rotation error over all segments of random poses."""
    arm = library.arm
    u, v = arm.steps(count)
    expected = kin.chain(*arm.radians(u, v), arm.h)[..., :3, :]
    computed = np.array(
        [[library.pose(*row, i) for i in range(arm.segments)] for row in zip(u, v, strict=True)]
    )
    error = computed - expected
    position = np.linalg.norm(error[..., 3], axis=-1).max()
    return float(position), float(np.linalg.norm(error[..., :3], axis=(-2, -1)).max())


def jacobian_errors(library: Library, count: int) -> tuple[float, float]:
    """Worst error of a column's linear (metres per radian) and angular part."""
    arm = library.arm
    u, v = arm.steps(count)
    expected = kin.tip_jacobian(*arm.radians(u, v), arm.h)
    error = np.array([library.jacobian(*row) for row in zip(u, v, strict=True)]) - expected
    linear = np.linalg.norm(error[:, :3], axis=1).max()
    return float(linear), float(np.linalg.norm(error[:, 3:], axis=1).max())


def test_poses_stay_within_the_derived_bounds_over_the_whole_format(library: Library) -> None:
    arm = library.arm
    bounds = error_bounds(arm.segments, arm.length, arm.angle)
    position, rotation = pose_errors(library, 60)
    assert position <= bounds.position
    assert rotation <= bounds.rotation


def test_jacobian_stays_within_the_derived_bounds_over_the_whole_format(library: Library) -> None:
    arm = library.arm
    bounds = error_bounds(arm.segments, arm.length, arm.angle)
    linear, angular = jacobian_errors(library, 60)
    assert linear <= bounds.linear
    assert angular <= bounds.angular


def test_straight_pose_is_exact(library: Library) -> None:
    arm = library.arm
    zero = np.zeros(arm.segments)
    pose = library.pose(zero, zero, arm.segments - 1)
    np.testing.assert_array_equal(pose[:, :3], np.eye(3))
    np.testing.assert_array_equal(pose[:2, 3], 0)


def test_jacobian_is_the_derivative_of_the_double_precision_chain(library: Library) -> None:
    arm, step = library.arm, 1e-4
    u, v = (x[5] for x in arm.steps(6))
    radians = np.concatenate(arm.radians(u, v))
    rotation = kin.tip_pose(*np.split(radians, 2), arm.h)[:3, :3]
    shifted = radians + step * np.concatenate((np.eye(len(radians)), -np.eye(len(radians))))
    upper, lower = np.split(kin.tip_pose(*np.split(shifted, 2, axis=-1), arm.h), 2)
    rate = (upper - lower) / (2 * step)
    spin = rate[:, :3, :3] @ rotation.T
    expected = np.stack((*rate[:, :3, 3].T, spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]))
    bounds = error_bounds(arm.segments, arm.length, arm.angle)
    difference = library.jacobian(u, v) - expected
    assert np.abs(difference[:3]).max() <= bounds.linear + arm.length * step**2
    assert np.abs(difference[3:]).max() <= bounds.angular + step**2


def test_bounds_hold_with_fused_multiply_add_where_the_processor_has_it(tmp_path: Path) -> None:
    arm = ARMS[1]
    fused = Library(arm, tmp_path, "-ffp-contract=fast", "-march=native")
    bounds = error_bounds(arm.segments, arm.length, arm.angle)
    position, rotation = pose_errors(fused, 20)
    linear, angular = jacobian_errors(fused, 20)
    assert position <= bounds.position
    assert rotation <= bounds.rotation
    assert linear <= bounds.linear
    assert angular <= bounds.angular


def test_tip_pose_is_the_last_segments_pose(library: Library) -> None:
    arm = library.arm
    u, v = (x[4] for x in arm.steps(5))
    angles, pose = library.angles(u, v), np.zeros(12, np.float32)
    assert library.dll.arm_tip_pose(pointer(angles), pointer(pose)) == 0
    last = library.pose(u, v, arm.segments - 1)
    np.testing.assert_array_equal(np.column_stack((pose[:9].reshape(3, 3), pose[9:])), last)


def test_wrong_arguments_are_refused_and_nothing_is_written(library: Library) -> None:
    arm, dll = library.arm, library.dll
    angles = library.angles(np.zeros(arm.segments), np.zeros(arm.segments))
    pose = np.full(12, 7.0, np.float32)
    jacobian = np.full((6, 2 * arm.segments), 7.0, np.float32)
    argument_error = -1
    for segment in (arm.segments, 65535):
        segment_ = ctypes.c_uint16(segment)
        assert dll.arm_segment_pose(pointer(angles), segment_, pointer(pose)) == argument_error
    assert dll.arm_segment_pose(None, ctypes.c_uint16(0), pointer(pose)) == argument_error
    assert dll.arm_segment_pose(pointer(angles), ctypes.c_uint16(0), None) == argument_error
    assert dll.arm_tip_pose(None, pointer(pose)) == argument_error
    assert dll.arm_tip_pose(pointer(angles), None) == argument_error
    assert dll.arm_tip_jacobian(None, pointer(jacobian)) == argument_error
    assert dll.arm_tip_jacobian(pointer(angles), None) == argument_error
    assert (pose == 7.0).all()
    assert (jacobian == 7.0).all()


@pytest.mark.parametrize("arm", [ARMS[0], ARMS[3]], ids=["16 bit", "32 bit"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_compiles_without_warnings_as_c_and_cpp(compiler: str, arm: Arm, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.fail(f"{compiler} is not installed")
    source = write(arm, tmp_path)
    for level in ("-O0", "-O3"):
        compile_c(compiler, source, "-std=c99", "-Wmissing-prototypes", level, "-c", "-o/dev/null")
    compile_c(compiler, source, "-xc++", "-std=c++14", "-c", "-o/dev/null")


@pytest.mark.parametrize("core", ["cortex-m0", "cortex-m4"])
@pytest.mark.parametrize("arm", [ARMS[0], ARMS[3]], ids=["16 bit", "32 bit"])
def test_links_no_double_arithmetic_and_no_libm_on_cortex_m(
    core: str, arm: Arm, tmp_path: Path
) -> None:
    if shutil.which("arm-none-eabi-gcc") is None:
        pytest.fail("arm-none-eabi-gcc is not installed (Debian: gcc-arm-none-eabi)")
    target = tmp_path / "arm.o"
    compile_c(
        "arm-none-eabi-gcc", write(arm, tmp_path), "-std=c99", f"-mcpu={core}", "-mthumb", "-O2",
        "-c", "-o", str(target),
    )  # fmt: skip
    listing = subprocess.run(
        ["arm-none-eabi-nm", "--undefined-only", str(target)],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    symbols = {line.split()[-1] for line in listing.splitlines()}
    soft_float = {"fadd", "fsub", "fmul", "i2f"}
    assert symbols <= {f"__aeabi_{operation}" for operation in soft_float}


def test_generated_bytes_are_the_same_every_time() -> None:
    assert render(ARMS[0]) == render(ARMS[0])


def test_degree_follows_the_angle_and_keeps_truncation_below_rounding() -> None:
    chosen = [degrees(angle) for angle in (2.0**-6, 0.125, 1.0, 4.0)]
    assert [d.c for d in chosen] == sorted(d.c for d in chosen)
    for angle, degree in zip((2.0**-6, 0.125, 1.0, 4.0), chosen, strict=True):
        square = 2 * angle**2
        for first, last in ((3, degree.c), (4, degree.d)):
            terms = [(-square) ** k / math.factorial(2 * k + first) for k in range(40)]
            left_out = abs(math.fsum(terms[last + 1 :])) * max(
                math.sqrt(square), square ** (first - 2)
            )
            assert left_out < 2.0**-26


@pytest.mark.parametrize("angle", [0.1, 1.0])
def test_columns_agree_with_casadis_own_differentiation(angle: float) -> None:
    import casadi

    h, degree = 0.03, degrees(angle)
    frame, position = casadi.SX.sym("frame", 3, 3), casadi.SX.sym("position", 3)
    bend = casadi.SX.sym("bend", 2)
    rotation_out, position_out = advance_function(h, degree)(frame, position, bend[0], bend[1])
    derivative = casadi.Function(
        "derivative",
        [frame, position, bend],
        [
            rotation_out,
            position_out,
            casadi.jacobian(casadi.vec(rotation_out), bend),
            casadi.jacobian(position_out, bend),
        ],
    )
    generator = np.random.default_rng(3)
    columns = columns_function(h, degree)
    for _ in range(20):
        u, v = generator.uniform(-angle, angle, 2)
        start = kin.segment_transform(*generator.uniform(-1, 1, 2), 1.0)
        proximal, origin = start[:3, :3], generator.uniform(-1, 1, 3)
        rotation, tip, turned, moved = (np.array(x) for x in derivative(proximal, origin, [u, v]))
        computed = columns(proximal, origin, u, v)
        np.testing.assert_array_equal(np.array(computed[0]), rotation)
        for axis in range(2):
            spin = turned[:, axis].reshape(3, 3, order="F") @ rotation.T
            angular = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
            linear = moved[:, axis] - np.cross(angular, tip[:, 0])
            expected = np.concatenate((linear, angular))
            column = np.array(computed[2 + axis])[:, 0]
            np.testing.assert_allclose(column, expected, rtol=0, atol=2e-7)


def test_bound_grows_with_segments_length_and_angle() -> None:
    reference = error_bounds(12, 0.24, 0.125).position
    assert 1e-7 < reference < 1e-6
    assert error_bounds(24, 0.24, 0.125).position > reference
    assert error_bounds(12, 0.48, 0.125).position == pytest.approx(2 * reference)
    assert error_bounds(12, 0.24, 0.5).position > reference


def test_too_coarse_an_angle_format_is_refused() -> None:
    with pytest.raises(FormatError, match=r"arm: the angle format reaches 8 rad a segment"):
        kinematics_context("arm", 4, 0.1, 16, {"u": 12, "v": 15})


def test_literals_read_back_as_the_nearest_float() -> None:
    for value in (1 / 3, 2.0, 1 / 5040, 2.0**-31, 0.1):
        literal = float_literal(value)
        assert literal.endswith("f")
        assert np.float32(literal[:-1]) == np.float32(value)


def extract(expression: Any, variables: list[Any]) -> casadi_c.Arithmetic:
    import casadi

    function = casadi.Function("f", variables, [expression])
    return casadi_c.arithmetic(function, [[f"x[{i}]"] for i in range(len(variables))], [["*y"]])


def test_extraction_keeps_casadis_arithmetic() -> None:
    import casadi

    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    code = extract(2 * x * y - x * x, [x, y])
    assert code.inputs == (("x_0", "x[0]"), ("x_1", "x[1]"))
    assert code.operations == 4
    assert code.statements[-1].startswith("*y = a")


def test_extraction_refuses_what_it_does_not_know() -> None:
    import casadi

    x = casadi.SX.sym("x")
    with pytest.raises(ToolError, match=r"cannot read: the line 'a0=sin\( ?a0 ?\);'"):
        extract(casadi.sin(x), [x])
    sparse = casadi.Function("f", [x], [casadi.vertcat(x, casadi.SX(1, 1))])
    with pytest.raises(ToolError, match=r"no value for outputs \[\(0, 1\)\]"):
        casadi_c.arithmetic(sparse, [["x"]], [["y[0]", "y[1]"]])
    other = casadi.Function("g", [x], [x * x], {"never_inline": True})
    y = casadi.MX.sym("y")
    with pytest.raises(ToolError, match=r"casadi .* writes C that ccgen cannot read"):
        extract(other(y), [y])


def test_variables_are_named_in_order_of_use_and_constants_stand_where_they_are_used() -> None:
    import casadi

    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    code = extract(0.5 - (x + y) * (x - y), [x, y])
    assert code.variables == ("a0", "a1")
    assert code.statements == (
        "a0 = x_0 + x_1;", "a1 = x_0 - x_1;", "a0 = a0 * a1;", "a0 = 0.5f - a0;", "*y = a0;",
    )  # fmt: skip
    direct = extract(casadi.SX(3), [x])
    assert (direct.variables, direct.statements) == ((), ("*y = 3.0f;",))
