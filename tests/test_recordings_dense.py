"""References of recordings that hold segment angles, against sensors and shapes that are known."""

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.errors import InputError
from ccgen.joint.file import parse_joint
from ccgen.recordings.reading import read_recordings
from ccgen.recordings.references import references
from ccgen.sensing.readings import response

M = 6
STEP = 2.0e-5
GAIN = np.array([1.02, 0.97, 1.01, 0.98])
ZERO = 1e-3 * np.array([0.4, -0.3, 1.2, 0.0])
RATE = 0.02


def joint(*recordings, folder):
    tables = "".join(f'[[recordings]]\nfile = "{name}"\n{keys}\n' for name, keys in recordings)
    text = joint_text(
        "finger", segments=M, count=2, range_of_motion=8.0, step=STEP, radius=0.03, tables=tables
    )
    return parse_joint(text, "finger.toml", folder)


def bends(t):
    """Smooth bends that vanish in the first second, shape (N, 2 M), radians."""
    swing = np.clip(t - 1.0, 0.0, None)[:, None]
    place = np.arange(M) / M
    u = 5.0 * np.sin(1.3 * swing) * (1 - 0.5 * place) + 2.0 * np.sin(2.9 * swing) * place
    v = 4.0 * np.sin(0.9 * swing) * (0.4 + place) - 2.0 * np.sin(3.7 * swing)
    return np.radians(np.concatenate([u, v], axis=1))


def written(folder, name="run.csv", delay=0.0, noise=3e-5, rows=1000, seed=0, change=None):
    """Write a recording of which everything is known; `change` may spoil its columns."""
    t = np.arange(rows) * RATE
    state = bends(t)
    H = response(joint(folder=folder))[:, : 2 * M]
    random = np.random.default_rng(seed)
    lengths = GAIN * (bends(t - delay) @ H.T) + ZERO + noise * random.standard_normal((rows, 4))
    columns = {"t": t}
    names = ("count_u0", "count_u1", "count_v0", "count_v1")
    columns |= dict(zip(names, np.rint(lengths / STEP).T, strict=True))
    angles = np.degrees(state).T
    columns |= {f"{axis}{i}": angles[k * M + i] for k, axis in enumerate("uv") for i in range(M)}
    if change is not None:
        change(columns)
    table = np.stack(list(columns.values()), axis=1)
    lines = [",".join("" if np.isnan(x) else repr(float(x)) for x in row) for row in table]
    (folder / name).write_text("\n".join([",".join(columns), *lines]) + "\n")
    return state


def made(folder, *recordings, **options):
    parsed = joint(*(recordings or [("run.csv", "")]), folder=folder)
    return references(parsed, read_recordings(parsed), **options)


def test_angles_are_the_states_and_sensors_are_found(tmp_path):
    state = written(tmp_path)
    (it,) = made(tmp_path)
    assert (it.name, it.use, it.dense, it.covariance) == ("recording:run.csv", "fit", True, None)
    np.testing.assert_allclose(it.state[:, :-1], state, atol=1e-12)
    assert not it.state[:, -1].any()
    np.testing.assert_allclose(it.second_moment, it.state.T @ it.state / len(it.state))
    np.testing.assert_allclose(it.gain, GAIN, atol=4 * it.gain_std.max())
    np.testing.assert_allclose(it.zero, ZERO, atol=4 * it.zero_std.max())
    assert it.gain_std.max() < 0.01
    assert it.zero_std.max() < 3e-5
    np.testing.assert_allclose(it.noise, 3e-5, rtol=0.2)


@pytest.mark.parametrize("delay", [0.13, -0.047, 0.0])
def test_a_delay_is_found_to_a_fraction_of_a_sample_and_removed(tmp_path, delay):
    state = written(tmp_path, delay=delay)
    (it,) = made(tmp_path)
    assert it.delay_s == pytest.approx(delay, abs=max(4 * it.delay_std_s, 1e-3))
    assert it.delay_std_s < 0.005
    H = response(joint(folder=tmp_path))[:, : 2 * M]
    np.testing.assert_allclose(
        it.lengths[100:-100], GAIN * (state @ H.T)[100:-100] + ZERO, atol=3e-4
    )


def test_a_delay_that_is_stated_is_used(tmp_path):
    written(tmp_path, delay=0.1)
    (it,) = made(tmp_path, ("run.csv", "delay = 0.1"))
    assert (it.delay_s, it.delay_std_s) == (0.1, 0.0)
    assert np.isnan(it.lengths[-5:]).all()


def test_counts_of_a_clock_of_their_own_are_laid_beside_the_reference(tmp_path):
    written(tmp_path, delay=0.06)
    whole = (tmp_path / "run.csv").read_text().splitlines()
    cells = [line.split(",") for line in whole]
    (tmp_path / "counts.csv").write_text(
        "\n".join(",".join(row[:5]) for row in cells[:1] + cells[8::3])
    )
    (tmp_path / "run.csv").write_text("\n".join(",".join(row[:1] + row[5:]) for row in cells))
    (it,) = made(tmp_path, ("run.csv", 'counts = "counts.csv"'))
    assert it.delay_s == pytest.approx(0.06, abs=5e-3)
    np.testing.assert_allclose(it.gain, GAIN, atol=0.01)
    assert np.isnan(it.lengths[:3]).all()
    assert np.isfinite(it.lengths[20:-20]).all()


@pytest.mark.parametrize("delay", [0.01, 0.014])
def test_noise_is_that_of_a_reading_though_readings_between_rows_are_means(tmp_path, delay):
    written(tmp_path, delay=delay, noise=1e-4)
    (it,) = made(tmp_path, ("run.csv", f"delay = {delay}"))
    whole = np.hypot(1e-4, STEP / np.sqrt(12))
    np.testing.assert_allclose(it.noise, whole, rtol=0.12)


def test_readings_that_stick_are_left_out_and_counted(tmp_path):
    def stick(columns):
        columns["count_v0"][300:380] = columns["count_v0"][300]
        columns["count_u1"][500] = np.nan

    written(tmp_path, change=stick)
    (it,) = made(tmp_path)
    assert np.isnan(it.lengths[301:379, 2]).all()
    assert np.isnan(it.lengths).sum() == 81
    assert it.notes == (f"{tmp_path / 'run.csv'}: sensor v0: 80 counts that stick are left out",)
    np.testing.assert_allclose(it.gain, GAIN, atol=0.01)


def test_a_block_that_is_held_out_teaches_nothing(tmp_path):
    def spoil(columns):
        for name in ("count_u0", "count_v1"):
            columns[name][400:600] = np.rint(1.3 * columns[name][400:600] + 40)

    written(tmp_path, change=spoil)
    (it,) = made(tmp_path, without_block=2)
    np.testing.assert_allclose(it.gain, GAIN, atol=0.005)
    np.testing.assert_array_equal(it.block, np.repeat(np.arange(5), 200))
    assert np.isfinite(it.lengths[400:600]).all()
    assert np.isfinite(it.state[400:600]).all()
    known = it.state[it.block != 2]
    np.testing.assert_allclose(it.second_moment, known.T @ known / len(known))


def test_a_recording_to_score_with_takes_gains_and_zeros_from_those_to_fit_to(tmp_path):
    written(tmp_path)
    written(tmp_path, "other.csv", seed=1, noise=2e-4)
    fitted, scored = made(tmp_path, ("run.csv", ""), ("other.csv", 'use = "score"'))
    np.testing.assert_array_equal(scored.gain, fitted.gain)
    np.testing.assert_allclose(scored.zero, fitted.zero)
    np.testing.assert_array_equal(scored.noise, fitted.noise)


@pytest.mark.parametrize("key", ["straight", "zero_from"])
def test_a_recording_to_score_with_has_the_zeros_of_its_own_stretch(tmp_path, key):
    def shift(columns):
        columns["count_u0"] += 50

    written(tmp_path)
    written(tmp_path, "other.csv", seed=1, change=shift)
    keys = f'use = "score"\n{key} = [0.0, {0.9 if key == "straight" else 12.0}]'
    fitted, scored = made(tmp_path, ("run.csv", ""), ("other.csv", keys))
    moved = scored.zero - fitted.zero
    assert moved[0] == pytest.approx(50 * STEP, abs=5e-5)
    np.testing.assert_allclose(moved[1:], 0.0, atol=5e-5)


def test_without_counts_nothing_is_said_of_sensors(tmp_path):
    def leave_out(columns):
        for name in list(columns):
            if name.startswith("count"):
                del columns[name]

    written(tmp_path, change=leave_out)
    (it,) = made(tmp_path)
    assert it.lengths is it.gain is it.zero is it.noise is None
    assert (it.delay_s, it.delay_std_s) == (0.0, 0.0)


def test_rows_without_angles_are_unknown_and_counted(tmp_path):
    def occlude(columns):
        columns["u2"][200:260] = np.nan

    written(tmp_path, change=occlude)
    (it,) = made(tmp_path)
    assert np.isnan(it.state[200:260, 2]).all()
    assert it.notes == (f"{tmp_path / 'run.csv'}: 60 of 1000 rows without a whole shape",)
    assert np.isfinite(it.second_moment).all()
    np.testing.assert_allclose(it.gain, GAIN, atol=0.005)


def test_a_straight_stretch_that_moves_is_refused(tmp_path):
    written(tmp_path)
    with pytest.raises(InputError, match=r"straight = \[0, 3\]: the joint moves by 7 degrees"):
        made(tmp_path, ("run.csv", "straight = [0.0, 3.0]"))
