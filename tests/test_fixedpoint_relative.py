"""Fixed point of sensors anywhere: elongation, ranges relative to a zero, accepted zeros."""

import json
from itertools import combinations, product

import numpy as np
import pytest

import ccgen
from ccgen.errors import FormatError, InputError
from ccgen.fixedpoint import load_model, model_json
from ccgen.fixedpoint.bounds import largest_accumulator
from ccgen.sensing.counts import corner_counts, counts, counts_of, random_counts, raw_counts
from ccgen.sensing.motion import SOURCES, joint_motion
from ccgen.sensing.noise import still_counts
from ccgen.shapes import fit_library, score_shapes

UNSIGNED = "bits = 12\nsigned = false\nzero = 900"


def text_of(precision=16, transducer=UNSIGNED, step=2.4e-5, sections="[6]"):
    strings = "".join(
        f'[[sensor]]\nname = "s{angle}_{last}"\nspan = [0, {last}]\nangle = {angle}\n'
        "radius = 0.03\n"
        for angle in (90, 210, 330)
        for last in (2, 5)
    )
    return f"""
name = "round"
[geometry]
segments = 6
length = 0.12
range_of_motion = 5.0
elongation = [0.0, 0.04]
sections = {sections}
[sensors.transducer]
metres_per_count = {step}
noise = 5e-5
{transducer}
[estimator]
method = "noise-aware"
[fixed_point]
precision = {precision}
{strings}"""


@pytest.fixture(scope="module", params=[16, 32])
def fit(request):
    return ccgen.fit(ccgen.parse(text_of(request.param)))


def test_every_axis_has_a_format_of_its_own(fit):
    model = fit.model
    assert list(model.axes) == ["u", "v", "h"]
    assert [axis.weights.shape for axis in model.axes.values()] == [(6, 6), (6, 6), (1, 6)]
    assert model.axes["h"].fraction_bits > model.u.fraction_bits
    assert model.segments == 6
    assert model.readings.sensors == 6


def test_integers_estimate_bends_and_elongation_within_the_proven_bound(fit):
    counts = raw_counts(fit.joint, score_shapes(fit.joint))
    values = np.split(fit.model.estimate(counts), [6, 12], axis=1)
    floats = fit.estimate(counts)
    for axis, raw, wanted in zip("uvh", values, (floats.u, floats.v, floats.h), strict=True):
        one = fit.model.axis(axis)
        unit = 1.0 if axis == "h" else fit.joint.geometry.range_of_motion
        bound = one.worst_error_percent_rom / 100 * unit
        assert np.abs(one.radians(raw) - wanted).max() <= bound * (1 + 1e-9)


def test_no_count_and_no_accepted_zero_overflows_the_accumulator(fit):
    for axis in fit.model.axes.values():
        limit = 2 ** (2 * axis.precision - 1)
        far = axis.relative
        assert largest_accumulator(axis.weights, axis.bias, far.span) < limit
        assert (far.span == np.maximum(-far.minimum, far.maximum)).all()


def test_zeros_are_accepted_while_the_range_of_motion_fits_the_counts(fit):
    axis, moved = fit.model.u, counts_of(fit.joint, fit.shapes)
    ends = axis.relative
    for zero in (ends.zero_minimum, ends.zero_maximum):
        assert not axis.refused(zero).any()
        readings = zero + moved
        assert readings.min() >= 0
        assert readings.max() <= 4095
        assert not axis.missing(readings, zero).any()
        assert axis.estimate(readings, zero).shape == (len(moved), 6)
    assert axis.refused(ends.zero_minimum - 1).all()
    assert axis.refused(ends.zero_maximum + 1).all()
    with pytest.raises(ValueError, match="axis u: a count or a zero is outside its range"):
        axis.estimate(ends.zero_minimum, ends.zero_minimum - 1)


def test_a_zero_anywhere_gives_the_same_estimate(fit):
    axis, moved = fit.model.u, counts_of(fit.joint, fit.shapes)[:50]
    ends = axis.relative
    zeros = (ends.zero_minimum, ends.zero_maximum)
    low, high = (axis.estimate(zero + moved, zero) for zero in zeros)
    np.testing.assert_array_equal(low, high)


def test_readings_too_far_from_their_zero_are_missing(fit):
    axis = fit.model.u
    zero, far = axis.zero, axis.relative
    assert axis.missing(zero + far.maximum + 1, zero).all()
    assert axis.missing(zero + far.minimum - 1, zero).all()
    assert not axis.missing(zero + far.maximum, zero).any()


def test_the_model_is_read_back_as_it_was_written(fit, tmp_path):
    path = tmp_path / "model.json"
    path.write_text(model_json(fit.model))
    again = load_model(path)
    assert model_json(again) == model_json(fit.model)
    np.testing.assert_array_equal(again.axes["h"].relative.span, fit.model.axes["h"].relative.span)
    record = json.loads(path.read_text())
    record["axes"]["h"]["relative"]["zero_minimum"] = [1]
    path.write_text(json.dumps(record))
    with pytest.raises(InputError, match=r"damaged .*zero_minimum of a relative range"):
        load_model(path)


def test_a_stated_zero_is_the_models_and_one_that_is_not_lies_nearest_to_the_middle():
    stated = ccgen.fit(ccgen.parse(text_of(transducer="bits = 12\nsigned = false\nzero = 1000")))
    assert (stated.model.readings.zero == 1000).all()
    free = ccgen.fit(ccgen.parse(text_of(transducer="bits = 12\nsigned = false"))).model.u
    ends = free.relative
    assert (free.zero == np.clip(2047, ends.zero_minimum, ends.zero_maximum)).all()
    assert (free.zero == 2047).any()
    signed = ccgen.fit(ccgen.parse(text_of(transducer="bits = 13")))
    assert (signed.model.readings.zero == 0).all()


def test_strings_that_lengthen_more_than_they_shorten_have_ranges_to_match():
    far = ccgen.fit(ccgen.parse(text_of())).model.u.relative
    assert (far.maximum > -far.minimum).all()
    falling = text_of(step=-2.4e-5, transducer="bits = 13")
    fallen = ccgen.fit(ccgen.parse(falling)).model.u.relative
    assert (np.abs(fallen.minimum + far.maximum) <= 1).all()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (
            {"transducer": "bits = 12\nsigned = false\nzero = 10"},
            r"sensor\[?.*zero: sensor s\d+_\d would run out of counts .* its zero at 10; write a "
            r"zero from \d+ to \d+",
        ),
        (
            {"step": 1e-6},
            r"metres_per_count: sensor s\d+_\d needs \d+ counts over the range of motion and has "
            r"4095; use at least [\d.e-]+ m per count, or more bits",
        ),
        (
            {"step": 0.1},
            r"metres_per_count: sensor s\d+_\d moves less than half a count over the range of "
            r"motion; use at most [\d.e-]+ m per count",
        ),
    ],
)
def test_counts_that_do_not_hold_the_range_of_motion_are_refused(options, says):
    with pytest.raises(FormatError, match=says):
        _ = ccgen.fit(ccgen.parse(text_of(**options))).model


def test_differences_that_32_bits_do_not_hold_are_no_readings():
    far = "bits = 32\nrange = [-2147483647, 2147483647]\nzero = 1000000000"
    axis = ccgen.fit(ccgen.parse(text_of(32, far, step=1e-9))).model.u
    assert (axis.relative.minimum == -(2**31) + 1).all()
    assert (axis.relative.maximum == 2**31 - 1 - 10**9).all()
    lowest = np.full(6, 10**9 - 2**31)
    assert axis.missing(lowest).all()
    assert not axis.missing(lowest + 1).any()


def test_simulated_counts_are_readings_of_the_model_though_no_zero_is_stated():
    fit = ccgen.fit(ccgen.parse(text_of(transducer="bits = 12\nsigned = false", step=4e-5)))
    counts = raw_counts(fit.joint, score_shapes(fit.joint))
    assert not fit.model.u.missing(counts).any()
    straight = ccgen.simulate(fit.joint, "uniform", 0.0)
    np.testing.assert_array_equal(straight.counts, fit.model.readings.zero)


def test_rest_is_told_from_motion_by_the_motion_whatever_counts_there_are():
    text = text_of(transducer="bits = 16\nsigned = false", precision=32).replace("noise = 5e-5", "")
    fit = ccgen.fit(ccgen.parse(text.replace("noise-aware", "wam")))
    moved = fit.model.readings.moved
    reach = np.ptp(np.vstack([counts_of(fit.joint, fit.shapes), np.zeros((1, 6))]), axis=0)
    assert (moved >= reach).all()
    assert (moved < 2**15).all()
    np.testing.assert_array_equal(still_counts(fit.joint, moved), np.maximum(moved // 100, 2))


def test_sections_are_rows_of_elongation():
    fit = ccgen.fit(ccgen.parse(text_of(sections="[3, 3]")))
    assert fit.model.axes["h"].weights.shape == (2, 6)


# ---- what is simulated -----------------------------------------------------------------------


@pytest.mark.parametrize("source", SOURCES)
def test_a_motion_of_the_joint_bends_and_stretches_within_its_ranges(source):
    joint = ccgen.parse(text_of(sections="[2, 4]"))
    shapes = joint_motion(joint, source, fit_library(joint), 400, 100)
    assert shapes.h.shape == (400, 2)
    assert shapes.h.min() == 0.0
    assert 0.038 < shapes.h.max() <= 0.04
    assert np.abs(np.diff(shapes.h, axis=0)).max() < 0.005
    assert np.abs(shapes.h[:, 0] - shapes.h[:, 1]).max() > 0.01
    assert np.abs(shapes.u).max() <= np.abs(fit_library(joint).angles).max() * (1 + 1e-12)


def test_counts_of_a_motion_are_readings_with_their_zeros(fit):
    shapes = joint_motion(fit.joint, "sweep", fit_library(fit.joint), 50, 50)
    drawn = counts(fit.joint, [fit.model.readings], shapes)
    np.testing.assert_array_equal(drawn, fit.model.readings.zero + counts_of(fit.joint, shapes))
    assert not fit.model.u.missing(drawn).any()
    assert random_counts([fit.model.readings], 7).shape == (7, 6)


@pytest.mark.parametrize("sensors", [9, 12, 16])
def test_corners_of_many_sensors_hold_every_combination_of_any_three(sensors):
    class Range:
        minimum = np.arange(sensors) - 100
        maximum = np.arange(sensors) + 100
        zero = np.arange(sensors)

    Range.sensors = sensors
    corners = corner_counts([Range])
    assert len(corners) < 100
    upper = corners[:-2] == Range.maximum
    assert (upper | (corners[:-2] == Range.minimum)).all()
    for three in combinations(range(sensors), 3):
        assert len({tuple(row) for row in upper[:, three].tolist()}) == len(
            list(product((0, 1), repeat=3))
        )
    assert {1, sensors - 1} <= set(upper.sum(axis=1).tolist())
