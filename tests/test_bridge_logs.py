"""Runs of `ccgen bridge` in logs, and what logs and recordings hold sent again."""

import gzip
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import can
import numpy as np
import pytest
from waiting import PATIENCE, becomes

from ccgen.can.bridge import bridge, replayed_stream, simulated_stream
from ccgen.can.logs import LOGS, frame_log
from ccgen.can.replay import logged_counts
from ccgen.can.transports.library import library_node
from ccgen.cli.main import main
from ccgen.errors import InputError
from ccgen.export.package import export
from ccgen.recordings.log_files import read_frames
from ccgen.sensing.counts import random_counts
from ccgen.shapes import score_library
from ccgen.targets.exported import open_exported
from ccgen.targets.host import compile_shared

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def ccgen(*words) -> int:
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return int(end.value.code or 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("logs") / "shoulder"
    export(EXAMPLES / "shoulder.toml", directory)
    return directory


@pytest.fixture(scope="module")
def exported(folder):
    return open_exported(folder)


@pytest.fixture(scope="module")
def library(folder):
    return compile_shared(folder, folder.parent)


@pytest.fixture(scope="module")
def logs(folder):
    """A run of half a second in every kind of log."""
    paths = {ending: folder.parent / f"run{ending}" for ending in LOGS}
    for path in paths.values():
        words = ("--source", "random", "--seconds", "0.5", "--rate", "100")
        assert ccgen("bridge", folder, *words, "--log", path) == 0
    return paths


def payloads(path, exported):
    """Data of the LENGTHS frames of a log, in order."""
    ids = {frame.id for frame in exported.layout.frames_of("lengths")}
    return [bytes(m.data) for m in read_frames(path) if m.arbitration_id in ids]


def sent_again(folder, source, log, *words):
    return ccgen("bridge", folder, "--source", source, "--log", log, "--json", *words)


@pytest.mark.parametrize("ending", LOGS)
def test_a_log_holds_every_frame_with_its_direction_and_in_order_of_time(logs, exported, ending):
    frames = list(read_frames(logs[ending]))
    layout = exported.layout
    lengths = [m for m in frames if m.arbitration_id < layout.base_id + layout.lengths_frames]
    answers = [m for m in frames if m.arbitration_id == layout.frames_of("tip")[0].id]
    assert (len(lengths), len(answers)) == (100, 50)
    if ending != ".csv":  # python-can's CSV knows no direction
        assert {m.is_rx for m in lengths} == {False}
        assert {m.is_rx for m in answers} == {True}
    assert (np.diff([m.timestamp for m in frames]) >= 0).all()


@pytest.mark.parametrize("ending", LOGS)
def test_a_replay_of_a_replay_has_the_same_bytes(logs, folder, exported, tmp_path, ending):
    first, second = tmp_path / f"first{ending}", tmp_path / f"second{ending}"
    assert sent_again(folder, logs[ending], first, "--speed", "max") == 0
    assert sent_again(folder, first, second, "--speed", "max") == 0
    assert payloads(first, exported) == payloads(logs[ending], exported)
    assert payloads(second, exported) == payloads(first, exported)


def test_a_log_is_sent_again_at_its_own_times(logs, folder, exported, tmp_path, capsys):
    again = tmp_path / "again.blf"
    assert sent_again(folder, logs[".blf"], again) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["answered"], record["lost_frames"], record["mismatches"]) == (50, 0, 0)
    assert record["error_percent_rom"] is None
    spans = []
    for path in (logs[".blf"], again):
        times = [m.timestamp for m in read_frames(path) if m.arbitration_id == 0x300]
        spans.append(times[-1] - times[0])
    assert spans[1] >= 0.99 * 0.49
    assert spans[1] == pytest.approx(spans[0], abs=PATIENCE)


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".blf", ".log"])
def test_ten_thousand_snapshots_come_back_the_same(exported, library, tmp_path, ending):
    first, second = tmp_path / f"first{ending}", tmp_path / f"second{ending}"
    counts = random_counts(list(exported.model.axes.values()), 10_000)
    path = tmp_path / "counts.csv"
    header = ",".join(f"count_{name}" for name in exported.layout.sensors)
    np.savetxt(path, counts, fmt="%d", delimiter=",", header=header, comments="")
    assert sent_again(exported.directory, path, first, "--speed", "max") == 0
    replay = logged_counts(read_frames(first), exported.codec, exported.fingerprint, first)
    np.testing.assert_array_equal(replay.counts, counts)
    stream = replayed_stream(exported.joint, exported.guarded, "log", replay, in_time=False)
    answers = []
    with library_node(library, exported.layout) as bus, frame_log(second) as log:
        summary = bridge(bus, exported.codec, stream, "virtual", answers.append, log)
    assert (summary.answered, summary.lost_frames, summary.corrupted) == (10_000, 0, 0)
    assert summary.passed
    angles = np.array([answer.angles for answer in answers])
    np.testing.assert_array_equal(angles, exported.model.estimate(counts))
    assert payloads(second, exported) == payloads(first, exported)


def test_a_recording_is_sent_as_it_was_read_with_gaps(folder, exported, tmp_path, capsys):
    names = exported.layout.sensors
    rows = [
        ["t", *(f"count_{name}" for name in names), "u0"],
        *([f"{0.02 * k}", *(str(100 * k + j) for j in range(len(names))), "0.5"] for k in range(9)),
    ]
    rows[4][2] = ""  # sensor u1 of the fourth sample
    path = tmp_path / "run.csv.gz"
    path.write_bytes(gzip.compress("\n".join(map(",".join, rows)).encode()))
    log = tmp_path / "run.blf"
    assert sent_again(folder, path, log, "--seconds", "0.13") == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["snapshots"], record["answered"], record["mismatches"]) == (7, 7, 0)
    assert "MISSING" in record["faults"]
    counts = logged_counts(read_frames(log), exported.codec, exported.fingerprint, log).counts
    assert counts[0].tolist() == [0, 1, 2, 3, 4, 5]
    assert counts[3].tolist() == [300, -(2**15), 302, 303, 304, 305]


def test_a_snapshot_that_came_incomplete_is_left_out_and_said(logs, folder, tmp_path, capsys):
    frames = list(read_frames(logs[".blf"]))
    spoilt = tmp_path / "spoilt.blf"
    victim = [k for k, m in enumerate(frames) if m.arbitration_id == 0x301][20]
    with frame_log(spoilt) as log:
        for message in frames[:victim] + frames[victim + 1 :]:
            log(message)
    assert sent_again(folder, spoilt, tmp_path / "again.blf", "--speed", "max") == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["answered"] == 49
    assert f"warning: {spoilt}: 1 snapshots came incomplete; they are left out" in err


def test_a_log_of_another_model_of_the_joint_is_sent_and_said(logs, folder, tmp_path, capsys):
    text = (EXAMPLES / "shoulder.toml").read_text().replace('"wam"', '"equal"')
    (tmp_path / "shoulder.toml").write_text(text)
    words = ("--source", logs[".blf"], "--speed", "max", "--json")
    assert ccgen("bridge", tmp_path / "shoulder.toml", *words) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["mismatches"] == 0
    assert f"{logs['.blf']}: was logged with another model (0x" in err


@pytest.mark.parametrize("ending", LOGS)
def test_a_log_that_was_cut_off_is_named(logs, folder, tmp_path, capsys, ending):
    cut = tmp_path / f"cut{ending}"
    data = logs[ending].read_bytes()
    cut.write_bytes(data[: len(data) * 2 // 3 + (data[len(data) * 2 // 3 - 1] == 10)])
    assert sent_again(folder, cut, tmp_path / "again.blf") == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith(f"ccgen: error: {cut}: ")


@pytest.mark.parametrize("ending", LOGS)
def test_a_log_of_noise_is_named(folder, tmp_path, capsys, ending):
    noise = tmp_path / f"noise{ending}"
    noise.write_bytes(np.random.default_rng(1).bytes(5000) + b"\n")
    assert sent_again(folder, noise, tmp_path / "again.blf") == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert str(noise) in err


def test_a_log_of_another_joint_is_named(folder, tmp_path, capsys):
    text = (EXAMPLES / "shoulder.toml").read_text().replace("base_id = 0x300", "base_id = 0x500")
    (tmp_path / "shoulder.toml").write_text(text)
    log = tmp_path / "run.log"
    assert ccgen("bridge", tmp_path / "shoulder.toml", "--seconds", "0.05", "--log", log) == 0
    capsys.readouterr()
    assert ccgen("bridge", folder, "--source", log) == 2
    assert capsys.readouterr().err == (
        f"ccgen: error: {log}: holds no complete snapshot of shoulder; name a log of this joint "
        "and the folder that its sensors were compiled from\n"
    )


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--log", "run.txt"), "--log: run.txt: no log ends so; end it in .log (candump), .asc,"),
        (("--log", "nowhere/run.log"), "nowhere/run.log: no such file or directory"),
        (("--source", "waves"), "--source: waves is neither a file nor one of cases, random, sw"),
        (("--source", "run.csv", "--rate", "5"), "--rate: is for motions; a file takes --speed 1"),
        (("--speed", "max"), "--speed: is for files; cases takes --rate"),
        (("--source", "run.csv"), "run.csv: holds no counts; write a column a sensor, such as co"),
        (("--source", "half.csv"), "half.csv: row 2, count_u0: 1.5 is no count that a frame can"),
        (("--source", "wide.csv"), "wide.csv: row 1, count_u0: 32768 is no count that a frame c"),
        (("--source", "run.csv", "--log", "run.csv"), "--log: run.csv is what is read; choose an"),
    ],
)
def test_what_does_not_fit_is_one_line(folder, tmp_path, monkeypatch, capsys, words, says):
    monkeypatch.chdir(tmp_path)
    Path("run.csv").write_text("t,u0\n0,1\n1,1\n")
    Path("half.csv").write_text("count_u0\n1\n1.5\n")
    Path("wide.csv").write_text("count_u0\n32768\n")
    assert ccgen("bridge", folder, "--seconds", "0.05", *words) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert says in err


def test_a_full_disk_is_one_line(folder, tmp_path, capsys):
    (tmp_path / "run.log").symlink_to("/dev/full")
    assert ccgen("bridge", folder, "--seconds", "0.05", "--log", tmp_path / "run.log") == 2
    err = capsys.readouterr().err
    assert err.splitlines()[-1] == f"ccgen: error: {tmp_path}/run.log: no space left on device"


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_closes_the_log(folder, exported, tmp_path, number, unbuffered):
    """The signal comes with the first line of progress, long before the end."""
    log = tmp_path / "run.blf"
    words = [sys.executable, "-m", "ccgen", "bridge", folder, "--seconds", "60", "--log", log]
    process = subprocess.Popen(
        list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
    )  # fmt: skip
    try:
        assert process.stderr is not None
        assert becomes(lambda: "snapshot" in process.stderr.readline())
        os.kill(process.pid, number)
        process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143}[number]
    replay = logged_counts(read_frames(log), exported.codec, exported.fingerprint, log)
    assert len(replay.counts) > 0


@pytest.mark.parametrize("length", [7, 64])
@pytest.mark.parametrize("ending", LOGS)
def test_frames_of_can_fd_survive_every_kind_of_log(tmp_path, ending, length):
    frame = can.Message(
        timestamp=5.0, arbitration_id=0x18FF0001, is_fd=True, bitrate_switch=True,
        data=bytes(range(length)),
    )  # fmt: skip
    with frame_log(tmp_path / f"fd{ending}") as log:
        log(frame)
    (read,) = read_frames(tmp_path / f"fd{ending}", fd=True)
    assert (read.arbitration_id, bytes(read.data)) == (0x18FF0001, bytes(range(length)))
    assert (read.is_fd, read.is_extended_id) == (True, True)


def test_an_empty_log_is_whole_but_holds_nothing(exported, tmp_path):
    for ending in LOGS:
        path = tmp_path / f"empty{ending}"
        with frame_log(path):
            pass
        with pytest.raises(InputError, match="holds no complete snapshot of shoulder"):
            logged_counts(read_frames(path), exported.codec, exported.fingerprint, path)


def test_the_simulated_stream_still_knows_the_true_shape(exported):
    library = score_library(exported.joint)
    stream = simulated_stream(exported.joint, exported.guarded, library, "cases", 0.1, 100.0)
    assert set(stream.true_values(3)) == {"u", "v"}
