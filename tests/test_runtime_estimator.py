"""The estimator's kernels against the integer reference model, bit for bit."""

import ctypes
import subprocess
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.typing import NDArray
from runtime_c import ADDRESS, COMPILERS, NO_READING, UNDEFINED, compile_c, load

from ccgen.fixedpoint import AxisModel

MISSING = -2


def make_model(
    precision: int, sensors: int, spread: int, saturates: bool, common: bool, seed: int
) -> AxisModel:
    """A model that its proof would accept, with counts of +-spread at most.

    The number of segments differs, so that loops of one, two, three and four a turn occur.
    """
    random = np.random.default_rng(seed)
    top = 2 ** (2 * precision - 1) - 2 ** (2 * precision - 4)
    largest = 2 ** (precision - 1) - 1
    weight = min(largest, top // (sensors * 2 * spread) - 1)
    segments = 7 + (sensors + saturates) % 4
    weights = random.integers(-weight, weight + 1, (segments, sensors))
    weights[0], weights[1] = weight, -weight
    reach = np.abs(weights).sum(axis=1).max() * 2 * spread
    needed = max(0, int(reach).bit_length() - (precision - 1))
    shift = max(0, needed - 3) if saturates else needed + 1
    half = 2**shift // 2
    bias = random.integers(-(2**precision), 2**precision, segments) + half
    bias = np.full(segments, bias[0]) if common else bias
    maximum = random.integers(spread // 2, spread + 1, sensors)
    minimum = -random.integers(spread // 2, spread + 1, sensors)
    zero = random.integers(minimum // 4, maximum // 4 + 1)
    return AxisModel(
        "u", precision, weights, bias, shift, 10, minimum, maximum, zero, saturates, 0, 0.0, 0.0
    )


@dataclass(frozen=True)
class Case:
    name: str
    model: AxisModel


def cases() -> list[Case]:
    """Numbers of sensors in both precisions, narrow and wide, with and without saturation.

    Up to 8 each, which stand one after the other in a kernel; of more, which it loops over, some.

    Segments have a bias of their own in half of the cases, in both widths and with both endings.
    """
    made = []
    for precision, spreads in ((16, (9000, 32767)), (32, (9000, 2**30 - 1))):
        for sensors, (wide, spread), saturates in product(
            (*range(1, 10), 12, 15, 16), enumerate(spreads), (False, True)
        ):
            common = (sensors // 2 + wide + saturates) % 2 == 0
            name = f"p{precision}_n{sensors}_{spread}_{'clip' if saturates else 'fit'}"
            model = make_model(precision, sensors, spread, saturates, common, len(made))
            made.append(Case(name, model))
    return made


CASES = cases()


def array(kind: str, name: str, values: NDArray[np.int64]) -> str:
    suffix = "INT64_C" if kind == "int64_t" else ""
    listed = ", ".join(f"{suffix}({value})" for value in values.ravel().tolist())
    return f"static const {kind} {name}[{values.size}] = {{{listed}}};\n"


def tables(case: Case) -> str:
    """C source of a case's constant model `NAME_axis`, and of its `NAME_sensors` before it."""
    model, name = case.model, case.name
    kind = f"int{model.precision}_t"
    text = "".join(
        array(kind, f"{name}_{what}", getattr(model, what))
        for what in ("minimum", "maximum", "zero")
    )
    common = int(model.bias[0])
    more = model.bias - common
    more_of = f"{name}_biases" if more.any() else "NULL"
    flags = [model.saturates] + ([model.narrow] if model.precision == 16 else [])
    kind = f"int{2 * model.precision}_t"
    text += array(kind, f"{name}_biases", more) if more.any() else ""
    text += rows(model, name)
    fields = [
        model.segments, model.sensors, model.shift, model.fraction_bits,
        *(str(flag).lower() for flag in flags),
        f"INT{2 * model.precision}_C({common})", more_of, f"{name}_rows",
    ]  # fmt: skip
    listed = ", ".join(map(str, fields))
    ends = f"{name}_minimum, {name}_maximum"
    return (
        f"{text}static const ccgen_sensors{model.precision}_t {name}_sensors = "
        f"{{{model.sensors}, {ends}, {name}_zero, NULL, NULL, {ends}}};\n"
        f"static const ccgen_axis{model.precision}_t {name}_axis = {{{listed}}};\n"
    )


def rows(model: AxisModel, name: str) -> str:
    """C source of the weights."""
    if model.precision == 32:
        return array("int32_t", f"{name}_rows", model.weights)
    padded = np.pad(model.weights, ((0, 0), (0, model.sensors % 2))).reshape(-1, 2)
    pairs = ", ".join(f"CCGEN_PAIR({a}, {b})" for a, b in padded.tolist())
    return f"static const uint32_t {name}_rows[] = {{{pairs}}};\n"


def function(case: Case) -> str:
    """A kernel specialised for the constant model; estimates n snapshots, up to the first error."""
    precision = case.model.precision
    return ESTIMATE.format(
        name=case.name, kind=f"int{precision}_t", bits=precision, model="",
        pointer=f"&{case.name}_axis", table=f"&{case.name}_sensors", n=case.model.sensors,
        segments=case.model.segments,
    )  # fmt: skip


ESTIMATE = """
int {name}({model}const {kind} *zero, const {kind} *counts, int n, {kind} *angles);
int {name}({model}const {kind} *zero, const {kind} *counts, int n, {kind} *angles) {{
    int result = 0;
    for (int k = 0; (result == 0) && (k < n); ++k) {{
        result = ccgen_sensors{bits}_complete({table}, zero, counts) ? 0 : -2;
        if (result == 0) {{
            ccgen_axis{bits}_evaluate({pointer}, zero, counts, angles);
        }}
        counts += {n};
        angles += {segments};
    }}
    return result;
}}
"""

SHARED = """
typedef struct {{
    const ccgen_axis{precision}_t *axis;
    const ccgen_sensors{precision}_t *sensors;
}} model{precision}_t;
const model{precision}_t *find{precision}(int which);
const model{precision}_t *find{precision}(int which) {{
    static const model{precision}_t models[] = {{{models}}};
    return &models[which];
}}
int missing{precision}(const model{precision}_t *model, const {kind} *zero, const {kind} *counts);
int missing{precision}(const model{precision}_t *model, const {kind} *zero, const {kind} *counts) {{
    return ccgen_sensors{precision}_missing(model->sensors, zero, counts);
}}
"""


def shared_functions(precision: int) -> str:
    """Functions that learn the model at run time."""
    kind = f"int{precision}_t"
    names = [case.name for case in CASES if case.model.precision == precision]
    models = ", ".join(f"{{&{name}_axis, &{name}_sensors}}" for name in names)
    late = ESTIMATE.format(
        name=f"late{precision}", kind=kind, bits=precision,
        model=f"const model{precision}_t *model, ",
        pointer="model->axis", table="model->sensors", n="model->axis->sensors",
        segments="model->axis->segments",
    )  # fmt: skip
    return SHARED.format(kind=kind, precision=precision, models=models) + late


def functions_of(some: list[Case]) -> str:
    headers = [f"{part}{bits}.h" for bits in (16, 32) for part in ("estimator", "sensors")]
    includes = "".join(f'#include "ccgen/{header}"\n' for header in headers)
    return includes + "".join(tables(case) + function(case) for case in some)


def library_of(text: str, compiler: str, flags: tuple[str, ...]) -> ctypes.CDLL:
    """C source as a library."""
    with TemporaryDirectory() as folder:
        source = Path(folder) / "kernels.c"
        source.write_text(text)
        return ctypes.CDLL(str(compile_c([source], ("-shared", "-fPIC", *flags), compiler)))


@cache
def kernels(compiler: str, flags: tuple[str, ...]) -> ctypes.CDLL:
    """All cases as one library."""
    text = functions_of(CASES) + shared_functions(16) + shared_functions(32)
    library = library_of(text, compiler, flags)
    library.find16.restype = library.find32.restype = ctypes.c_void_p
    return library


def model_of(library: ctypes.CDLL, case: Case) -> ctypes.c_void_p:
    """The C model of a case."""
    precision = case.model.precision
    same = [other for other in CASES if other.model.precision == precision]
    return ctypes.c_void_p(getattr(library, f"find{precision}")(same.index(case)))


def readings(model: AxisModel, n: int) -> NDArray[np.int64]:
    """The range's corners first, then counts at random."""
    random = np.random.default_rng(1)
    sensors = model.sensors
    picks = np.arange(2 ** min(sensors, 8))[:, None] >> np.arange(sensors) & 1
    corners = np.where(picks == 1, model.maximum, model.minimum)
    inside = random.integers(model.minimum, model.maximum + 1, (n, sensors))
    return np.concatenate([corners, inside])


def run(function, model: AxisModel, zero: NDArray[np.int64], counts: NDArray[np.int64]):
    kind = np.dtype(f"int{model.precision}")
    counts = np.atleast_2d(counts).astype(kind)
    zero = zero.astype(kind)
    angles = np.zeros((len(counts), model.segments), kind)
    result = function(
        ctypes.c_void_p(zero.ctypes.data),
        ctypes.c_void_p(counts.ctypes.data),
        len(counts),
        ctypes.c_void_p(angles.ctypes.data),
    )
    return result, angles


BUILDS = [
    *((COMPILERS[0], (level,)) for level in ("-O0", "-O2", "-O3")),
    *((compiler, ("-O2",)) for compiler in COMPILERS[1:]),
    (COMPILERS[0], ("-O0", *UNDEFINED)),
    (COMPILERS[0], ("-O1", "-DCCGEN_HALVES=1", *UNDEFINED)),
]


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: " ".join((build[0], *build[1][:2])))
def test_angles_equal_the_reference_model_at_corners_and_at_random(build):
    library = kernels(*build)
    for case in CASES:
        model = case.model
        constant = getattr(library, case.name)
        late = partial(getattr(library, f"late{model.precision}"), model_of(library, case))
        counts = readings(model, 100)
        for zero in (model.zero, model.ranges.zeros.minimum, model.ranges.zeros.maximum):
            expected = model.estimate(counts, zero)
            for function in (constant, late):
                result, angles = run(function, model, zero, counts)
                assert result == 0
                np.testing.assert_array_equal(angles, expected, case.name)


def test_cases_cover_narrow_and_wide_and_do_saturate():
    assert {case.model.narrow for case in CASES if case.model.precision == 16} == {True, False}
    for case in CASES:
        angles = case.model.estimate(readings(case.model, 100), case.model.ranges.zeros.minimum)
        clipped = bool((np.abs(angles) == case.model.angle_limit).any())
        assert clipped == case.model.saturates, case.name


def ramp(precision: int, sign: int, shift: int) -> Case:
    """angle = sign * limit + count - zero: reaches every value around a limit.

    Where a weight cannot hold a whole step, several counts are one, and the proof keeps sums a step
    away from the ends of their type: angles then end a count inside the limit.
    """
    bits = min(shift, precision - 2)
    counts = 1 << (shift - bits)
    inside = 1 << bits if counts > 1 else 0
    weights = np.full((8, 1), 1 << bits)
    bias = np.full(8, sign * (((2 ** (precision - 1) - 1) << shift) - inside))
    ends = sorted((-50 * counts * sign, 0 if inside else 50 * sign))
    minimum, maximum = (np.array([end]) for end in ends)
    zero = np.array([0])
    model = AxisModel(
        "u", precision, weights, bias, shift, 10, minimum, maximum, zero, True, 0, 0.0, 0.0
    )
    return Case(f"ramp{precision}_{shift}_{'up' if sign > 0 else 'down'}", model)


def every_count(model: AxisModel) -> NDArray[np.int64]:
    """Of a model with one sensor; shape (counts, 1)."""
    return np.arange(model.minimum[0], model.maximum[0] + 1)[:, None]


RAMPS = [
    ramp(bits, sign, shift)
    for (bits, shift), sign in product(
        ((16, 0), (16, 7), (16, 16), (32, 0), (32, 1), (32, 20)), (1, -1)
    )
]
"""Both limits in both widths, at several scales."""


@pytest.mark.parametrize("halves", [0, 1])
def test_saturation_is_exact_step_by_step_around_both_limits(halves):
    """The most negative value, which means "no reading", must never come out."""
    flags = ("-O1", f"-DCCGEN_HALVES={halves}", *UNDEFINED)
    library = library_of(functions_of(RAMPS), COMPILERS[0], flags)
    for case in RAMPS:
        counts = every_count(case.model)
        result, angles = run(getattr(library, case.name), case.model, case.model.zero, counts)
        assert result == 0
        np.testing.assert_array_equal(angles, case.model.estimate(counts), case.name)


def wide(sensors: int) -> Case:
    """Every count of 16 bits but "no reading" is in range."""
    model = make_model(16, sensors, 32767, False, True, seed=sensors)
    ends = np.full(sensors, 32767)
    return Case(f"wide{sensors}", replace(model, minimum=-ends, maximum=ends))


@pytest.mark.parametrize("halves", [0, 1])
def test_a_difference_of_one_sensor_is_exact_on_both_sides_of_16_bits(halves):
    some = [wide(sensors) for sensors in (*range(1, 10), 15, 16)]
    flags = ("-O1", f"-DCCGEN_HALVES={halves}", *UNDEFINED)
    library = library_of(functions_of(some), COMPILERS[0], flags)
    for case, sensor in product(some, range(16)):
        if sensor >= case.model.sensors:
            continue
        zero = np.arange(case.model.sensors)
        for difference in (-32769, -32768, -32767, 32766, 32767, 32768):
            zero[sensor] = -30_000 if difference > 0 else 30_000
            counts = zero + 3
            counts[sensor] = zero[sensor] + difference
            result, angles = run(getattr(library, case.name), case.model, zero, counts)
            assert result == 0
            np.testing.assert_array_equal(angles, case.model.estimate(counts[None], zero))


def test_counts_out_of_range_are_missing_and_nothing_is_written():
    library = kernels(COMPILERS[0], ("-O2",))
    for case in CASES:
        model = case.model
        for sensor in range(model.sensors):
            lowest = -(2 ** (model.precision - 1))
            for outside in (model.minimum[sensor] - 1, model.maximum[sensor] + 1, lowest):
                counts = model.zero.copy()
                counts[sensor] = np.clip(outside, lowest, -lowest - 1)
                if not model.missing(counts).any():
                    continue  # the type ends where the range ends
                result, angles = run(getattr(library, case.name), model, model.zero, counts)
                assert (result, angles.any()) == (MISSING, False)
                held = counts.astype(f"int{model.precision}")
                missing = getattr(library, f"missing{model.precision}")
                held_at = ctypes.c_void_p(held.ctypes.data)
                assert missing(model_of(library, case), held_at, held_at) == 1 << sensor


def test_a_zero_beyond_its_range_is_never_undefined_behaviour():
    """A program that forgets to initialise the state gets wrong angles, not a trap."""
    library = kernels(COMPILERS[0], ("-O0", *UNDEFINED))
    for case in CASES:
        model = case.model
        for junk in (NO_READING >> (32 - model.precision), 2 ** (model.precision - 1) - 1):
            zero = np.full(model.sensors, junk)
            for counts in (model.minimum, model.maximum):
                assert run(getattr(library, case.name), model, zero, counts)[0] == 0


def sample_model(v: int) -> AxisModel:
    """The sample joint's model, read back from its C tables."""
    axis = load().probe_axis(v).contents
    segments, sensors = axis.segments, axis.sensors
    width = (sensors + 1) // 2
    words = np.array(axis.rows[: segments * width], np.int64).reshape(segments, width)
    low, high = (words & 0xFFFF) - 2**15, words.astype(np.uint32).view(np.int32) >> 16
    weights = np.stack([low, high], axis=-1).reshape(segments, -1).astype(np.int64)[:, :sensors]
    bias = axis.bias + np.array(axis.biases[:segments], np.int64)
    table = load().probe_sensors(v).contents
    ranges = [
        np.array(values[:sensors], np.int64)
        for values in (table.minimum, table.maximum, table.zero)
    ]
    return AxisModel(
        "uv"[v], 16, weights, bias, axis.shift, axis.fraction_bits, *ranges, axis.saturates, 0, 0, 0
    )


def test_batches_of_the_shared_port_equal_the_reference_model():
    c = load()
    u, v = sample_model(0), sample_model(1)
    counts = np.concatenate([readings(u, 500), readings(v, 500)], axis=1).astype(np.int16)
    angles = np.zeros((len(counts), 24), np.int16)
    results = np.full(len(counts), 99, np.int8)
    pointer = ctypes.c_void_p
    counts[3, 1] = -32768
    status = c.ccgen_batch_estimate(
        pointer(counts.ctypes.data), None, ctypes.c_size_t(len(counts)),
        pointer(angles.ctypes.data), pointer(results.ctypes.data),
    )  # fmt: skip
    assert status == 0
    good = np.arange(len(counts)) != 3
    assert results[3] == MISSING
    assert not results[good].any()
    assert not angles[3].any()
    expected = [u.estimate(counts[good, :3]), v.estimate(counts[good, 3:])]
    np.testing.assert_array_equal(angles[good], np.concatenate(expected, axis=1))


def test_batches_take_zero_offsets_and_refuse_one_out_of_range():
    c = load()
    u, v = sample_model(0), sample_model(1)
    zero = np.array([100, -200, 300, 5, 6, 7], np.int16)
    counts = np.array([[1000, 2000, -3000, 400, 500, -600]], np.int16)
    angles, results = np.zeros((1, 24), np.int16), np.zeros(1, np.int8)

    def call() -> int:
        held = (counts, zero, angles, results)
        counts_at, zero_at, angles_at, results_at = (ctypes.c_void_p(a.ctypes.data) for a in held)
        return c.ccgen_batch_estimate(counts_at, zero_at, ctypes.c_size_t(1), angles_at, results_at)

    assert call() == 0
    expected = [u.estimate(counts[:, :3], zero[:3]), v.estimate(counts[:, 3:], zero[3:])]
    np.testing.assert_array_equal(angles, np.concatenate(expected, axis=1))
    zero[0] = 20000
    angles[:] = 0
    assert call() == MISSING
    assert not angles.any()


CALL = """
    {{
        {kind} *counts = ({kind} *)malloc({n} * sizeof({kind}));
        {kind} *angles = ({kind} *)malloc({segments} * sizeof({kind}));
        for (int j = 0; j < {n}; ++j) {{
            counts[j] = {name}_maximum[j];
        }}
        failed |= {name}({name}_zero, counts, 1, angles);
        free(counts);
        free(angles);
    }}
"""


def test_kernels_stay_within_their_arrays(tmp_path):
    """Tables and buffers of exact size under AddressSanitizer."""
    some = CASES[::5]
    calls = "".join(
        CALL.format(
            kind=f"int{case.model.precision}_t", n=case.model.sensors, segments=case.model.segments,
            name=case.name,
        )
        for case in some
    )  # fmt: skip
    source = tmp_path / "bounds.c"
    source.write_text(
        f"#include <stdlib.h>\n{functions_of(some)}"
        f"int main(void) {{\n    int failed = 0;\n{calls}    return failed;\n}}\n"
    )
    program = compile_c([source], ("-O0", *ADDRESS), target=tmp_path / "bounds")
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
