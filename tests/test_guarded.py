"""Sensors that fail over time: the integer model with its fallbacks and checks."""

import json

import numpy as np
import pytest
from joint_files import joint_text
from test_joint_checks import counted, loaded, read_by

import ccgen
from ccgen.fixedpoint.guarded import DEGRADED, GOOD, LOST
from ccgen.fixedpoint.guarded_storage import guard_record, guarded_model
from ccgen.fixedpoint.watch import BACK_AFTER, OUT_AFTER

NONE = -(2**15)


@pytest.fixture(scope="module")
def fit():
    return ccgen.fit(ccgen.parse(loaded("false_alarms = 1e-6")))


@pytest.fixture(scope="module")
def counts(fit):
    return counted(fit, read_by(fit, 100, seed=3))


def test_nothing_absent_gives_the_plain_model_bit_for_bit(fit, counts):
    found = fit.guarded.follow(counts)
    assert np.array_equal(found.values, fit.guarded.model.estimate(counts))
    assert (found.states == GOOD).all()
    assert not found.suspected.any()


def test_a_lost_sensor_degrades_its_axis_and_leaves_the_other_alone(fit, counts):
    segments = fit.joint.geometry.segments
    whole = fit.guarded.model.estimate(counts)
    for j in range(16):
        lost = counts.copy()
        lost[:, j] = NONE
        found = fit.guarded.follow(lost)
        axis, other = (0, 1) if j < 8 else (1, 0)
        assert (found.states[:, axis] == DEGRADED).all()
        assert (found.states[:, other] == GOOD).all()
        kept = slice(other * segments, (other + 1) * segments)
        assert np.array_equal(found.values[:, kept], whole[:, kept])
        assert (found.values != NONE).all()


def test_two_lost_sensors_lose_their_axis_and_no_other(fit, counts):
    lost = counts.copy()
    lost[:, [1, 4]] = NONE
    found = fit.guarded.follow(lost)
    assert (found.values[:, :12] == NONE).all()
    assert (found.values[:, 12:] != NONE).all()
    assert (found.states == [LOST, GOOD]).all()


def test_an_error_without_a_sensor_is_what_fit_told(fit):
    shapes = fit.stated.shapes
    step = np.array([sensor.metres_per_count for sensor in fit.joint.sensors])
    from ccgen.sensing.readings import length_changes

    lengths = length_changes(fit.joint, shapes.state)
    random = np.random.default_rng(1)
    gains = 1 + 0.005 * random.normal(size=lengths.shape)
    read = lengths * gains + 3.14e-5 * random.normal(size=lengths.shape)
    counts = np.rint(read / step).astype(np.int64)
    for j, row in enumerate(fit.without):
        absent = np.zeros(counts.shape, bool)
        absent[:, j] = True
        axis, rows = ("u", slice(0, 12)) if j < 8 else ("v", slice(12, 24))
        values = fit.guarded.estimate(counts, absent)[:, rows]
        radians = fit.guarded.model.axis(axis).radians(values)
        error = np.degrees(np.sqrt(np.mean(np.square(radians - getattr(shapes, axis)))))
        assert error == pytest.approx(row.rms_deg[axis], rel=0.1)


def test_a_fault_is_left_out_after_three_snapshots_and_comes_back_after_twenty(fit):
    isolable = [j for j, row in enumerate(fit.checks.sensors[:8]) if row.isolable]
    j = isolable[0]
    row = fit.checks.sensors[j]
    offset = round(4 * row.detectable_m / 2e-6)
    counts = np.zeros((60, 16), np.int64)
    counts[10:20, j] = offset
    found = fit.guarded.follow(counts)
    suspected = np.flatnonzero(found.suspected[:, j])
    assert suspected.tolist() == list(range(10, 20 + BACK_AFTER - 1))
    assert not np.delete(found.suspected, j, axis=1).any()
    absent = np.zeros(counts.shape, bool)
    absent[10 + OUT_AFTER - 1 : 20 + BACK_AFTER - 1, j] = True
    assert np.array_equal(found.values, fit.guarded.estimate(counts, absent))
    assert found.states[:, 0].tolist() == [DEGRADED if 10 <= k < 39 else GOOD for k in range(60)]
    assert (found.states[:, 1] == GOOD).all()


def test_snapshots_may_be_followed_in_parts(fit, counts):
    faulty = counts.copy()
    faulty[20:60, 2] += 4000
    faulty[70:75, 5] = NONE
    whole, watches, parts = fit.guarded.follow(faulty), None, []
    for part in np.split(faulty, [7, 22, 23, 71]):
        found = fit.guarded.follow(part, watches=watches)
        watches = found.watches
        parts.append(found)
    for name in ("values", "suspected", "states"):
        assert np.array_equal(
            np.concatenate([getattr(part, name) for part in parts]), getattr(whole, name)
        )
    assert watches == whole.watches


def test_without_fallbacks_a_lost_sensor_loses_its_axis():
    fit = ccgen.fit(ccgen.parse(joint_text(tables="[estimator]\nfallback = false")))
    lost = np.zeros((1, 6), np.int64)
    lost[0, 0] = NONE
    found = fit.guarded.follow(lost)
    assert found.states.tolist() == [[LOST, GOOD]]
    assert fit.guarded.flash_bytes == 0
    assert np.array_equal(fit.guarded.model.u.weights, fit.plain.u.weights)


def test_flash_of_the_fallbacks_is_that_of_their_rows():
    assert ccgen.fit(ccgen.parse(joint_text())).guarded.flash_bytes == 2 * 3 * 12 * 4 * 2


def test_fallbacks_and_checks_survive_json(fit):
    record = json.loads(json.dumps(guard_record(fit.guarded)))
    read = guarded_model(fit.guarded.model, record)
    assert guard_record(read) == guard_record(fit.guarded)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda r: r["fallbacks"]["u"]["rows"].pop(), "7 fallbacks of 8"),
        (lambda r: r["fallbacks"]["u"]["rows"][0][0].__setitem__(0, 1), "of another shape"),
        (lambda r: r["fallbacks"]["v"]["rows"][1][0].__setitem__(0, 2**15), "does not fit"),
        (lambda r: r["checks"][0]["threshold"].__setitem__(0, -1), "does not fit the precision"),
        (lambda r: r["checks"][0].__setitem__("first", 3), "check of sensors 3"),
        (lambda r: r["checks"][1]["weights"].pop(), "check of sensors 8"),
        (lambda r: r["checks"][1].__setitem__("kept", 0), "check of sensors 8"),
        (lambda r: r["checks"][0]["threshold"].__setitem__(0, 0), "may pass unseen"),
        (lambda r: r["checks"][0]["directions"][0].__setitem__(0, 2**15), "not fit the precision"),
        (lambda r: r["checks"][0].__setitem__("quiet_bits", 31), "not fit the precision"),
        (lambda r: r["checks"][0].update(weights=[[2**15 - 1] * 8] * 8), "a sum may overflow"),
    ],
)
def test_a_damaged_record_is_refused(fit, damage, message):
    record = json.loads(json.dumps(guard_record(fit.guarded)))
    damage(record)
    with pytest.raises(ValueError, match=message):
        guarded_model(fit.guarded.model, record)
