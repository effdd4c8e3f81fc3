import hashlib
import json
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_files import joint_text

import ccgen
from ccgen.errors import FormatError, InputError
from ccgen.estimation import fit_joint
from ccgen.fixedpoint import load_model, model_json, quantise
from ccgen.fixedpoint.bounds import largest_accumulator
from ccgen.fixedpoint.ranges import count_gains
from ccgen.joint import AXES
from ccgen.joint.file import parse_joint
from ccgen.sensing.counts import counts_of
from ccgen.shapes import fit_shapes, unstretched


def joint_of(segments=12, count=3, precision=16, step=2.0e-6, method="wam", extra="", bits=None):
    text = joint_text(
        segments=segments, count=count, precision=precision, step=step, transducer=extra,
        bits=bits, tables=f'[estimator]\nmethod = "{method}"',
    )  # fmt: skip
    return parse_joint(text, "shoulder.toml")


def model_of(**options):
    joint = joint_of(**options)
    shapes = fit_shapes(joint)
    weights = fit_joint(joint, shapes=shapes)
    return SimpleNamespace(
        joint=joint, shapes=shapes, weights=weights, model=quantise(joint, weights, shapes)
    )


CASES = [
    {},
    {"precision": 32, "step": 1e-9},
    {"segments": 48, "count": 6},
    {"segments": 48, "count": 6, "precision": 32, "step": 1e-8},
    {"count": 1},
    {"count": 8, "method": "equal"},
    {"extra": "range = [-20000, 20000]"},
    {"extra": "range = [-11000, 32000]"},
    {"precision": 32, "extra": "range = [-1000000000, 1000000000]"},
]


@pytest.fixture(scope="module", params=CASES, ids=str)
def made(request):
    return model_of(**request.param)


def python_angles(axis, counts, zero):
    """The contract of the arithmetic with Python's integers, checking every width."""
    result = []
    for row, bias in zip(axis.weights.tolist(), axis.bias.tolist(), strict=True):
        acc = bias
        for w, c, z in zip(row, counts, zero, strict=True):
            assert abs(w) < 2 ** (axis.precision - 1)
            acc += w * (c - z)
            assert abs(acc) < 2 ** (2 * axis.precision - 1)
        result.append(max(-axis.angle_limit, min(axis.angle_limit, acc >> axis.shift)))
    return result


def draw_counts(data, ranges):
    limits = zip(ranges.minimum.tolist(), ranges.maximum.tolist(), strict=True)
    return [data.draw(st.sampled_from((a, b)) | st.integers(a, b)) for a, b in limits]


@settings(max_examples=40)
@given(data=st.data())
def test_the_model_is_the_contract_for_every_count_and_zero(made, data):
    axis = made.model.axis(data.draw(st.sampled_from(AXES)))
    counts, zero = draw_counts(data, axis), draw_counts(data, axis.ranges.zeros)
    assert axis.estimate(counts, zero).tolist() == python_angles(axis, counts, zero)


def test_no_accumulator_overflows_and_no_larger_shift_would_fit(made):
    for axis in (made.model.u, made.model.v):
        span = axis.span
        limit = 2 ** (2 * axis.precision - 1) - 1
        assert largest_accumulator(axis.weights, axis.bias, span) + 2**axis.shift <= limit
        weights = np.rint(
            np.ldexp(
                count_gains(made.joint, axis.axis, made.weights[axis.axis]),
                axis.shift + axis.fraction_bits + 1,
            )
        )
        too_wide = np.abs(weights).max() >= 2 ** (axis.precision - 1)
        sums = max(
            sum(abs(int(w)) * int(d) for w, d in zip(row, span, strict=True)) for row in weights
        )
        assert too_wide or sums + 3 * 2**axis.shift > limit


@settings(max_examples=40)
@given(data=st.data())
def test_what_quantisation_adds_stays_below_the_proven_bound(made, data):
    axis = made.model.axis(data.draw(st.sampled_from(AXES)))
    counts, zero = draw_counts(data, axis), draw_counts(data, axis.ranges.zeros)
    gains = count_gains(made.joint, axis.axis, made.weights[axis.axis])
    differences = [c - z for c, z in zip(counts, zero, strict=True)]
    bound = Fraction(axis.worst_error_percent_rom * made.joint.geometry.range_of_motion / 100.0)
    for angle, row in zip(axis.estimate(counts, zero).tolist(), gains.tolist(), strict=True):
        exact = sum(Fraction(g) * d for g, d in zip(row, differences, strict=True))
        error = abs(Fraction(angle, 2**axis.fraction_bits) - exact)
        saturated = abs(angle) == axis.angle_limit
        assert error <= bound * (1 + Fraction(1, 10**9)) or (saturated and axis.saturates)


def test_an_axis_said_not_to_saturate_never_does(made):
    for axis in (made.model.u, made.model.v):
        extreme = np.where(axis.weights >= 0, axis.span, 0)
        opposite = np.where(axis.weights >= 0, 0, axis.span)
        largest = max(
            python_angles(replace(axis, precision=2 * axis.precision), c, z)[i]
            for i, (c, z) in enumerate(zip(extreme.tolist(), opposite.tolist(), strict=True))
        )
        assert axis.saturates == (largest > axis.angle_limit)


def test_quantisation_of_the_example_adds_no_more_than_promised():
    sixteen, thirty_two = model_of().model.u, model_of(precision=32).model.u
    assert sixteen.worst_error_percent_rom <= 0.06
    assert sixteen.rms_error_percent_rom <= 0.015
    assert thirty_two.worst_error_percent_rom <= 1e-5


@pytest.mark.parametrize("transducer", [{}, {"bits": 32, "precision": 32, "step": 1e-8}])
def test_the_default_range_holds_the_shapes_around_every_zero_that_is_accepted(transducer):
    made = model_of(**transducer)
    counts = np.abs(counts_of(made.joint, made.shapes)).max(axis=0)[:3]
    axis, zeros = made.model.u, made.model.u.ranges.zeros
    assert np.array_equal(zeros.minimum, -zeros.maximum)
    assert (zeros.maximum >= 0.7 * counts).all()
    for zero in (zeros.minimum, zeros.maximum):
        assert not axis.refused(zero).any()
        assert not axis.missing([zero - counts, zero, zero + counts], zero).any()
    for j in range(3):
        beyond = zeros.maximum + (np.arange(3) == j)
        assert np.flatnonzero(axis.refused(beyond)).tolist() == [j]
    # Differences are as large as where counts and zeros both lie within a quarter more.
    assert np.array_equal(axis.span, 2 * np.ceil(1.25 * counts).astype(np.int64))


def test_a_transducer_without_counts_to_spare_takes_fewer_zeros():
    made = model_of(bits=12, step=1.5e-5)
    counts = np.abs(counts_of(made.joint, made.shapes)).max(axis=0)[:3]
    axis = made.model.u
    assert axis.maximum[2] == 2047 < 1.75 * counts[2]
    assert axis.ranges.zeros.maximum[2] == 2047 - counts[2]


def test_a_declared_range_takes_the_zeros_that_leave_it_the_shapes():
    made = model_of(extra="range = [-20000, 30000]")
    counts = np.abs(counts_of(made.joint, made.shapes)).max(axis=0)[:3]
    zeros = made.model.u.ranges.zeros
    assert np.array_equal(zeros.minimum, -20000 + counts)
    assert np.array_equal(zeros.maximum, 30000 - counts)


def test_counts_turn_back_into_the_angles_of_a_constant_curve():
    made = model_of(step=1e-7, precision=32)
    angles = np.full((1, 12), 0.02)
    counts = counts_of(made.joint, unstretched(angles, angles))[:, :3]
    estimate = made.model.u.radians(made.model.u.estimate(counts))
    assert np.abs(estimate - angles).max() < 1e-3 * 0.02


def test_readings_outside_the_range_are_missing_and_not_estimated():
    axis = model_of().model.u
    counts = axis.maximum + np.array([0, 1, 0])
    assert axis.missing(counts).tolist() == [False, True, False]
    with pytest.raises(ValueError, match="outside its range"):
        axis.estimate(counts)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"step": 2e-7}, r"sensor 2 of axis u \(span \[7, 11\]\) needs counts of .* 16 bits hold"),
        ({"bits": 8}, "8 bits hold ±127;"),
        ({"bits": 3, "step": 2e-3}, "3 bits hold ±3;"),
        ({"precision": 32, "bits": 20, "step": 1e-9}, "20 bits hold ±524287;"),
        ({"precision": 32, "step": 1.2e-11}, "32 bits hold ±1073741823 and their differences;"),
        ({"step": 0.05}, "moves less than half a count"),
    ],
)
def test_a_transducer_too_fine_or_too_coarse_is_refused_with_remedies_that_work(options, said):
    with pytest.raises(FormatError, match=said) as refused:
        model_of(**options)
    message = str(refused.value)
    step = re.search(r"at (?:least|most) (\S+) m per count", message)
    model_of(**options | {"step": float(step[1])})
    for bits, widened in re.findall(r"bits = (\d+)( with fixed_point.precision = 32)?", message):
        precision = 32 if widened else options.get("precision", 16)
        model_of(**options | {"bits": int(bits), "precision": precision})


def test_with_so_few_bits_only_more_bits_help():
    with pytest.raises(FormatError, match=r"2 bits hold ±1; use bits = \d+$"):
        model_of(bits=2)


def test_the_difference_of_any_count_and_zero_fits_32_bits():
    axis = model_of(precision=32, step=2.4e-11).model.u
    assert 2**30 < (axis.maximum - axis.ranges.zeros.minimum).max() <= axis.span.max() <= 2**31 - 1


def test_a_message_names_the_key_that_the_axis_has_itself():
    for key in ("metres_per_count = 1e-9", "range = [-900, 900]"):
        with pytest.raises(FormatError, match=rf"sensors\.v\.transducer\.{key.split()[0]}: .* v "):
            model_of(extra=f"[sensors.v.transducer]\n{key}")


def test_a_declared_range_that_the_shapes_leave_is_refused():
    with pytest.raises(FormatError, match=r"range: sensor 2 .* reaches ±\d+ .*\[-900, 900\]"):
        model_of(extra="range = [-900, 900]")


def test_a_range_wider_than_a_32_bit_difference_is_refused():
    with pytest.raises(FormatError, match="32-bit difference"):
        model_of(precision=32, extra="range = [-2147483647, 2147483647]")


def test_a_model_read_back_is_the_model_written(tmp_path):
    model = model_of().model
    path = tmp_path / "model.json"
    path.write_text(model_json(model))
    again = load_model(path)
    assert model_json(again) == model_json(model)
    assert np.array_equal(again.u.weights, model.u.weights)


@pytest.mark.parametrize("text", ["", "{}", '{"format": 1, "name": 3}', "[1]", '{"format": 99}'])
def test_a_damaged_model_is_an_error_that_names_the_file(tmp_path, text):
    path = tmp_path / "model.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"model\.json: .*export the joint again"):
        load_model(path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("weights", [[1, 2]]), ("weights", [1, 2]), ("weights", []), ("bias", [0]),
        ("minimum", [[-5], [5]]), ("zero", 0), ("shift", -1), ("shift", 32),
    ],
)  # fmt: skip
def test_a_model_whose_numbers_do_not_fit_together_is_damaged(tmp_path, key, value):
    record = json.loads(model_json(model_of().model))
    record["axes"]["v"][key] = value
    path = tmp_path / "model.json"
    path.write_text(json.dumps(record))
    with pytest.raises(
        InputError, match=r"model\.json: damaged \(axis v: .*export the joint again"
    ):
        load_model(path)


EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize(
    ("name", "digest"),
    [
        ("shoulder", "9de8c6d1b9967a47"),
        ("spine", "aad9c67f6ccc3129"),
        ("wrist", "7fddc096e7c1949b"),
    ],
)
def test_the_examples_keep_the_bits_of_their_weights(name, digest):
    axes = ccgen.fit(ccgen.load(EXAMPLES / f"{name}.toml")).model.axes
    bits = {
        axis: [one.weights.tolist(), one.bias.tolist(), one.shift, one.fraction_bits]
        for axis, one in axes.items()
    }
    assert hashlib.sha256(json.dumps(bits).encode()).hexdigest()[:16] == digest
