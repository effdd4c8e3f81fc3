"""One sensor lost: the weights that serve, and their integers."""

from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.errors import FormatError
from ccgen.estimation import noise_aware, wam
from ccgen.estimation.fallback import expected_error, fallback, held
from ccgen.fixedpoint.fallback import fallbacks, served
from ccgen.fixedpoint.ranges import count_gains
from ccgen.fixedpoint.serving import quantise_with_fallbacks
from ccgen.sensing.counts import counts_of
from ccgen.sensing.noise import reading_noise
from ccgen.sensing.readings import normaliser
from ccgen.shapes import axis_library

EXAMPLES = Path(__file__).parent.parent / "examples"
NOISE = "noise = 2.0e-5"


def fitted(method="wam", **changes):
    tables = f'[estimator]\nmethod = "{method}"'
    return ccgen.fit(ccgen.parse(joint_text(transducer=NOISE, tables=tables, **changes)))


def lost(fit, axis, j):
    return fallback(fit.task, axis, fit.method, j)


def serving(fit, axis):
    own = fit.weights[axis]
    alone = [lost(fit, axis, j) for j in range(own.sensors)]
    return quantise_with_fallbacks(fit.task, axis, own, alone, fit.shapes)


def tables(fit, axis):
    """Fallback rows of an axis, in its format."""
    return serving(fit, axis).fallbacks


@pytest.mark.parametrize("method", ["wam", "noise-aware"])
def test_fallback_weights_are_those_of_a_joint_without_the_sensor(method):
    fit = fitted(method)
    spans = fit.weights["u"].spans
    library = axis_library(fit.shapes, "u", fit.joint.geometry.range_of_motion)
    noise = reading_noise(fit.joint, "u")
    for j in range(3):
        rest = spans[:j] + spans[j + 1 :]
        own = (
            wam(library, rest)
            if method == "wam"
            else noise_aware(library, rest, np.delete(noise, j))
        )
        found = lost(fit, "u", j)
        assert np.array_equal(np.delete(found.matrix, j, axis=1), own.matrix)
        assert not found.matrix[:, j].any()


def test_equal_weights_stay_where_the_others_cover_every_segment():
    spans = [[0, 5], [6, 11], [0, 11]]
    text = joint_text(tables='[estimator]\nmethod = "equal"').replace(
        'placement = "heuristic"\ncount = 3', f"spans = {spans}"
    )
    fit = ccgen.fit(ccgen.parse(text))
    assert [lost(fit, "u", j).method for j in range(3)] == ["equal"] * 3


def test_a_segment_without_a_sensor_falls_back_to_what_the_shapes_allow():
    text = joint_text(tables='[estimator]\nmethod = "direct"').replace("heuristic", "end-to-end")
    fit = ccgen.fit(ccgen.parse(text))
    assert [lost(fit, "u", j).method for j in range(3)] == ["wam"] * 3


def strings(seed, precision):
    """Text of a joint of strings, three along all of it; of odd seeds it elongates."""
    drawn = np.random.default_rng(seed)
    segments, elongates = int(drawn.integers(3, 9)), seed % 2
    text = f"""\
name = "drawn"
[geometry]
segments = {segments}
length = 0.2
range_of_motion = {drawn.uniform(1.0, 8.0)}
{"elongation = [0.0, 0.04]" if elongates else ""}
[sensors.transducer]
metres_per_count = {2.0e-6 if precision == 32 else 3.0e-5 * drawn.choice((-1, 1))}
bits = {24 if precision == 32 else 14}
signed = {"true" if precision == 32 else "false"}
[fixed_point]
precision = {precision}
"""
    for j in range(int(drawn.integers(4, 9))):
        ends = np.sort(drawn.integers(0, segments, 2))
        (first, last), angle = ((0, segments - 1), 120.0 * j) if j < 3 else (ends, 0.0)
        text += f"""\
[[sensor]]
name = "s{j}"
span = [{first}, {last}]
angle = {angle + drawn.uniform(5.0, 100.0)}
radius = {drawn.uniform(0.02, 0.05)}
"""
    return text


JOINTS = {
    **{f"strings {seed}, {bits}": strings(seed, bits) for seed in range(12) for bits in (16, 32)},
    **{name: (EXAMPLES / f"{name}.toml").read_text() for name in ("shoulder", "wrist", "spine")},
}


@pytest.mark.parametrize("name", JOINTS)
def test_floats_are_served_as_integers_are_whatever_is_missing_in_a_row(name):
    fit = ccgen.fit(ccgen.parse(JOINTS[name]))
    model, guarded = fit.model, fit.guarded
    shapes = fit.stated.shapes
    drawn = np.random.default_rng(0)
    counts = counts_of(fit.joint, shapes) + model.readings.zero
    absent = drawn.permuted(
        np.arange(counts.shape[1]) < np.arange(len(counts))[:, None] % 4, axis=1
    )
    floats = fit.estimate(np.where(absent, np.nan, counts))
    for axis, integers in model.split(guarded.estimate(counts, absent)).items():
        own, found = model.axis(axis), getattr(floats, axis)
        lost = integers == -own.angle_limit - 1
        np.testing.assert_array_equal(np.isnan(found), lost)
        assert lost.any()
        # Each weight is off by half a step of the accumulator at most, the angle by half a step.
        steps = 0.5 + np.ldexp(own.span.sum() / 2.0, -own.shift)
        most = own.radians(own.angle_limit)
        off = np.abs(np.clip(found, -most, most) - own.radians(integers))[~lost]
        assert off.max() <= own.radians(steps) * (1 + 1e-9)


def test_weights_are_fitted_once_and_only_where_a_reading_is_missing(monkeypatch):
    from ccgen.estimation import fitted as module

    fit, asked = fitted(), []
    monkeypatch.setattr(module, "fallback", lambda *words: asked.append(words) or fallback(*words))
    counts = np.full((4, 6), 50.0)
    fit.estimate(counts)
    assert not asked
    counts[0, 1] = counts[1, 4] = np.nan
    first = fit.estimate(counts)
    assert len(asked) == 6
    np.testing.assert_array_equal(fit.estimate(counts).u, first.u)
    assert len(asked) == 6


def test_where_no_format_fits_floats_are_served_all_the_same():
    fit = fitted(step=1e-9)
    with pytest.raises(FormatError):
        _ = fit.model
    counts = np.random.default_rng(0).integers(-30_000, 30_000, (20, 6)).astype(float)
    counts[:, 0] = np.nan
    estimate = fit.estimate(counts)
    readings = counts * [sensor.metres_per_count for sensor in fit.sensors] / normaliser(fit.joint)
    free = lost(fit, "u", 0).estimate(np.nan_to_num(readings[:, :3]))
    np.testing.assert_allclose(estimate.u, free, rtol=1e-12, atol=1e-15)


def test_an_axis_of_one_sensor_has_no_fallback():
    assert lost(fitted(count=1), "u", 0) is None


@pytest.mark.parametrize("name", ["shoulder", "wrist", "spine"])
def test_fallbacks_of_the_examples_fit_the_format_of_their_own_weights(name):
    fit = ccgen.fit(ccgen.load(EXAMPLES / f"{name}.toml"))
    for axis in fit.joint.axes:
        model, found = fit.plain.axis(axis), tables(fit, axis)
        assert len(found.rows) == model.sensors
        for j, rows in enumerate(found.rows):
            assert not rows[:, j].any()
            assert np.abs(rows).max() < 2 ** (model.precision - 1)


@pytest.mark.parametrize("name", ["shoulder", "wrist", "spine"])
def test_the_weights_of_the_examples_keep_their_bits_beside_fallbacks(name):
    fit = ccgen.fit(ccgen.load(EXAMPLES / f"{name}.toml"))
    for axis in fit.joint.axes:
        alone, beside = fit.plain.axis(axis), serving(fit, axis).model
        assert np.array_equal(beside.weights, alone.weights)
        assert (beside.shift, beside.fraction_bits) == (alone.shift, alone.fraction_bits)


@pytest.mark.parametrize("layout", ["heuristic", "end-to-end"])
@pytest.mark.parametrize("method", ["wam", "noise-aware"])
@pytest.mark.parametrize("count", [4, 5, 6])
def test_fallbacks_that_need_larger_weights_err_as_without_a_format(layout, method, count):
    text = joint_text(
        transducer=NOISE, count=count, tables=f'[estimator]\nmethod = "{method}"'
    ).replace("heuristic", layout)
    fit = ccgen.fit(ccgen.parse(text))
    found = serving(fit, "u")
    rom = fit.joint.geometry.range_of_motion
    for j, weights in enumerate(found.weights):
        free = expected_error(fit.task, "u", lost(fit, "u", j))
        own = expected_error(fit.task, "u", weights)
        assert own <= 1.01 * free + 1e-4 * rom


@pytest.mark.parametrize("name", ["shoulder", "wrist", "spine"])
def test_holding_weights_to_the_format_costs_little(name):
    fit = ccgen.fit(ccgen.load(EXAMPLES / f"{name}.toml"))
    rom = fit.joint.geometry.range_of_motion
    counts = counts_of(fit.joint, fit.shapes)
    for axis in fit.joint.axes:
        model, found = fit.plain.axis(axis), tables(fit, axis)
        own = fit.joint.own(axis)
        actual = fit.shapes.state[:, fit.joint.rows(axis)]
        for j in range(model.sensors):
            gains = count_gains(fit.joint, axis, lost(fit, axis, j))
            free = np.sqrt(np.mean(np.square(counts[:, own] @ gains.T - actual)))
            absent = np.zeros((len(counts), model.sensors), bool)
            absent[:, j] = True
            values = model.radians(served(model, found.rows, counts[:, own], absent))
            error = np.sqrt(np.mean(np.square(values - actual)))
            assert error <= 1.01 * free + 2e-4 * rom


def test_a_mask_chooses_the_rows_and_two_absent_lose_the_axis():
    fit = fitted()
    model, found = fit.plain.axis("u"), tables(fit, "u")
    differences = np.array([[100, -200, 300]] * 5)
    absent = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 1], [1, 1, 1]], bool)
    values = served(model, found.rows, differences, absent)
    none = -(2**15)
    assert np.array_equal(values[0], model.estimate(differences[0]))
    for j in (0, 1):
        kept = np.where(np.arange(3) == j, 0, differences[0])
        expected = (found.rows[j] @ kept + model.bias) >> model.shift
        assert np.array_equal(values[j + 1], expected)
    assert (values[3:] == none).all()
    assert (values[:3] != none).all()


def test_without_rows_a_lost_sensor_loses_the_axis():
    model = fitted().plain.axis("u")
    absent = np.array([[False, True, False]])
    assert (served(model, (), np.zeros((1, 3), int), absent) == -(2**15)).all()


def test_what_stands_at_an_absent_sensor_is_not_read():
    fit = fitted()
    model, found = fit.plain.axis("u"), tables(fit, "u")
    absent = np.array([[False, True, False]])
    values = [
        served(model, found.rows, np.array([[50, count, -70]]), absent) for count in (0, 12345)
    ]
    assert np.array_equal(*values)


def test_held_weights_keep_their_limit_and_leave_the_others_free():
    fit = fitted("noise-aware", count=5)
    weights = lost(fit, "u", 4)
    limit = np.full(5, 0.8 * np.abs(weights.matrix).max())
    found = held(fit.task, "u", weights, limit)
    assert np.abs(found.matrix).max() <= limit[0]
    within = (np.abs(weights.matrix) <= limit).all(axis=1)
    assert within.any()
    assert np.array_equal(found.matrix[within], weights.matrix[within])


def test_weights_beyond_the_format_are_refused():
    fit = fitted()
    model = fit.plain.axis("u")
    gains = np.full((12, 3), 2.0**-3)
    with pytest.raises(ValueError, match="does not fit the format"):
        fallbacks(model, [gains, None, None])


LISTED = """\
name = "trunk"
[geometry]
segments = 12
length = 0.24
range_of_motion = 3.0
elongation = [0.0, 0.05]
[estimator]
method = "{method}"
axes = ["u", "v", "h"]
[fixed_point]
precision = {precision}
[sensors.transducer]
bits = 12
signed = false
zero = 1024
metres_per_count = 2.4e-5
noise = 1.0e-4
"""


def nine_strings(method, precision):
    """Three levels of three strings at 120 degrees."""
    sensors = [
        f'[[sensor]]\nname = "s{level}{k}"\nspan = [{4 * level}, {4 * level + 3}]\n'
        f"angle = {120.0 * k}\nradius = 0.03\n"
        for level in range(3)
        for k in range(3)
    ]
    return ccgen.parse(LISTED.format(method=method, precision=precision) + "".join(sensors))


@pytest.mark.parametrize("precision", [16, 32])
def test_each_of_nine_coupled_strings_has_a_fallback_on_every_axis(precision):
    fit = ccgen.fit(nine_strings("noise-aware", precision))
    for axis in ("u", "v", "h"):
        found = serving(fit, axis)
        assert all(rows is not None for rows in found.fallbacks.rows)
        for j, weights in enumerate(found.weights):
            free = expected_error(fit.task, axis, lost(fit, axis, j))
            own = expected_error(fit.task, axis, weights)
            assert own <= 1.01 * free + 1e-4 * (1.0 if axis == "h" else np.radians(3.0))


def test_the_only_sensor_that_sees_an_axis_loses_it():
    text = (
        LISTED.format(method="noise-aware", precision=16)
        .replace("elongation = [0.0, 0.05]\n", "")
        .replace('["u", "v", "h"]', '["u", "v"]')
    )
    for name, angle in (("left", 0), ("right", 180), ("top", 90)):
        text += f'[[sensor]]\nname = "{name}"\nspan = [0, 11]\nangle = {angle}\nradius = 0.03\n'
    fit = ccgen.fit(ccgen.parse(text))
    own = fit.joint.own("u")
    found = [fallback(fit.task, "u", "noise-aware", j) for j in range(own.stop - own.start)]
    names = [sensor.name for sensor in fit.joint.sensors[own]]
    gone = [name for name, weights in zip(names, found, strict=True) if weights is None]
    assert gone == ["top"]


NEARLY_EXACT = """\
name = "leg"
[geometry]
segments = 8
length = 1.242
total_range_of_motion = 5.4384
[sensors.transducer]
bits = 32
metres_per_count = 1.15e-08
[shapes]
fit_samples = 10
score_samples = 1
cases = ["s-shape", "end-force", "constant-curvature"]
[fixed_point]
precision = 32
"""

SPANS = (
    (0.0, 0.04803, 0.0, 1.1161295133112692),
    (90.0, 0.01373, 0.0, 1.242),
    (180.0, 0.01724, 0.0, 1.242),
    (63.46612034622143, 0.01088, 0.0, 1.242),
    (-0.7926076862229934, 0.02179, 0.77625, 1.08675),
    (-124.61398604416149, 0.02635, 0.77625, 1.242),
    (90.0, 0.04044, 0.621, 0.6766015959721448),
    (270.0, 0.0126, 0.15525, 0.77625),
    (180.0, 0.01656, 0.621, 1.242),
    (90.0, 0.03632, 0.0, 1.242),
)


def test_a_fallback_that_is_exact_to_rounding_settles():
    listed = (
        f'[[sensor]]\nname = "s{j}"\nangle = {angle}\nradius = {radius}\nspan_m = [{a}, {b}]\n'
        for j, (angle, radius, a, b) in enumerate(SPANS)
    )
    fit = ccgen.fit(ccgen.parse(NEARLY_EXACT + "".join(listed)))
    for axis in ("u", "v"):
        for j in range(len(SPANS)):
            assert np.isfinite(fit.fallback(axis, j, fit.whole.quick).matrix).all()
