"""`ccgen bridge`: streams over both local transports, what it prints, and how it fails."""

import json
import threading
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import can
import numpy as np
import pytest
from joint_files import joint_text
from rich.console import Console
from waiting import PATIENCE

from ccgen.can.bridge import bridge, simulated_stream
from ccgen.can.exchange import Answer
from ccgen.can.transports.library import library_node
from ccgen.cli import bridge_display
from ccgen.cli.bridge import _failure, _print
from ccgen.cli.main import main
from ccgen.export.package import export
from ccgen.fixedpoint.watch import BACK_AFTER
from ccgen.shapes import score_library
from ccgen.targets.exported import open_exported
from ccgen.targets.host import compile_shared

EXAMPLE = Path(__file__).parent.parent / "examples" / "shoulder.toml"


NUMBERS = 240
"""After which those of snapshots come again."""


def ccgen(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("bridge") / "shoulder"
    export(EXAMPLE, directory)
    return directory


@pytest.fixture(scope="module")
def stream(folder):
    exported = open_exported(folder)
    library = score_library(exported.joint)
    return simulated_stream(exported.joint, exported.guarded, library, "cases", 0.5, 100.0)


def answer_to(stream, index, lost_frames=0):
    angles = tuple(stream.model.estimate(stream.counts[index]).tolist())
    return Answer(index, angles, (0, 2**14, -(2**14)), lost_frames, None)


@pytest.mark.parametrize(
    ("interface", "source"), [("virtual", "cases"), ("slcan", "sweep"), ("virtual", "random")]
)
def test_a_stream_comes_back_whole_and_as_the_model_has_it(folder, capsys, interface, source):
    status = ccgen(
        "bridge", str(folder), "--interface", interface, "--source", source, "--seconds", "0.5",
        "--rate", "200", "--json",
    )  # fmt: skip
    assert status == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["transport"], record["source"]) == (interface, source)
    assert (record["snapshots"], record["answered"]) == (100, 100)
    assert (record["lost_frames"], record["corrupted"], record["mismatches"]) == (0, 0, 0)
    assert 0 < record["rate_hz"] < 250
    assert set(record["error_percent_rom"]) == {"u", "v"}


def test_without_json_the_summary_is_a_table_of_one_snapshot_a_cycle(folder, capsys):
    assert ccgen("bridge", str(folder), "--seconds", "0.1") == 0
    out, _ = capsys.readouterr()
    assert "10 of 10 answered" in out
    assert "0 lost, 0 damaged" in out


def test_where_nobody_answers_the_status_is_one_and_the_line_says_so(folder, capsys):
    status = ccgen(
        "bridge", str(folder), "--interface", "virtual", "--channel", "nobody", "--seconds", "0.05"
    )
    assert status == 1
    assert "no snapshot was answered in full; does the joint's node listen there?" in (
        capsys.readouterr().err
    )


def test_a_node_that_answers_wrongly_fails_the_bridge(folder, capsys):
    """The way back swallows one ANGLES frame of every answer."""
    channel = "spoilt"
    exported = open_exported(folder)
    swallowed = exported.layout.frames_of("angles")[2].id
    library = compile_shared(folder, folder.parent)
    outer, done = can.Bus(interface="virtual", channel=channel), threading.Event()

    def forward():
        with library_node(library, exported.layout) as node, outer:
            while not done.is_set():
                while (message := outer.recv(0)) is not None:
                    node.send(message)
                message = node.recv(0.01)
                if message is not None and message.arbitration_id != swallowed:
                    outer.send(message)

    thread = threading.Thread(target=forward)
    thread.start()
    try:
        status = ccgen(
            "bridge", str(folder), "--interface", "virtual", "--channel", channel,
            "--seconds", "0.04",
        )  # fmt: skip
    finally:
        done.set()
        thread.join(PATIENCE)
    assert not thread.is_alive()
    out, err = capsys.readouterr()
    assert status == 1
    assert "0 of 4 answered" in out
    assert "no snapshot was answered in full" in err


def test_an_interface_that_does_not_open_is_bad_input(folder, capsys):
    status = ccgen(
        "bridge", str(folder), "--interface", "slcan", "--channel", "/dev/nowhere", "--seconds", "1"
    )
    assert status == 2
    assert "--interface: slcan /dev/nowhere cannot be opened" in capsys.readouterr().err


def test_a_folder_that_is_no_export_is_bad_input(tmp_path, capsys):
    assert ccgen("bridge", str(tmp_path)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert str(tmp_path) in err


def test_a_path_that_is_nothing_is_bad_input(tmp_path, capsys):
    assert ccgen("bridge", str(tmp_path / "finger.toml")) == 2
    assert "finger.toml: no such folder or joint file; `ccgen init" in capsys.readouterr().err


def test_the_load_cases_are_followed_as_closely_as_the_fit_promises(stream):
    exported = (stream.joint, stream.guarded)
    round_trip = simulated_stream(*exported, score_library(stream.joint), "cases", 10.0, 20.0)
    errors = [
        round_trip.error_percent_rom(answer_to(round_trip, k))["u"]
        for k in range(len(round_trip.counts))
    ]
    assert 0 < np.mean(errors) < 0.05


def test_errors_are_percent_of_the_range_of_motion(stream):
    answer = answer_to(stream, 7)
    off = replace(answer, angles=tuple(angle + 100 for angle in answer.angles))
    step = 100 * 100 * 2.0**-stream.model.u.fraction_bits / stream.joint.geometry.range_of_motion
    assert stream.error_percent_rom(answer)["u"] < 0.2
    assert stream.error_percent_rom(off)["u"] == pytest.approx(step, rel=0.2)
    np.testing.assert_allclose(
        stream.estimated_values(answer.angles)["v"], stream.true_values(7)["v"], atol=1e-3
    )


def test_the_live_table_shows_counts_shape_tip_and_losses(stream):
    console = Console(width=140, file=None, record=True, quiet=False)
    with console.capture() as shown:
        console.print(bridge_display._table(stream, "virtual", answer_to(stream, 20, 3), 2.0))
    text = shown.get()
    assert "shoulder on virtual: cases" in text
    for count in stream.counts[20]:
        assert str(count) in text
    assert "tip     0.0   125.0  -125.0 mm" in text
    assert "snapshot 21 of 50, 10 a second, 3 frames lost, 0 sensors missing" in text


def test_plain_progress_is_a_line_with_both_errors(stream):
    line = bridge_display._line(stream, answer_to(stream, 20, 3))
    assert line.startswith("snapshot 21 of 50: error u 0.")
    assert line.endswith("% of range, 3 frames lost")


def test_progress_is_shown_once_an_interval(monkeypatch, stream):
    clock, shown = [0.0], []
    monkeypatch.setattr(bridge_display, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    show = bridge_display._every(0.1, lambda answer, seconds: shown.append(seconds))
    for step in range(26):
        clock[0] = step / 100
        show(answer_to(stream, 0))
    assert shown == [0.1, 0.2]


def lines_of(capsys):
    """Snapshots by their number from the first, and the summary."""
    *rows, last = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    first = rows[0]["counter"]
    return {(row["counter"] - first) % NUMBERS: row for row in rows}, last["summary"]


def test_faults_reach_the_node_and_the_model_alike(folder, capsys):
    status = ccgen(
        "bridge", str(folder), "--seconds", "0.5", "--rate", "100", "--fault", "u1=lost@0.2",
        "--fault", "v0=stuck@0.1", "--fault", "v2=offset:0.0004@0.3", "--json-lines",
    )  # fmt: skip
    assert status == 0
    rows, summary = lines_of(capsys)
    assert summary["mismatches"] == summary["lost_frames"] == 0
    assert summary["injected"] == ["u1=lost@0.2", "v0=stuck@0.1", "v2=offset:0.0004@0.3"]
    assert "MISSING" in summary["faults"]
    assert summary["error_percent_rom"]["u"]["mean"] > 0
    exported = open_exported(folder)
    sent = simulated_stream(
        exported.joint, exported.guarded, score_library(exported.joint), "cases", 0.5, 100.0
    ).counts
    for index, row in rows.items():
        lost, stuck, off = index >= 20, index >= 10, index >= 30
        assert row["missing"] == (["u1"] if lost else [])
        assert ("missing" in row["faults"]) == lost
        assert row["counts"][1] == (None if lost else sent[index, 1])
        assert row["counts"][3] == sent[10 if stuck else index, 3]
        assert row["counts"][5] == sent[index, 5] + 200 * off
        assert row["counts"][0] == sent[index, 0]
    assert set(rows) >= set(range(1, 49))


def test_lines_are_those_of_monitor(folder, capsys):
    assert ccgen("bridge", str(folder), "--seconds", "0.1", "--json-lines") == 0
    rows, summary = lines_of(capsys)
    assert summary["answered"] == 10
    assert set(rows[3]) == {
        "t", "counter", "counts", "angles_deg", "elongation", "tip_m", "missing", "suspected",
        "faults",
    }  # fmt: skip
    assert rows[3]["faults"] == ["good"]
    assert rows[3]["elongation"] is None
    assert [len(rows[3]["angles_deg"][axis]) for axis in "uv"] == [12, 12]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--fault", "u7=lost@1"], "--fault: u7=lost@1: no sensor is called 'u7'; give one of u0"),
        (["--fault", "u1=gone@1"], "--fault: u1=gone@1: 'gone' is no fault; write SENSOR=stuck"),
        (["--fault", "u1=lost"], "--fault: u1=lost: is not of the form SENSOR=stuck@SECONDS"),
        (["--fault", "u1=lost@1", "--seconds", "0.5"], "begins after the last snapshot, at 0.49 s"),
        (["--json", "--json-lines"], "--json-lines: ends with what --json prints; give one"),
    ],
)
def test_faults_that_cannot_be_are_one_line(folder, capsys, words, said):
    assert ccgen("bridge", str(folder), *words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert len(err.splitlines()) == 1


def test_an_axis_without_reading_is_shown_so(stream):
    lost = -(2 ** (stream.model.precision - 1))
    answer = answer_to(stream, 20)
    segments = stream.model.segments
    answer = replace(answer, angles=(lost,) * segments + answer.angles[segments:])
    assert set(stream.error_percent_rom(answer)) == {"v"}
    console = Console(width=140, file=None, record=True, quiet=False)
    with console.capture() as shown:
        console.print(bridge_display._table(stream, "virtual", answer, 2.0))
    assert "no reading" in shown.get()


LOADS = """
[loads]
samples = 100
stiffness = 0.05
stiffness_profile = [2.0, 1.0, 1.0, 2.0]
actuation = [-40.0, 40.0]
contact = [0.0, 0.5]
contact_from = 0.05
"""


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """An exported joint that states its loads and holds its sensors against each other."""
    directory = tmp_path_factory.mktemp("loaded")
    text = joint_text(
        segments=8,
        count=4,
        range_of_motion=8.0,
        transducer="noise = 5e-5",
        tables=LOADS + "[can]\ncommands = true\n",
    )
    (directory / "joint.toml").write_text(text)
    export(directory / "joint.toml", directory / "folder")
    return directory / "folder"


def test_no_sound_sensor_of_a_joint_with_loads_is_suspected(loaded, tmp_path):
    exported = open_exported(loaded)
    joint, guarded = exported.joint, exported.guarded
    assert guarded.groups
    sent = simulated_stream(joint, guarded, None, "loads", 300.0, 10.0)
    stream = replace(sent, rate_hz=None)
    with library_node(compile_shared(loaded, tmp_path), exported.layout) as bus:
        summary = bridge(bus, exported.codec, stream, "virtual")
    assert (summary.answered, summary.mismatches, summary.degraded_snapshots) == (3000, 0, 0)
    assert summary.suspected == ()
    assert "SUSPECTED" not in summary.faults
    cases = simulated_stream(joint, guarded, score_library(joint), "cases", 300.0, 10.0)
    assert guarded.follow(cases.counts).states.any()  # which these loads do not bend it to


def test_a_joint_with_loads_is_moved_by_them(loaded, capsys):
    assert ccgen("bridge", str(loaded), "--seconds", "0.1", "--json") == 0
    assert json.loads(capsys.readouterr().out)["source"] == "loads"


def test_what_a_node_held_of_its_sensors_before_is_no_mismatch(loaded, tmp_path):
    exported = open_exported(loaded)
    joint, guarded = exported.joint, exported.guarded
    sent = replace(simulated_stream(joint, guarded, None, "loads", 8.0, 10.0), rate_hz=None)
    sensor = guarded.groups[0].own.start
    broken = sent.counts.copy()
    broken[:, sensor] += 2000
    after = guarded.follow(broken).watches[0]
    assert after.out  # or nothing would differ
    broken_stream = replace(sent, counts=broken)
    with library_node(compile_shared(loaded, tmp_path), exported.layout) as bus:
        first = bridge(bus, exported.codec, broken_stream, "virtual")
        second = bridge(bus, exported.codec, sent, "virtual")
        third = bridge(bus, exported.codec, sent, "virtual")
    assert first.mismatches == 0
    assert first.left_out_before == ()
    assert second.passed
    assert second.left_out_before == (joint.sensors[sensor + after.sensor].name,)
    assert second.degraded_snapshots == BACK_AFTER - 1
    assert (third.mismatches, third.left_out_before, third.degraded_snapshots) == (0, (), 0)


def commanded(bus, codec, resting, number, command):
    """Send a COMMAND frame while snapshots of the joint at rest are streamed."""
    frame = codec.encode_frame("command", 0, (number, command, 3), number)
    bridge(bus, codec, resting, "virtual", lambda a: bus.send(frame) if a.index == 4 else None)


def test_a_zero_that_was_captured_before_is_said_and_is_no_mismatch(loaded, tmp_path, capsys):
    exported = open_exported(loaded)
    codec = exported.codec
    sent = simulated_stream(exported.joint, exported.guarded, None, "loads", 3.0, 10.0)
    sent = replace(sent, rate_hz=None)
    resting = replace(sent, counts=np.full_like(sent.counts, 40), shapes=None)
    with library_node(compile_shared(loaded, tmp_path), exported.layout) as bus:
        commanded(bus, codec, resting, 1, 1)
        captured = bridge(bus, codec, sent, "virtual")
        commanded(bus, codec, resting, 2, 2)
        again = bridge(bus, codec, sent, "virtual")
    assert (captured.other_zero, captured.mismatches) == ("captured", 0)
    assert captured.answered == len(sent.counts)
    assert captured.error_percent_rom is None
    assert not captured.passed
    assert "works with a zero that was captured" in _failure(captured)
    _print(captured)
    assert "not compared" in capsys.readouterr().out
    assert (again.other_zero, again.mismatches) == ("", 0)
    assert again.passed
