"""What recordings and known poses tell of sensors, against joints of which everything is known."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import ccgen
from ccgen.calibration.bent import left_out
from ccgen.calibration.calibrate import calibrate
from ccgen.calibration.places import Place
from ccgen.calibration.seen import Seen
from ccgen.calibration.suspicious import suspicious
from ccgen.cli.main import main
from ccgen.errors import ArgumentError, InputError
from ccgen.joint.calibration import SensorCalibration
from ccgen.joint.calibration_file import calibration_text, parse_calibration
from ccgen.joint.file import parse_joint
from ccgen.kinematics import chain
from ccgen.sensing.readings import response

M = 6
STEP = 2.0e-5
NAMES = ("near_top", "far_top", "near_side", "far_side", "whole")
ANGLES = np.array([90.0, 90.0, 180.0, 180.0, 270.0])
GAIN = np.array([1.02, 0.97, 1.01, 0.985, 1.03])
ZERO = np.array([2061.3, 2020.0, 2033.6, 2048.0, 2095.2])
SPANS = ([0, 2], [2, 5], [0, 3], [3, 5], [0, 5])
RADIUS = 0.03

GEOMETRY = f"""\
name = "finger"
[geometry]
segments = {M}
length = 0.12
range_of_motion = 8.0
"""
RUN = ('file = "run.csv"',)


def text(*recordings, radius=RADIUS, angles=ANGLES, top="", elongation="", noise=""):
    """A joint file with recordings given by their keys."""
    sensors = "".join(
        f'[[sensor]]\nname = "{name}"\nspan = {span}\nangle = {angle}\nradius = {radius}\n'
        for name, span, angle in zip(NAMES, SPANS, angles, strict=True)
    )
    tables = "".join(f"[[recordings]]\n{keys}\n" for keys in recordings)
    transducer = (
        f"[sensors.transducer]\nbits = 12\nsigned = false\nmetres_per_count = {STEP}\n{noise}\n"
    )
    return f"{top}\n{GEOMETRY}{elongation}\n{sensors}{transducer}{tables}"


def bends(t, seed):
    """Smooth bends that vanish in the first second, shape (N, 2 M), radians."""
    random = np.random.default_rng(seed)
    swing = np.clip(t - 1.0, 0.0, None)[:, None] * random.uniform(0.9, 1.1)
    place = np.arange(M) / M
    u = 5.0 * np.sin(1.3 * swing) * (1 - 0.5 * place) + 2.0 * np.sin(2.9 * swing) * place
    v = 4.0 * np.sin(0.9 * swing) * (0.4 + place) - 2.0 * np.sin(3.7 * swing)
    return np.radians(np.concatenate([u, v], axis=1))


def lengths(state, noise, seed, gain=GAIN):
    """Counts of the true sensors at states, shape (N, 5)."""
    changes = state @ response(parse_joint(text(), "finger.toml")).T
    random = np.random.default_rng(seed)
    return ZERO + (gain * changes + noise * random.standard_normal(changes.shape)) / STEP


def write(file, columns):
    table = np.stack(list(columns.values()), axis=1)
    rows = [",".join("" if np.isnan(x) else repr(float(x)) for x in row) for row in table]
    file.write_text("\n".join([",".join(columns), *rows]) + "\n")


def record(
    folder, name="run.csv", rows=1000, noise=5e-5, seed=0, change=None, stretch=0.0, angles=True
):
    """Write a recording of the true sensors; `change` may spoil its columns."""
    t = np.arange(rows) * 0.02
    state = np.concatenate([bends(t, seed), np.zeros((rows, 1))], axis=1)
    state[:, -1] = stretch * np.square(np.sin(0.7 * t))
    columns = {"t": t} if rows >= 10 else {}
    if angles:
        shown = np.degrees(state[:, : 2 * M])
        columns |= {f"{a}{i}": shown[:, k * M + i] for k, a in enumerate("uv") for i in range(M)}
        if stretch:
            columns["elongation"] = state[:, -1]
    read = np.rint(lengths(state, noise, seed + 1))
    columns |= {f"count_{name}": read[:, j] for j, name in enumerate(NAMES)}
    if change is not None:
        change(columns)
    write(folder / name, columns)


def found_in(folder, *recordings, **keys):
    file = folder / "finger.toml"
    file.write_text(text(*(recordings or RUN), **keys))
    return calibrate(file)


def refusal(folder, *recordings, **keys):
    with pytest.raises(InputError) as error:
        found_in(folder, *recordings, **keys)
    assert "\n" not in str(error.value)
    return str(error.value).replace(f"{folder}/", "")


def values(found, key):
    return np.array([getattr(one, key) for one in found.calibration.sensors], dtype=float)


def test_gain_zero_noise_and_delay_are_found(tmp_path):
    def lagging(columns):
        for name in NAMES:
            columns[f"count_{name}"] = np.roll(columns[f"count_{name}"], 3)
            columns[f"count_{name}"][:3] = np.nan

    record(tmp_path, change=lagging)
    found = found_in(tmp_path)
    step_std = values(found, "metres_per_count_std")
    assert (np.abs(values(found, "metres_per_count") - STEP / GAIN) < 3 * step_std).all()
    assert (step_std < 0.005 * STEP).all()
    assert (np.abs(values(found, "zero") - ZERO) < 3 * values(found, "zero_std")).all()
    assert (values(found, "zero_std") < 1.0).all()
    noise = values(found, "noise") * GAIN
    np.testing.assert_allclose(noise, 5e-5, atol=4 * values(found, "noise_std").max() + 2e-6)
    assert found.calibration.delay == pytest.approx(0.06, abs=5e-3)
    assert found.suspicious == ()


@pytest.mark.parametrize("part", range(2))
def test_nine_in_ten_lie_within_two_deviations(tmp_path, part):
    off = []
    for seed in range(6 * part, 6 * part + 6):
        record(tmp_path, seed=10 * seed, rows=600)
        found = found_in(tmp_path)
        gain, zero = values(found, "metres_per_count"), values(found, "zero")
        off += [*(np.abs(gain - STEP / GAIN) / values(found, "metres_per_count_std"))]
        off += [*(np.abs(zero - ZERO) / values(found, "zero_std"))]
    assert np.mean(np.array(off) < 2) >= 0.9


def test_what_is_found_is_what_the_joint_is_read_with(tmp_path):
    record(tmp_path)
    found = found_in(tmp_path)
    found.write(tmp_path / "finger.calibration.toml")
    top = 'calibration = "finger.calibration.toml"'
    (tmp_path / "finger.toml").write_text(text(*RUN, top=top))
    joint = ccgen.load(tmp_path / "finger.toml")
    for sensor, one in zip(joint.sensors, found.calibration.sensors, strict=True):
        assert sensor.metres_per_count == pytest.approx(one.metres_per_count, rel=1e-11)
        assert sensor.zero == round(one.zero)
        assert sensor.noise == pytest.approx(one.noise, rel=1e-11)
    again = ccgen.calibrate(tmp_path / "finger.toml")
    assert calibration_text(again.calibration) == calibration_text(found.calibration)
    with pytest.raises(ArgumentError, match="joint: is calibrated already"):
        calibrate(joint)


def test_elongation_separates_gain_and_radius(tmp_path):
    record(tmp_path, stretch=0.05, rows=3000)
    found = found_in(
        tmp_path, radius=0.025, angles=ANGLES + 4.0, elongation="elongation = [0.0, 0.05]"
    )
    for place, angle in zip(found.places, ANGLES, strict=True):
        assert place.radius == pytest.approx(RADIUS, abs=4 * place.radius_std)
        assert place.radius_std < 0.02 * RADIUS
        assert np.degrees(place.angle) == pytest.approx(angle, abs=4 * np.degrees(place.angle_std))
        assert place.angle_std < np.radians(1.0)


def test_bending_alone_tells_the_angle_and_no_radius(tmp_path):
    record(tmp_path)
    places = found_in(tmp_path, angles=ANGLES + 5.0).places
    assert {place.radius for place in places} == {None}
    np.testing.assert_allclose(np.degrees([place.angle for place in places]), ANGLES, atol=1.0)


STRAIGHT = 'file = "straight.csv"\nstraight = [0.0, 1.0]'
POSES = 'file = "poses.csv"'


def test_the_straight_joint_tells_zeros_and_noise(tmp_path):
    record(tmp_path, "straight.csv", angles=False)
    found = found_in(tmp_path, STRAIGHT)
    assert {one.metres_per_count for one in found.calibration.sensors} == {None}
    assert (np.abs(values(found, "zero") - ZERO) < 3 * values(found, "zero_std")).all()
    assert (values(found, "zero_std") < 1.0).all()
    np.testing.assert_allclose(values(found, "noise"), 5e-5, rtol=0.35)
    assert found.calibration.delay is None


def poses(folder, angles, noise=2e-5, seed=0):
    state = np.array([[*[u] * M, *[v] * M, 0.0] for u, v in angles])
    columns = {f"{a}{i}": state[:, k * M + i] for k, a in enumerate("uv") for i in range(M)}
    read = np.rint(lengths(np.radians(state), noise, seed))
    write(
        folder / "poses.csv",
        columns | {f"count_{name}": read[:, j] for j, name in enumerate(NAMES)},
    )


@pytest.mark.parametrize("read", [calibrate, lambda file: ccgen.fit(ccgen.load(file))])
def test_a_sensor_that_moves_while_the_joint_is_called_straight_is_refused(tmp_path, read):
    record(tmp_path)
    record(tmp_path, "straight.csv", angles=False)
    moving = STRAIGHT.replace("[0.0, 1.0]", "[0.0, 4.0]")
    file = tmp_path / "finger.toml"
    file.write_text(text(*RUN, moving))
    with pytest.raises(InputError) as error:
        read(file)
    assert re.fullmatch(
        r".*straight\.csv: straight = \[0, 4\]: sensor \w+ moves by 0\.0\d+ m in that time; "
        r"name a time in which the joint rests",
        str(error.value),
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "finger.toml", "run.csv", "straight.csv",
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_a_few_known_poses_tell_gains(tmp_path, seed):
    poses(tmp_path, [(0, 0), (8, 0), (-8, 0), (0, 8), (0, -8)], seed=seed)
    found = found_in(tmp_path, POSES, noise="noise = 2e-5")
    off = np.abs(values(found, "metres_per_count") - STEP / GAIN)
    assert (off < 3.5 * values(found, "metres_per_count_std")).all()
    assert (values(found, "metres_per_count_std") < 0.03 * STEP).all()
    assert (np.abs(values(found, "zero") - ZERO) < 3.5 * values(found, "zero_std")).all()


def test_one_pose_and_the_straight_joint_are_enough(tmp_path):
    record(tmp_path, "straight.csv", angles=False)
    poses(tmp_path, [(8, 8)])
    found = found_in(tmp_path, POSES, STRAIGHT)
    off = np.abs(values(found, "metres_per_count") - STEP / GAIN)
    assert (off < 3.5 * values(found, "metres_per_count_std")).all()
    assert "do not determine the gain of sensors near_top" in refusal(tmp_path, POSES)


def swap(first, second):
    def change(columns):
        a, b = f"count_{first}", f"count_{second}"
        columns[a], columns[b] = columns[b], columns[a]

    return change


def turn_round(columns):
    columns["count_far_side"] = 4096 - columns["count_far_side"]


def stand_still(columns):
    columns["count_far_top"][:] = 2000.0


def hold(columns):
    columns["count_far_top"][500:700] = columns["count_far_top"][500]


def slip(columns):
    columns["count_near_side"][600:] += 30


@pytest.mark.parametrize(
    ("change", "expected", "says"),
    [
        (
            swap("near_top", "near_side"),
            {"near_top": "swapped", "near_side": "swapped"},
            "near_top reads what near_side should; near_top and",
        ),
        (
            swap("near_top", "far_top"),
            {"near_top": "swapped", "far_top": "swapped"},
            "near_top reads what far_top should",
        ),
        (turn_round, {"far_side": "reversed"}, "far_side reads the other way round"),
        (stand_still, {"far_top": "stuck"}, "far_top stays within 0 counts while the joint"),
        (hold, {"far_top": "stuck"}, "far_top holds one count for 20 % of its readings"),
        (slip, {"near_side": "slipping"}, r"the zero of near_side steps by 0\.6 mm at 12 s of run"),
    ],
)
def test_sensors_that_do_not_read_their_place_are_named(tmp_path, change, expected, says):
    record(tmp_path, change=change)
    found = found_in(tmp_path)
    assert {one.name: one.kind for one in found.suspicious} == expected
    first = found.suspicious[0].text.replace(f"{tmp_path}/", "")
    assert re.match(says, first)
    kept = {one.name: one for one in found.calibration.sensors}
    for name, kind in expected.items():
        left_out = kind in ("swapped", "stuck")
        assert (kept[name].metres_per_count is None) == left_out
        assert (kept[name].zero is None) == (left_out or kind == "slipping")


def test_a_reversed_sensor_gets_its_sign(tmp_path):
    record(tmp_path, change=turn_round)
    sensor = found_in(tmp_path).calibration.sensors[3]
    assert sensor.metres_per_count == pytest.approx(-STEP / GAIN[3], rel=0.01)
    assert sensor.zero == pytest.approx(4096 - ZERO[3], abs=2.0)


def test_a_zero_that_differs_between_recordings_slipped(tmp_path):
    def later(columns):
        columns["count_whole"] += 25

    record(tmp_path)
    record(tmp_path, "later.csv", seed=3, change=later)
    found = found_in(tmp_path, *RUN, 'file = "later.csv"')
    assert [(one.name, one.kind) for one in found.suspicious] == [("whole", "slipping")]
    assert re.match(r"the zero of whole differs by 0\.\d+ mm between", found.suspicious[0].text)


def test_recordings_to_score_with_are_left_alone(tmp_path):
    record(tmp_path)
    record(tmp_path, "other.csv", change=turn_round)
    both = found_in(tmp_path, *RUN, 'file = "other.csv"\nuse = "score"')
    assert both.suspicious == ()
    assert [name for name, _ in both.calibration.recordings] == ["run.csv"]


STATIONS = (
    'file = "run.csv"\nstations = { m0 = 0.04, m1 = 0.08, m2 = 0.12 }\n'
    "straight = [0.0, 1.0]\nposition_noise = 1e-4"
)


def by_markers(columns):
    """Markers on the axis, with noise, in the place of the angles."""
    shown = [[columns.pop(f"{axis}{i}") for i in range(M)] for axis in "uv"]
    u, v = np.radians(shown).transpose(0, 2, 1)
    ends = chain(u, v, 0.12 / M)[:, 1::2, :3, 3]
    ends = ends + 1e-4 * np.random.default_rng(5).standard_normal(ends.shape)
    columns |= {f"m{k}_{axis}": ends[:, k, i] for k in range(3) for i, axis in enumerate("xyz")}


def test_markers_tell_gains_and_zeros(tmp_path):
    record(tmp_path, rows=240, noise=3e-5, change=by_markers)
    found = found_in(tmp_path, STATIONS)
    gain, zero = values(found, "metres_per_count"), values(found, "zero")
    off = [*(np.abs(gain - STEP / GAIN) / values(found, "metres_per_count_std"))]
    off += [*(np.abs(zero - ZERO) / values(found, "zero_std"))]
    assert np.mean(np.array(off) < 2) >= 0.9
    assert (values(found, "metres_per_count_std") < 0.03 * STEP).all()
    assert (values(found, "zero_std") * STEP < 5e-5).all()
    assert found.suspicious == ()
    for place, angle in zip(found.places, ANGLES, strict=True):
        assert np.degrees(place.angle) == pytest.approx(angle, abs=3 * np.degrees(place.angle_std))
        assert place.angle_std < np.radians(2.0)


def test_a_reading_is_taken_out_of_the_shapes_that_rest_on_it():
    joint = parse_joint(text(), "finger.toml")
    H, p, n = response(joint), 2 * M + 1, len(NAMES)
    random = np.random.default_rng(2)
    noise, gain, zero = np.full(n, 3e-3), GAIN, np.full(n, 1e-3)
    prior = np.linalg.inv(np.diag(np.full(p, 0.05**2)))
    read = zero + 2e-3 * random.standard_normal((4, n))

    def posterior(sensors):
        h = (gain[:, None] * H)[sensors]
        P = np.linalg.inv(prior + (h.T / noise[sensors] ** 2) @ h)
        return (read - zero)[:, sensors] / noise[sensors] ** 2 @ h @ P, P

    state, covariance = posterior(list(range(n)))
    one = SimpleNamespace(
        reference=SimpleNamespace(state=state, covariance=np.broadcast_to(covariance, (4, p, p))),
        gain=gain,
        noise=noise,
        misfit=lambda own: read - gain * (state @ H.T) - zero,
    )
    alone = left_out(joint, one)
    for j in range(n):
        rest = [i for i in range(n) if i != j]
        np.testing.assert_allclose(alone[j], posterior(rest)[0], atol=1e-9)


def test_faults_are_told_with_markers_too(tmp_path):
    def spoilt(columns):
        by_markers(columns)
        turn_round(columns)
        swap("near_top", "near_side")(columns)

    record(tmp_path, rows=240, noise=3e-5, change=spoilt)
    found = found_in(tmp_path, STATIONS)
    assert {one.name: one.kind for one in found.suspicious} == {
        "near_top": "swapped",
        "near_side": "swapped",
        "far_side": "reversed",
    }
    sensor = found.calibration.sensors[3]
    off = sensor.metres_per_count + STEP / GAIN[3]
    assert abs(off) < 3 * sensor.metres_per_count_std


def test_a_joint_that_rests_in_one_axis_is_refused_with_markers(tmp_path):
    def planar(columns):
        still_in_v(columns)
        by_markers(columns)

    record(tmp_path, rows=240, noise=3e-5, change=planar)
    assert "do not determine the gain of sensors near_side, far_side" in refusal(tmp_path, STATIONS)


def test_a_sensor_that_was_not_recorded_is_left_as_it_is_stated(tmp_path):
    def without(columns):
        del columns["count_whole"]

    record(tmp_path, change=without)
    found = found_in(tmp_path)
    *rest, last = found.calibration.sensors
    assert last == SensorCalibration("whole")
    assert all(one.metres_per_count is not None for one in rest)
    assert found.notes[-1].endswith(
        "no counts where the shape is known of sensor whole, left as the file states"
    )


def test_a_joint_that_bends_in_one_slanted_plane_tells_gains_and_no_angle(tmp_path):
    def in_a_plane(columns):
        bent = np.radians(np.stack([columns[f"u{i}"] for i in range(M)], axis=1))
        state = np.concatenate([bent, bent, np.zeros((len(bent), 1))], axis=1)
        columns |= {f"v{i}": columns[f"u{i}"] for i in range(M)}
        read = np.rint(lengths(state, 5e-5, seed=1))
        columns |= {f"count_{name}": read[:, j] for j, name in enumerate(NAMES)}

    record(tmp_path, change=in_a_plane)
    found = found_in(tmp_path)
    np.testing.assert_allclose(values(found, "metres_per_count"), STEP / GAIN, rtol=0.01)
    assert set(found.places) == {Place()}


def uncounted(columns):
    for name in NAMES:
        del columns[f"count_{name}"]


def still_in_v(columns):
    for i in range(M):
        columns[f"v{i}"][:] = 0.0
    for name in ("near_side", "far_side"):
        columns[f"count_{name}"][:] = 2048 + np.arange(len(columns["t"])) % 2


@pytest.mark.parametrize(
    ("recordings", "change", "says"),
    [
        ([], None, "finger.toml: recordings: none stands there, and calibrate needs counts"),
        (['file = "run.csv"\nuse = "score"'], None, 'finger.toml: recordings: none of use = "fit"'),
        (
            RUN,
            uncounted,
            "finger.toml: recordings: none has counts of the sensors; add columns such",
        ),
        (
            RUN,
            still_in_v,
            "finger.toml: recordings: they do not determine the gain of sensors near_side, far",
        ),
        (['file = "gone.csv"'], None, "gone.csv: no such file"),
    ],
)
def test_too_little_is_refused_in_one_line(tmp_path, recordings, change, says):
    record(tmp_path, change=change)
    file = tmp_path / "finger.toml"
    file.write_text(text(*recordings))
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError) as error:
        calibrate(file)
    assert str(error.value).replace(f"{tmp_path}/", "").startswith(says)
    assert "\n" not in str(error.value)
    assert sorted(tmp_path.iterdir()) == before


def test_counts_alone_need_the_time_of_the_straight_joint(tmp_path):
    record(tmp_path, "straight.csv", angles=False)
    assert refusal(tmp_path, 'file = "straight.csv"').startswith(
        "straight.csv: holds counts alone, and [[recordings]] does not say when the joint was "
        "straight; write straight = [0.0, 2.0] (seconds)"
    )


def run(*arguments):
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_the_command_writes_beside_the_joint_and_prints_the_line_to_add(tmp_path, capsys):
    record(tmp_path)
    file = tmp_path / "finger.toml"
    file.write_text(text(*RUN))
    before = file.read_bytes()
    assert run("calibrate", str(file), "--json") == 0
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert set(result) >= {"sensors", "delay_s", "suspicious"}
    assert [one["name"] for one in result["sensors"]] == list(NAMES)
    for key in ("metres_per_count", "zero", "noise_m"):
        assert all(one[key] is not None and one[f"{key}_std"] > 0 for one in result["sensors"])
    assert err.splitlines()[-2:] == [
        f"ccgen: wrote {tmp_path}/finger.calibration.toml",
        f"ccgen: {file} does not read it yet; add this line above its first table: "
        'calibration = "finger.calibration.toml"',
    ]
    written = parse_calibration((tmp_path / "finger.calibration.toml").read_bytes(), "x")
    assert written.sensors[2].zero == pytest.approx(result["sensors"][2]["zero"], rel=1e-11)
    assert file.read_bytes() == before


def test_the_command_writes_where_the_joint_file_says_and_reads_nothing_there(tmp_path, capsys):
    record(tmp_path)
    place = tmp_path / "kept" / "now.toml"
    place.parent.mkdir()
    place.write_text("not even TOML")
    file = tmp_path / "finger.toml"
    file.write_text(text(*RUN, top='calibration = "kept/now.toml"'))
    assert run("calibrate", str(file)) == 0
    out, err = capsys.readouterr()
    assert err.splitlines() == [f"ccgen: wrote {place}"]
    assert "near_top" in out
    assert "Radii are not determined" in out
    assert ccgen.load(file).sensors[0].metres_per_count == pytest.approx(STEP / 1.02, rel=0.01)


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("other.toml", 'is of joint "other", this one is "finger", and calibrate would write it'),
        ("run.csv", "is what the joint is read from, and calibrate would write it anew"),
        ("finger.toml", "is what the joint is read from, and calibrate would write it anew"),
    ],
)
def test_the_command_takes_no_file_away_that_others_are_read_from(tmp_path, capsys, place, says):
    record(tmp_path)
    file = tmp_path / "finger.toml"
    file.write_text(text(*RUN, top=f'calibration = "{place}"'))
    (tmp_path / "other.toml").write_text('format = 1\njoint = "other"\nfingerprint = "ab"\n')
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert run("calibrate", str(file)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert f"finger.toml: calibration: {place} {says}" in err
    assert 'write another, such as calibration = "finger.calibration.toml"' in err
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_suspicious_sensors_are_warned_of(tmp_path, capsys):
    record(tmp_path, change=stand_still)
    file = tmp_path / "finger.toml"
    file.write_text(text(*RUN))
    assert run("calibrate", str(file), "--json") == 0
    out, err = capsys.readouterr()
    (one,) = json.loads(out)["suspicious"]
    assert set(one) == {"name", "kind", "text"}
    assert f"ccgen: warning: sensor far_top (stuck): {one['text']}" in err.splitlines()
    assert json.loads(out)["sensors"][1]["metres_per_count"] is None
    written = (tmp_path / "finger.calibration.toml").read_text()
    assert '[[sensor]]\nname = "far_top"\n' in written


def test_what_the_command_refuses_leaves_an_older_file_as_it_was(tmp_path, capsys):
    place = Path(tmp_path / "finger.calibration.toml")
    place.write_text("older")
    record(tmp_path, change=uncounted)
    file = tmp_path / "finger.toml"
    file.write_text(text(*RUN))
    assert run("calibrate", str(file)) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert place.read_text() == "older"


@pytest.mark.parametrize(("step", "slips"), [(1.2e-4, False), (6e-4, True)])
def test_a_step_within_the_usual_noise_is_no_slip(step, slips):
    random = np.random.default_rng(0)
    expected = 5e-3 * np.sin(np.arange(600) / 20)[:, None]
    lengths = expected + 2e-5 * random.standard_normal((600, 1))
    lengths[300:] += step
    seen = Seen(
        source="run.csv", t=np.arange(600.0), timed=True, expected=expected, lengths=lengths,
        raw=lengths, step=np.array([STEP]), noise=1.2e-4,
    )  # fmt: skip
    assert [one.kind for one in suspicious(["u0"], [seen])] == ["slipping"] * slips
