"""Weights fitted to recordings, and errors on what was held out of them."""

import math

import numpy as np
import pytest
from joint_files import joint_text

import ccgen
from ccgen.errors import InputError
from ccgen.sensing.readings import length_changes, response
from ccgen.shapes import unstretched

ROWS, SEGMENTS = 200, 12
MODES = np.cos(np.outer(np.arange(4), np.pi * (np.arange(SEGMENTS) + 0.5) / SEGMENTS))
STEP = 2e-5


def bends(seed, rows=ROWS, size=1.5):
    """Segment angles that move slowly, shape (rows, SEGMENTS), degrees."""
    random = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, rows)
    phases = 2 * np.pi * (np.outer(random.uniform(3, 9, 4), t) + random.uniform(0, 1, (4, 1)))
    smooth = (np.sin(phases).T / (1 + np.arange(4))) @ MODES
    return size * smooth + 0.05 * random.standard_normal((rows, SEGMENTS))


def table(columns):
    names, values = zip(*columns.items(), strict=True)
    cells = [["" if np.isnan(x) else f"{x:.9g}" for x in row] for row in np.stack(values, axis=1)]
    return "\n".join(",".join(row) for row in [names, *cells]) + "\n"


def angle_columns(u, v):
    return {f"{axis}{i}": one[:, i] for axis, one in (("u", u), ("v", v)) for i in range(SEGMENTS)}


def recorded(folder, files, tables="", use="fit", transducer="noise = 1e-5", method="wam", **text):
    """A joint with recordings, each a dict of columns by name of the file."""
    for name, columns in files.items():
        (folder / name).write_text(table(columns))
    named = "".join(f'[[recordings]]\nfile = "{name}"\nuse = "{use}"\n' for name in files)
    tables = f'[estimator]\nmethod = "{method}"\n{tables}\n{named}'
    source = joint_text(transducer=transducer, tables=tables, step=STEP, **text)
    return ccgen.parse(source, folder=folder)


def row_of(fitted, name, noise=True):
    return next(r for r in fitted.errors if r.source == f"recording:{name}" and r.noise == noise)


def averaging(joint, axis):
    """Normalised readings of an axis by its angles."""
    own, rows = joint.own(axis), joint.rows(axis)
    sensors = joint.sensors[own]
    return response(joint)[own, rows] / np.array([[s.segments * s.radius] for s in sensors])


def test_weights_follow_the_recorded_shapes(tmp_path):
    u, v = bends(0), bends(1)
    joint = recorded(tmp_path, {"run.csv": angle_columns(u, v)})
    fitted = ccgen.fit(joint)
    for axis, angles in (("u", u), ("v", v)):
        x = np.radians(angles)
        read = x @ averaging(joint, axis).T
        plain = np.linalg.lstsq(read, x, rcond=None)[0].T
        np.testing.assert_allclose(fitted.weights[axis].matrix, plain, rtol=1e-2, atol=1e-2)


def test_every_block_is_judged_by_weights_that_do_not_know_it(tmp_path):
    u, v = bends(2), bends(3)
    joint = recorded(tmp_path, {"run.csv": angle_columns(u, v)})
    told = row_of(ccgen.fit(joint), "run.csv", noise=False)
    assert told.held_out
    for axis, angles in (("u", u), ("v", v)):
        x, block = np.radians(angles), 5 * np.arange(ROWS) // ROWS
        read = x @ averaging(joint, axis).T
        error = np.empty_like(x)
        for k in range(5):
            known = block != k
            weights = np.linalg.lstsq(read[known], x[known], rcond=None)[0]
            error[~known] = read[~known] @ weights - x[~known]
        rms = math.degrees(math.sqrt(np.square(error).mean()))
        assert told.rms_deg[axis] == pytest.approx(rms, rel=0.01)


def counted(joint, u, v, gain, zero, noise=0.0, seed=9):
    """Counts that sensors with these gains and zeros give, by column."""
    state = unstretched(np.radians(u), np.radians(v)).state
    lengths = length_changes(joint, state)
    lengths = lengths + noise * np.random.default_rng(seed).standard_normal(lengths.shape)
    counts = np.rint((gain * lengths + zero) / STEP)
    return {f"count_{s.name}": counts[:, j] for j, s in enumerate(joint.sensors)}


GAIN = np.array([1.02, 0.98, 1.01, 0.97, 1.03, 1.0])
ZERO = 1e-4 * np.array([3.0, -2.0, 1.0, 0.0, 4.0, -5.0])


@pytest.mark.parametrize("method", ["wam", "noise-aware"])
def test_gains_and_zeros_of_recorded_counts_go_into_the_estimate(tmp_path, method):
    u, v = bends(4, rows=600), bends(5, rows=600)
    bare = ccgen.parse(joint_text(step=STEP))
    columns = counted(bare, u, v, GAIN, ZERO, noise=2e-5)
    joint = recorded(
        tmp_path, {"run.csv": columns | angle_columns(u, v)}, method=method,
        transducer="gain_tolerance = 0.03",
    )  # fmt: skip
    fitted = ccgen.fit(joint)
    for sensor, stated, gain, zero in zip(fitted.sensors, joint.sensors, GAIN, ZERO, strict=True):
        assert stated.metres_per_count / sensor.metres_per_count == pytest.approx(gain, abs=3e-3)
        assert sensor.zero == pytest.approx(zero / STEP, abs=1.0)
        assert sensor.noise == pytest.approx(2e-5, rel=0.5)
    told = row_of(fitted, "run.csv")
    assert [r.noise for r in fitted.errors if r.source == "recording:run.csv"] == [True]
    found = fitted.estimate(np.stack(list(columns.values()), axis=1))
    for axis, angles in (("u", u), ("v", v)):
        error = np.degrees(getattr(found, axis)) - angles
        known = np.sqrt(np.square(error).mean())  # of weights that know the rows
        assert known < told.rms_deg[axis] < 1.4 * known


def test_readings_that_are_missing_cost_their_axis_alone(tmp_path):
    u, v = bends(4), bends(5)
    columns = counted(ccgen.parse(joint_text(step=STEP)), u, v, GAIN, ZERO)
    columns["count_u1"][50:90] = np.nan
    joint = recorded(tmp_path, {"run.csv": columns | angle_columns(u, v)})
    fitted = ccgen.fit(joint)
    assert row_of(fitted, "run.csv").rms_deg["u"] < 0.5
    found = fitted.recorded.judged(0, True)
    assert np.isnan(found.known("u")).all(axis=1).sum() == 40
    assert not np.isnan(found.known("v")).any()


def test_a_recording_to_score_with_is_not_fitted_to(tmp_path):
    u, v = bends(6), bends(7)
    joint = recorded(tmp_path, {"run.csv": angle_columns(u, v)}, use="score")
    fitted = ccgen.fit(joint)
    plain = ccgen.fit(ccgen.parse(joint_text(transducer="noise = 1e-5", step=STEP)), "wam")
    assert [source.name for source in fitted.task.sources] == ["cases"]
    for axis, angles in (("u", u), ("v", v)):
        np.testing.assert_array_equal(fitted.weights[axis].matrix, plain.weights[axis].matrix)
        x = np.radians(angles)
        error = x @ averaging(joint, axis).T @ plain.weights[axis].matrix.T - x
        told = row_of(fitted, "run.csv", noise=False)
        assert told.held_out
        assert told.rms_deg[axis] == pytest.approx(
            math.degrees(math.sqrt(np.square(error).mean())), rel=1e-9
        )


def test_recordings_count_as_a_whole_beside_loads(tmp_path):
    loads = "[loads]\nsamples = 30\nstiffness = 0.4\ntip_force = [0.0, 2.0]\n"
    files = {
        name: angle_columns(bends(i), bends(i + 9)) for i, name in enumerate(("a.csv", "b.csv"))
    }
    fitted = ccgen.fit(recorded(tmp_path, files, tables=loads))
    weight = {source.name: source.weight for source in fitted.task.sources}
    assert weight == {"loads": 0.05, "recording:a.csv": 0.5, "recording:b.csv": 0.5}
    assert fitted.stated.name == "recording:a.csv"


def test_formats_grow_with_recorded_shapes(tmp_path):
    far = recorded(tmp_path, {"run.csv": angle_columns(bends(0, size=4.0), bends(1, size=4.0))})
    fitted = ccgen.fit(far)
    reach = np.abs(fitted.shapes.state).max() / far.geometry.range_of_motion
    assert reach > 1.5
    assert (
        fitted.model.u.angle_limit * 2.0** -fitted.model.u.fraction_bits
        > 1.25 * reach * np.radians(3.0)
    )
    assert any("formats grow with them" in warning for warning in fitted.warnings)


def test_shapes_given_in_python_take_the_place_of_recordings(tmp_path):
    joint = recorded(tmp_path, {"run.csv": angle_columns(bends(0), bends(1))})
    given = np.radians(bends(8))
    fitted = ccgen.fit(joint, shapes=given)
    plain = ccgen.fit(
        ccgen.parse(joint_text(transducer="noise = 1e-5", step=STEP)), "wam", shapes=given
    )
    np.testing.assert_array_equal(fitted.weights["u"].matrix, plain.weights["u"].matrix)
    assert {row.source for row in fitted.errors} == {row.source for row in plain.errors}


def test_a_recording_of_one_axis_tells_nothing_of_the_other(tmp_path):
    columns = {
        name: one for name, one in angle_columns(bends(0), bends(1)).items() if name[0] == "u"
    }
    with pytest.raises(InputError, match=r"run\.csv: no row tells every segment of u and v"):
        ccgen.fit(recorded(tmp_path, {"run.csv": columns}))
    planar = recorded(tmp_path, {"run.csv": columns}, tables='axes = ["u"]')
    assert set(ccgen.fit(planar).weights) == {"u"}


def test_what_a_lost_sensor_leaves_is_told_of_blocks_that_were_held_out(tmp_path):
    u, v = bends(2), bends(3)
    fitted = ccgen.fit(recorded(tmp_path, {"run.csv": angle_columns(u, v)}))
    whole = row_of(fitted, "run.csv")
    lost = {row.sensor: row for row in fitted.without}
    assert lost["u1"].rms_deg["u"] > whole.rms_deg["u"]
    assert lost["u1"].rms_deg["v"] == pytest.approx(whole.rms_deg["v"])


def told(fitted, start):
    return [warning for warning in fitted.warnings if warning.startswith(start)]


def test_a_direction_that_no_source_moves_the_joint_in_is_said(tmp_path):
    alike = np.repeat(bends(3).mean(axis=1, keepdims=True), SEGMENTS, axis=1)
    fitted = ccgen.fit(recorded(tmp_path, {"run.csv": angle_columns(alike, bends(4))}))
    said = told(fitted, "axis u: recording:run.csv hardly bend")
    assert len(said) == 2
    assert "with its tip against its base" in said[0]
    assert not told(fitted, "axis v: recording:run.csv hardly bend")


def test_rows_that_are_too_few_for_the_sensors_are_said(tmp_path):
    t = np.linspace(-1.0, 1.0, ROWS)[:, None]
    slow = 1.5 * t * MODES[0] + 0.5 * t**2 * MODES[1] + 0.5 * t**3 * MODES[2]
    fitted = ccgen.fit(recorded(tmp_path, {"run.csv": angle_columns(slow, bends(4))}))
    assert told(fitted, "axis u: the 200 rows of recording:run.csv count as")
    assert not told(fitted, "axis v: the 200 rows of recording:run.csv count as")


def test_weights_fitted_to_the_cases_that_would_do_better_are_said(tmp_path):
    remedy = "the same fitted to the load cases by"
    cases = np.degrees(ccgen.fit(ccgen.parse(joint_text(count=2))).shapes.u)  # a case a block
    fitted = ccgen.fit(recorded(tmp_path, {"run.csv": angle_columns(cases, cases)}, count=2))
    assert any(remedy in warning for warning in told(fitted, "axis u: on recording:run.csv"))
    mixed = cases[np.random.default_rng(0).permutation(len(cases))]
    fitted = ccgen.fit(recorded(tmp_path, {"run.csv": angle_columns(mixed, mixed)}, count=2))
    assert not any(remedy in warning for warning in fitted.warnings)


@pytest.mark.parametrize("tables", ["", "[shapes]\nweight = { cases = 0.5 }"])
def test_counts_of_the_straight_joint_tell_zeros_and_no_shape(tmp_path, tables):
    u, v = bends(0), bends(1)
    run = {"run.csv": angle_columns(u, v)}
    names = [f"count_{axis}{j}" for axis in "uv" for j in range(3)]
    counts = {name: np.full(60, 7.0 + j) for j, name in enumerate(names)}
    (tmp_path / "rest.csv").write_text(table({"t": np.arange(60) / 50} | counts))
    rest = '[[recordings]]\nfile = "rest.csv"\nstraight = [0.0, 1.0]'
    alone = ccgen.fit(recorded(tmp_path, run, tables))
    both = ccgen.fit(recorded(tmp_path, run, f"{tables}\n{rest}"))
    for axis in "uv":
        np.testing.assert_array_equal(both.weights[axis].matrix, alone.weights[axis].matrix)
    assert [sensor.zero for sensor in both.sensors] == [7, 8, 9, 10, 11, 12]
    assert not [text for text in both.warnings if "too few" in text and "rest.csv" in text]


def test_the_straight_joint_alone_leaves_weights_to_the_cases(tmp_path):
    names = [f"count_{axis}{j}" for axis in "uv" for j in range(3)]
    (tmp_path / "rest.csv").write_text(
        table({"t": np.arange(60) / 50} | dict.fromkeys(names, np.full(60, 5.0)))
    )
    rest = '[[recordings]]\nfile = "rest.csv"\nstraight = [0.0, 1.0]'
    fitted = ccgen.fit(recorded(tmp_path, {}, rest))
    assert [sensor.zero for sensor in fitted.sensors] == [5] * 6
    assert {sensor.gain_tolerance for sensor in fitted.sensors} == {0.0}
    cases = ccgen.fit(recorded(tmp_path, {}))
    np.testing.assert_allclose(fitted.weights["u"].matrix, cases.weights["u"].matrix, atol=1e-6)
