"""References of recordings with bodies and markers, against joints that are known."""

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.errors import InputError
from ccgen.joint.file import parse_joint
from ccgen.kinematics.rotations import exponential
from ccgen.kinematics.stations import places, seen_from_base
from ccgen.recordings.fine import fine
from ccgen.recordings.reading import read_recordings
from ccgen.recordings.references import references
from ccgen.sensing.readings import response

M, LENGTH, STEP = 8, 0.24, 2.0e-5
GAIN = np.array([1.01, 0.98, 1.015, 0.99, 1.0, 1.02])
ZERO = 1e-3 * np.array([0.4, -0.3, 0.8, 0.0, 0.5, -0.6])
NAMES = ("u0", "u1", "u2", "v0", "v1", "v2")
RATE = 0.05
STATIONS = {"m0": 0.07, "m1": 0.12, "m2": 0.18, "tip": 0.24}
STATED = ", ".join(f"{name} = {at}" for name, at in STATIONS.items())
KEYS = f"stations = {{ {STATED} }}\nposition_noise = 2e-4\n"
STRAIGHT = "straight = [0.0, 1.9]\n"


def joint(*recordings, folder):
    tables = "".join(f'[[recordings]]\nfile = "{name}"\n{keys}\n' for name, keys in recordings)
    text = joint_text(
        "finger", segments=M, count=3, range_of_motion=10.0, step=STEP, radius=0.03, tables=tables
    )
    return parse_joint(text, "finger.toml", folder)


def bends(t):
    """Smooth bends of a joint with a stiff base, straight in the first two seconds."""
    swing = np.clip(t - 2.0, 0.0, None)[:, None]
    place = (np.arange(M) + 0.5) / M
    soft = np.where(np.arange(M) == 0, 0.5, 1.0)
    u = 6.0 * np.sin(0.9 * swing) * (1 - 0.4 * place) + 3.0 * np.sin(1.7 * swing) * place
    v = 5.0 * np.sin(0.6 * swing) * (0.6 + 0.4 * place) - 3.0 * np.sin(2.3 * swing) * (1 - place)
    return np.radians(np.concatenate([u * soft, v * soft], axis=1))


def written(folder, name="run.csv", rows=500, seed=0, noise=2e-4, counts=True, turn=None,
            delay=0.0, twist=0.0, change=None):  # fmt: skip
    """Write a recording of which everything is known, bodies turned by a constant rotation."""
    random = np.random.default_rng(seed)
    t = np.arange(rows) * RATE
    turned = twist * np.sin(0.7 * np.clip(t - 2.0, 0.0, None))
    state = np.concatenate([bends(t), np.zeros((rows, 1)), turned[:, None]], axis=1)
    columns = {"t": t}
    if counts:
        H = response(joint(folder=folder))[:, : 2 * M]
        lengths = GAIN * (bends(t - delay) @ H.T) + ZERO
        lengths += 5e-5 * random.standard_normal(lengths.shape)
        columns |= {f"count_{n}": c for n, c in zip(NAMES, np.rint(lengths / STEP).T, strict=True)}
    seen = seen_from_base(state, places(list(STATIONS.values()), (M,), LENGTH / M))
    away = np.zeros(3) if turn is None else np.array([0.3, 0.1, -0.2])
    turn = np.eye(3) if turn is None else turn
    for b, body in enumerate(STATIONS):
        place = seen.position[:, b] @ turn.T + away
        place = place + noise * random.standard_normal(place.shape)
        columns |= {f"{body}_{axis}": place[:, k] for k, axis in enumerate("xyz")}
    if change is not None:
        change(columns)
    table = np.stack(list(columns.values()), axis=1)
    lines = [",".join("" if np.isnan(x) else repr(float(x)) for x in row) for row in table]
    (folder / name).write_text("\n".join([",".join(columns), *lines]) + "\n")
    return state[:, :-1]


def made(folder, *recordings, **options):
    parsed = joint(*(recordings or [("run.csv", KEYS + STRAIGHT)]), folder=folder)
    return references(parsed, read_recordings(parsed), **options)


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """True states of a recording, and its reference."""
    folder = tmp_path_factory.mktemp("usual")
    return written(folder), made(folder)[0]


def apart(one, other):
    """Root mean square of what angles differ by, degrees."""
    return float(np.degrees(np.sqrt(np.nanmean(np.square(one - other)))))


def test_bodies_and_counts_tell_the_shape_and_the_sensors(usual):
    state, it = usual
    assert (it.name, it.use, it.dense) == ("recording:run.csv", "fit", False)
    assert it.state.shape == state.shape
    assert apart(it.state, state) < 0.2
    assert apart(0 * state, state) > 2.5
    assert (np.abs(it.gain - GAIN) < 3 * it.gain_std).all()
    assert (np.abs(it.zero - ZERO) < 3 * it.zero_std + 1e-5).all()
    assert it.gain_std.max() < 0.02
    assert it.zero_std.max() < 5e-5
    spread = np.sqrt(np.diagonal(it.covariance, axis1=1, axis2=2))
    off = np.abs(it.state - state)[:, : 2 * M] / spread[:, : 2 * M]
    assert 0.2 < np.median(off) < 3
    told = np.degrees(np.sqrt(np.mean(np.square(spread[:, : 2 * M]))))
    true = apart(it.state[:, : 2 * M], state[:, : 2 * M])
    assert 0.65 * true < told < 2 * true
    second = state.T @ state / len(state)
    assert np.trace(it.second_moment) == pytest.approx(np.trace(second), rel=0.1)


def test_a_frame_that_is_turned_and_moved_comes_from_the_straight_stretch(tmp_path):
    turn = exponential(np.radians([0.0, 90.0, 0.0])) @ exponential(np.radians([4.0, -3.0, 0.0]))
    state = written(tmp_path, counts=False, turn=turn)
    (it,) = made(tmp_path)
    place = it.sighting.frame
    assert it.lengths is it.gain is None
    # The joint's z is along the recording's x there, and its x along the recording's y.
    u, v = it.state[:, :M].sum(axis=1), it.state[:, M : 2 * M].sum(axis=1)
    true = state[:, :M].sum(axis=1), state[:, M : 2 * M].sum(axis=1)
    size = np.hypot(*true)
    assert np.abs(np.hypot(u, v) - size)[size > 0.1].max() < np.radians(4)
    assert np.linalg.norm(place.offset, axis=1).max() < 2e-4


def test_a_frame_without_a_straight_stretch_is_found_from_all_rows(tmp_path):
    turn = exponential(np.radians([3.0, -2.0, 0.0]))
    state = written(tmp_path, turn=turn, rows=400)
    (it,) = made(tmp_path, ("run.csv", KEYS))
    assert apart(it.state, state) < 0.6


def test_a_body_base_that_shows_its_axes_is_at_the_base_unless_stated(tmp_path):
    turn = exponential(np.radians([0.0, 90.0, 0.0]))

    def add(columns):
        fixed = np.array([0.3, 0.1, -0.2, 0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)])
        rows = np.broadcast_to(fixed, (len(columns["t"]), 7))
        parts = ("x", "y", "z", "qx", "qy", "qz", "qw")
        columns |= {f"base_{part}": rows[:, k] for k, part in enumerate(parts)}

    state = written(tmp_path, rows=240, turn=turn, change=add)
    silent, stated = KEYS, KEYS.replace("{", "{ base = 0.0,", 1)
    one, other = (made(tmp_path, ("run.csv", keys))[0] for keys in (silent, stated))
    np.testing.assert_array_equal(one.state, other.state)
    assert apart(one.state, state) < 1.0


def test_occluded_markers_and_outliers_do_little_and_are_counted(tmp_path):
    def spoil(columns):
        for axis in "xyz":
            columns[f"m1_{axis}"][100:160] = np.nan
        columns["m2_y"][200:220] += 0.05

    state = written(tmp_path, change=spoil)
    (it,) = made(tmp_path)
    assert apart(it.state, state) < 0.4
    assert f"{tmp_path / 'run.csv'}: m1 is out of sight in 60 of 500 rows" in it.notes
    assert f"{tmp_path / 'run.csv'}: m2 is far off and counts little in 20 rows" in it.notes


def test_rows_of_a_camera_that_is_slower_than_the_log_are_those_before(tmp_path):
    def slow(columns):
        for name in columns:
            if name.startswith(("m", "tip")):
                columns[name] = columns[name][np.arange(len(columns["t"])) // 3 * 3]

    state = written(tmp_path, change=slow, rows=300)
    it = made(tmp_path)[0]
    moved = it.sighting.sights.moved
    assert moved[:7].tolist() == [True, False, False, True, False, False, True]
    gather = fine(joint(folder=tmp_path).geometry, False).gather
    alone = it.sighting.alone[:, :-1] @ gather.T
    assert apart(alone, state[np.arange(300) // 3 * 3]) < 1.0
    assert (it.sighting.alone[1::3] == it.sighting.alone[::3]).all()
    assert not (it.sighting.alone[3::3] == it.sighting.alone[:-3:3]).all(axis=1).any()


def test_a_delay_between_bodies_and_sensors_is_found(tmp_path):
    state = written(tmp_path, delay=0.12)
    (it,) = made(tmp_path)
    assert it.delay_s == pytest.approx(0.12, abs=0.02)
    assert apart(it.state, state) < 0.4


def test_errors_at_stations_are_those_of_the_estimate(usual):
    state, it = usual
    right = it.stations(state)
    assert list(right) == list(STATIONS)
    assert right["tip"].position_rms_m < 2e-4
    assert right["tip"].arc_length_rms_m < 1e-6
    assert max(right["m1"].bend_rms_deg.values()) < 0.7
    wrong = state.copy()
    wrong[:, 0] += np.radians(2.0)
    off = it.stations(wrong)
    assert off["m0"].bend_rms_deg["u"] == pytest.approx(2.0, abs=0.4)
    assert off["m1"].bend_rms_deg["u"] < 0.8
    assert off["tip"].position_rms_m == pytest.approx(np.radians(2) * 0.21, rel=0.15)
    wrong[:] = np.nan
    assert np.isnan(it.stations(wrong)["tip"].position_rms_m)


def test_a_joint_that_twists_has_its_tip_where_the_camera_sees_it(tmp_path):
    state = written(tmp_path, twist=0.2)
    (it,) = made(tmp_path)
    turned = 0.2 * np.sin(0.7 * np.clip(it.t - 2.0, 0.0, None))
    end = places([LENGTH], (M,), LENGTH / M)
    true, straight = (
        seen_from_base(np.column_stack([state, twist]), end).position[:, 0]
        for twist in (turned, 0 * turned)
    )
    place, spread = it.sighting.tips
    off = np.linalg.norm(place - true, axis=1)
    assert np.sqrt(np.mean(off**2)) < 3e-4
    assert np.sqrt(np.mean(np.sum((straight - true) ** 2, axis=1))) > 2e-3
    assert 0.4 < np.sqrt(np.mean(off**2) / np.mean(spread**2)) < 2.0
    right = it.stations(state)
    assert right["tip"].position_rms_m == pytest.approx(
        np.sqrt(np.mean(np.sum((straight - true) ** 2, axis=1))), rel=0.1
    )
    # Sensors twist with the joint: bends between stations are right all the same.
    assert max(max(one.bend_rms_deg.values()) for one in right.values()) < 0.7


def test_a_block_that_is_held_out_teaches_nothing_and_still_has_its_states(tmp_path):
    def spoil(columns):
        columns["count_u1"][300:400] += 100

    state = written(tmp_path, change=spoil)
    (it,) = made(tmp_path, without_block=3)
    assert np.abs(it.zero - ZERO).max() < 1e-4
    assert np.isfinite(it.state).all()
    assert np.isfinite(it.lengths[300:400, 0]).all()
    assert apart(it.state[400:], state[400:]) < 0.4


def test_without_a_block_sensors_are_learned_anew_in_the_frame_of_the_whole(tmp_path, monkeypatch):
    def spoil(columns):
        columns["count_u1"][300:400] += 100

    written(tmp_path)
    whole = made(tmp_path, ("run.csv", KEYS))
    monkeypatch.setattr("ccgen.recordings.bodies.sighted", None)  # a frame is not sought again
    (it,) = made(tmp_path, ("run.csv", KEYS), without_block=3, whole=whole)
    written(tmp_path, change=spoil)
    (spoilt,) = made(tmp_path, ("run.csv", KEYS), without_block=3, whole=whole)
    for name in ("gain", "zero", "noise", "delay_s", "state"):
        np.testing.assert_array_equal(getattr(spoilt, name), getattr(it, name))
    assert (it.gain != whole[0].gain).any()
    assert np.isnan(it.state[300:400]).all()


def test_a_recording_to_score_with_takes_what_was_learned(tmp_path):
    state = written(tmp_path)
    written(tmp_path, "other.csv", seed=4)
    fitted, scored = made(
        tmp_path, ("run.csv", KEYS + STRAIGHT), ("other.csv", KEYS + 'use = "score"\n')
    )
    np.testing.assert_array_equal(scored.gain, fitted.gain)
    np.testing.assert_array_equal(scored.second_moment, fitted.second_moment)
    assert apart(scored.state, state) < 0.5


def test_counts_alone_tell_the_zeros_of_a_straight_joint(tmp_path):
    def drop(columns):
        for name in list(columns):
            if name[:1] in "mt" and name != "t":
                del columns[name]

    written(tmp_path, "still.csv", change=drop)
    (it,) = made(tmp_path, ("still.csv", STRAIGHT))
    np.testing.assert_allclose(it.zero, ZERO, atol=4e-5)
    assert np.isnan(it.state[100:]).all()
    with pytest.raises(InputError, match="tells nothing of the joint's shape"):
        made(tmp_path, ("still.csv", ""))


def test_a_straight_stretch_in_which_bodies_move_is_refused(tmp_path):
    written(tmp_path)
    with pytest.raises(InputError, match=r"straight = \[0, 4\]: the joint moves by .* m in that"):
        made(tmp_path, ("run.csv", KEYS + "straight = [0.0, 4.0]\n"))
