"""Sensors held against each other: residuals, false alarms, faults, and the integer check."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from ccgen.estimation.consistency.alarms import alarm_rate, thresholds
from ccgen.estimation.consistency.box import boxed, half_edge
from ccgen.estimation.consistency.faults import faults
from ccgen.estimation.consistency.residuals import KEPT, alarm_matrix, parity
from ccgen.estimation.consistency.sound import SoundReadings
from ccgen.fixedpoint.checking import Transducers, checked_groups
from ccgen.fixedpoint.consistency import NOBODY, GroupCheck, rounded_parity
from ccgen.fixedpoint.watch import BACK_AFTER, OUT_AFTER, Watch
from ccgen.joint.layouts import spans_for
from ccgen.sensing.readings import reading_matrix
from ccgen.shapes.loads.other import other_shapes

RADIUS = 0.05
ROM = np.radians(3.0)
NOISE = 1e-3 * 12 * ROM * RADIUS
STEP = 2e-6


def sound(layout="heuristic", sensors=6, noise=NOISE, tolerance=0.0, axes=1):
    """Readings of 12 segments under loads of many kinds, alike in every axis."""
    spans = spans_for(layout, 12, sensors)
    lengths = np.array([b - a + 1 for a, b in spans]) * RADIUS
    angles = other_shapes(12, ROM).angles
    read = angles @ reading_matrix(12, spans).T * lengths
    read = np.concatenate([np.roll(read, axis, axis=0) for axis in range(axes)], axis=1)
    variance = noise**2 + np.square(tolerance * read)
    return SoundReadings(read, variance, np.full(len(read), 1 / len(read)))


def transducers(readings, precision=16):
    largest = np.abs(readings.lengths).max(axis=0)
    span = np.ceil(1.25 * largest / STEP).astype(np.int64)
    return Transducers(np.full(readings.sensors, STEP), span, precision)


def snapshots(readings, count, seed):
    random = np.random.default_rng(seed)
    rows = random.integers(len(readings.weight), size=count)
    noise = random.normal(size=(count, readings.sensors)) * np.sqrt(readings.variance[rows])
    return readings.lengths[rows] + noise


def counts(lengths):
    return np.rint(lengths / STEP).astype(np.int64)


def test_residual_is_what_the_other_sensors_do_not_predict():
    readings = sound()
    moment = readings.lengths.T @ readings.lengths / len(readings.lengths)
    moment += NOISE**2 * np.eye(6)
    matrix = parity(readings).naming
    assert np.diag(matrix @ moment @ matrix.T) == pytest.approx(np.ones(6))
    for j in range(6):
        others = np.delete(np.arange(6), j)
        predicted = np.linalg.solve(moment[np.ix_(others, others)], moment[others, j])
        assert matrix[j, others] / matrix[j, j] == pytest.approx(-predicted, rel=1e-6)


def test_few_coordinates_keep_the_power_that_decides_on_alarms():
    readings = sound(sensors=8)
    found = parity(readings)
    assert found.kept < 6
    moment = readings.lengths.T @ readings.lengths / len(readings.lengths)
    moment += NOISE**2 * np.eye(8)
    assert found.basis @ moment @ found.basis.T == pytest.approx(np.eye(8), abs=1e-6)
    power = np.square(found.directions)
    assert power.sum(axis=1) == pytest.approx(np.ones(8))
    assert KEPT <= power[:, : found.kept].sum(axis=1).min() < 1.0 - 1e-4


def test_a_turned_box_is_larger_and_its_residuals_are_the_same():
    readings = sound(sensors=8)
    found, limits = parity(readings), np.linspace(4.0, 5.0, 8)
    turned = boxed(found, limits)
    assert half_edge(turned, limits) > 1.02 * half_edge(found, limits)
    assert turned.alarming == pytest.approx(found.alarming, rel=1e-9, abs=1e-6)
    assert turned.naming == pytest.approx(found.naming, rel=1e-9, abs=1e-6)


def test_coordinates_do_not_depend_on_the_order_of_shapes():
    readings = sound(sensors=8)
    other = SoundReadings(readings.lengths[::-1], readings.variance[::-1], readings.weight[::-1])
    assert parity(other).basis == pytest.approx(parity(readings).basis, rel=1e-6, abs=1e-3)


def test_groups_do_not_meet_in_the_residuals():
    matrix = alarm_matrix(sound(axes=2), [slice(0, 6), slice(6, 12)])
    assert not matrix[:6, 6:].any()
    assert not matrix[6:, :6].any()


def test_rate_of_two_like_residuals_is_that_of_one():
    readings = SoundReadings(np.zeros((1, 2)), np.ones((1, 2)), np.ones(1))
    alike = np.array([[1.0, 1.0], [1.0, 1.0]])
    rate = alarm_rate(alike, np.full(2, 6.0 * np.sqrt(2)), readings)
    assert rate == pytest.approx(2 * ndtr(-6.0), rel=1e-9)


def test_rate_of_independent_residuals_is_their_union():
    readings = SoundReadings(np.zeros((1, 3)), np.ones((1, 3)), np.ones(1))
    expected = 1 - (1 - 2 * ndtr(-1.5)) ** 3
    assert alarm_rate(np.eye(3), np.full(3, 1.5), readings) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("layout", ["heuristic", "end-to-end"])
@pytest.mark.parametrize("tolerance", [0.0, 0.01])
def test_false_alarms_of_the_integer_check_come_at_the_stated_rate(layout, tolerance):
    readings = sound(layout, tolerance=tolerance, axes=2)
    found = checked_groups(readings, [slice(0, 6), slice(6, 12)], transducers(readings), rate=1e-4)
    alarms, total = 0, 0
    for seed in range(10):
        differences = counts(snapshots(readings, 100_000, seed))
        alarm = [one.check.verdicts(differences[:, one.check.own])[0] for one in found]
        alarms += int(np.logical_or(*alarm).sum())
        total += len(differences)
    assert total == 1_000_000
    assert 0.5e-4 <= alarms / total <= 2e-4


@pytest.mark.parametrize("precision", [16, 32])
def test_faults_of_the_told_size_are_seen_and_named(precision):
    readings = sound(sensors=8)
    (one,) = checked_groups(readings, [slice(0, 8)], transducers(readings, precision), rate=1e-6)
    lengths = snapshots(readings, 20_000, seed=7)
    assert one.faults.isolable.any()
    for j, size in enumerate(one.faults.detectable):
        for sign in (-1, 1):
            faulty = lengths + sign * size * (np.arange(8) == j)
            alarm, named = one.check.verdicts(counts(faulty))
            assert alarm.mean() >= 0.98
            if one.faults.isolable[j]:
                assert np.mean(named == j) >= 0.95
            assert np.mean((named != j) & (named != NOBODY)) <= 0.06


def test_overlap_sees_smaller_faults_than_spans_end_to_end():
    told = {}
    for layout in ("heuristic", "end-to-end"):
        readings = sound(layout)
        (one,) = checked_groups(readings, [slice(0, 6)], transducers(readings), rate=1e-4)
        told[layout] = one.faults.detectable / np.abs(readings.lengths).max(axis=0)
    assert (told["heuristic"] < told["end-to-end"]).all()


def test_one_sensor_is_not_checked():
    readings = sound(sensors=1)
    assert checked_groups(readings, [slice(0, 1)], transducers(readings), 1e-6) == []


def test_a_group_that_sees_no_fault_is_left_out_and_takes_no_alarms():
    readings = sound(layout="end-to-end", sensors=2, axes=1)
    assert checked_groups(readings, [slice(0, 2)], transducers(readings), 1e-6) == []


@pytest.mark.parametrize("precision", [16, 32])
@pytest.mark.parametrize("narrower", [0, 4])
def test_sums_cannot_overflow_waste_no_bit_and_hide_no_alarm(precision, narrower):
    readings = sound()
    exact, limits = parity(readings), np.full(6, 5.0)
    span = np.full(6, 2 ** (precision - narrower) - 1)
    found = rounded_parity(exact, limits, np.full(6, STEP), span, precision)
    check = GroupCheck(
        0, precision, found.weights, found.kept, found.quiet_bits, found.directions,
        found.thresholds(limits), np.zeros(6, np.int64),
    )  # fmt: skip
    assert check.flaw(span) is None
    finer = replace(check, weights=2 * found.weights, quiet_bits=found.quiet_bits + 1)
    weight_limit = 2 ** (precision - 1) - 1
    too_large = 2 * np.abs(found.weights).max() > weight_limit - 1
    assert too_large or finer.flaw(span) == "a sum may overflow"
    assert replace(check, threshold=check.threshold // 2).flaw(span) == "an alarm may pass unseen"
    assert replace(check, directions=2 * found.directions).flaw(span) == "a residual may overflow"
    assert found.steps(np.array([5.0, 1e9])).tolist()[1] == 2**31 - 1


def test_a_quiet_box_hides_no_alarm_and_holds_nearly_all_that_is_sound():
    readings = sound(sensors=8)
    (one,) = checked_groups(readings, [slice(0, 8)], transducers(readings), rate=1e-4)
    check, differences = one.check, counts(snapshots(readings, 100_000, seed=3))
    values = differences @ check.weights[: check.kept].T
    edge = 2**check.quiet_bits
    quiet = ((values >= -edge) & (values < edge)).all(axis=1)
    assert quiet.mean() > 0.95
    assert not check.verdicts(differences[quiet])[0].any()


def test_thresholds_rise_as_alarms_become_rarer():
    readings = sound()
    matrix = parity(readings).alarming
    often, seldom = (thresholds(matrix, readings, rate) for rate in (1e-2, 1e-6))
    assert (seldom > often).all()
    assert alarm_rate(matrix, seldom, readings) == pytest.approx(1e-6, rel=0.01)


def test_a_larger_fault_is_isolated_where_the_smallest_seen_is_not():
    readings = sound("end-to-end", sensors=4)
    found = parity(readings)
    limits = thresholds(found.alarming, readings, 1e-4)
    told = faults(found.alarming, found.naming, limits, readings)
    known = ~np.isnan(told.isolated)
    assert (told.isolated[known] >= told.detectable[known]).all()
    assert (told.isolated[told.isolable] == told.detectable[told.isolable]).all()


def after(watch, *verdicts):
    for complete, alarm, named in verdicts:
        watch = watch.after(complete, alarm, named)
    return watch


QUIET, FLAGGED, GAP = (True, False, NOBODY), (True, True, NOBODY), (False, False, NOBODY)


def names(sensor):
    return (True, True, sensor)


def test_a_sensor_is_left_out_after_three_snapshots_that_name_it():
    assert not after(Watch(), *[names(2)] * (OUT_AFTER - 1)).out
    assert after(Watch(), *[names(2)] * OUT_AFTER) == Watch(2, 0, True)


@pytest.mark.parametrize("between", [QUIET, FLAGGED, GAP, names(1)])
def test_a_run_begins_anew_after_any_other_snapshot(between):
    watch = after(Watch(), names(2), names(2), between, names(2), names(2))
    assert watch == Watch(2, 2, False)


def test_a_sensor_comes_back_after_twenty_snapshots_that_agree():
    out = Watch(2, 0, True)
    assert after(out, *[QUIET] * (BACK_AFTER - 1)).out
    assert after(out, *[QUIET] * BACK_AFTER) == Watch()


@pytest.mark.parametrize("between", [FLAGGED, GAP, names(2)])
def test_a_sensor_that_is_out_starts_again_after_a_snapshot_against_it(between):
    watch = after(Watch(2, 0, True), *[QUIET] * 19, between)
    assert watch == Watch(2, 0, True)


def test_a_sound_sensor_comes_back_while_another_is_named():
    watch = after(Watch(2, 0, True), *[names(4)] * BACK_AFTER)
    assert watch == Watch()
    assert after(watch, *[names(4)] * OUT_AFTER) == Watch(4, 0, True)
