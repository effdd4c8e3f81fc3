"""Exported C while sensors fail: fallbacks, checks over time and states, against the model."""

from functools import cache

import numpy as np
import pytest
from test_joint_checks import counted, loaded, read_by

import ccgen
from ccgen.can.exchange import Pace, exchange
from ccgen.can.layout import AXIS_STATES
from ccgen.can.transports.library import library_node
from ccgen.export.package import export
from ccgen.fixedpoint.guarded import DEGRADED, GOOD, LOST
from ccgen.fixedpoint.watch import BACK_AFTER, OUT_AFTER
from ccgen.targets.exported import open_exported
from ccgen.targets.host import compile_shared
from ccgen.targets.library import JointLibrary

NONE = {16: -(2**15), 32: -(2**31)}


def text_of(precision, count, **estimator):
    """A joint whose sensors are checked where they are enough, without tolerances of gains."""
    keys = "\n".join(f"{key} = {str(value).lower()}" for key, value in estimator.items())
    text = loaded("false_alarms = 1e-4\n" + keys)
    lines = [line for line in text.splitlines() if not line.startswith("gain_tolerance")]
    text = "\n".join(lines).replace("count = 8", f"count = {count}")
    return text.replace("precision = 16", f"precision = {precision}")


@cache
def built(precision, count, fallback=True, check=True):
    """The fit, the exported folder and the library of a joint."""
    fit = ccgen.fit(ccgen.parse(text_of(precision, count, fallback=fallback, check=check)))
    root = _FOLDERS.mktemp("guarded")
    exported = open_exported(export(fit, root / "joint").directory)
    library = compile_shared(exported.directory, root)
    return fit, exported, library


_FOLDERS: pytest.TempPathFactory


@pytest.fixture(autouse=True, scope="module")
def folders(tmp_path_factory):
    global _FOLDERS
    _FOLDERS = tmp_path_factory


def estimated(built_joint, counts):
    """What the library gives for snapshots one after the other, and the model's."""
    _, exported, library = built_joint
    guarded = exported.guarded
    found = JointLibrary(library, exported.model).estimate(counts, guarded.model.readings.zero)
    return found, guarded.follow(counts)


def assert_equal(found, followed, axes=("u", "v")):
    values, results = found
    assert np.array_equal(values, followed.values)
    assert np.array_equal(results, followed.mask(axes))


@pytest.mark.parametrize(("precision", "count"), [(16, 3), (16, 8), (32, 5)])
def test_every_single_and_double_loss_gives_the_models_bits(precision, count):
    joint = built(precision, count, check=False)
    counts = counted(joint[0], read_by(joint[0], 40, seed=1))
    sensors = counts.shape[1]
    for j in range(sensors):
        lost = counts.copy()
        lost[:, j] = NONE[precision]
        lost[20:, (j + 1) % sensors] = NONE[precision]
        found, followed = estimated(joint, lost)
        assert_equal(found, followed)
        own = j // count
        assert (followed.states[:20, own] == DEGRADED).all()
        assert (followed.states[:, 1 - own] == GOOD).all() or (j + 1) % count == 0


def test_without_fallbacks_an_axis_is_lost_with_its_first_sensor_and_the_other_goes_on():
    joint = built(16, 3, fallback=False, check=False)
    counts = counted(joint[0], read_by(joint[0], 10, seed=1))
    counts[:, 1] = NONE[16]
    found, followed = estimated(joint, counts)
    assert_equal(found, followed)
    assert (followed.states == [LOST, GOOD]).all()
    source = (joint[1].directory / "src" / "shoulder.c").read_text(encoding="utf-8")
    assert "_without[" not in source
    assert "_check_rows" not in source


@pytest.mark.parametrize(("precision", "count"), [(16, 8), (32, 8)])
@pytest.mark.parametrize("sensor", [1, 9])
@pytest.mark.parametrize("metres", [0.002, -0.006])
def test_a_sensor_that_slips_is_left_out_and_comes_back_as_in_the_model(
    precision, count, sensor, metres
):
    joint = built(precision, count)
    fit, exported, _ = joint
    assert exported.guarded.groups
    counts = counted(fit, read_by(fit, 120, seed=5))
    counts[30:70, sensor] += round(metres / fit.joint.sensors[sensor].metres_per_count)
    assert not exported.guarded.missing(counts).any()
    counts[100:104, 2] = NONE[precision]
    found, followed = estimated(joint, counts)
    assert_equal(found, followed)
    assert followed.suspected[30 + OUT_AFTER : 70, sensor].all()
    assert (followed.states[70 + BACK_AFTER : 100] == GOOD).mean() > 0.9


def test_a_slip_that_leaves_the_range_now_and_then_degrades_its_axis_all_the_same():
    fit, exported, _ = joint = built(16, 8)
    counts = counted(fit, read_by(fit, 120, seed=5))
    counts[30:70, 9] += round(0.006 / fit.joint.sensors[9].metres_per_count)
    missing = exported.guarded.missing(counts)[30:70, 9]
    assert 0 < missing.sum() < 10
    found, followed = estimated(joint, counts)
    assert_equal(found, followed)
    assert (followed.states[30:70, 1] == DEGRADED).all()
    assert followed.suspected[30:70, 9][~missing].mean() > 0.9


@pytest.mark.parametrize("seed", range(4))
def test_random_counts_and_losses_give_the_models_bits_over_a_long_time(seed):
    joint = built(16, 8)
    readings = joint[1].model.readings
    random = np.random.default_rng(seed)
    sound = counted(joint[0], read_by(joint[0], 2000, seed=seed))
    wild = random.integers(readings.minimum, readings.maximum + 1, sound.shape)
    counts = np.where(random.random(sound.shape) < 0.01, wild, sound)
    counts[random.random(sound.shape) < 0.01] = NONE[16]
    found, followed = estimated(joint, counts)
    assert_equal(found, followed)
    assert len(np.unique(followed.states)) == 3


def test_a_node_tells_what_is_suspected_degraded_and_lost():
    fit, exported, library = built(16, 8)
    counts = counted(fit, read_by(fit, 60, seed=5))
    counts[20:, 3] += round(0.006 / fit.joint.sensors[3].metres_per_count)
    counts[40:, 8:10] = NONE[16]
    with library_node(library, exported.layout) as bus:
        answers = exchange(bus, exported.codec, counts, Pace(in_flight=1))
    followed = exported.guarded.follow(counts)
    assert answers.complete.all()
    assert np.array_equal(answers.angles, followed.values)
    last = answers.healths[-1]
    assert last.suspected_sensors == 1 << 3
    assert (AXIS_STATES[last.axis_u], AXIS_STATES[last.axis_v]) == ("degraded", "lost")
    assert answers.statuses[-1].missing_sensors == 0x300
    lost = (followed.states == LOST).any(axis=1)
    assert (answers.tips[lost] == NONE[16]).all()
    assert (answers.tips[~lost] != NONE[16]).any(axis=1).all()
