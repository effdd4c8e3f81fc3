"""`ccgen monitor`: every snapshot, and every fault by its name, on what foreign senders send.

The sensors are played by cantools and autosar-e2e, the node by its own C, and both by a clock of
the test: nothing depends on the machine.
"""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
from pathlib import Path

import can
import cantools
import e2e.p01
import e2e.p05
import numpy as np
import pytest
from false_alarms import along
from jsonschema import Draft202012Validator
from mcap.reader import make_reader
from waiting import PATIENCE, becomes, read_until, write_all

from ccgen.can.logs import frame_log
from ccgen.can.monitor import Monitor
from ccgen.can.seen import plain
from ccgen.can.transports.library import _Node
from ccgen.cli.main import main
from ccgen.cli.monitor_display import line, table
from ccgen.export.package import export
from ccgen.recordings.log_files import read_frames
from ccgen.sensing.readings import length_changes
from ccgen.targets.exported import open_exported
from ccgen.targets.host import compile_shared

SHOULDER = Path(__file__).resolve().parent.parent / "examples" / "shoulder.toml"
CYCLE, GAP = 10_000, 200
FIRST, SNAPSHOTS, VICTIM = 100, 60, 30
START = 1_700_000_000.0
VARIANTS = {
    "classic": lambda text: text,
    "fd": lambda text: text.replace("fd = false", "fd = true").replace(
        "bits = 16", "bits = 24"
    ).replace("metres_per_count = 2.0e-6", "metres_per_count = 1.0e-8").replace(
        "precision = 16", "precision = 32"
    ),
}  # fmt: skip


def ccgen(*words) -> int:
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return int(end.value.code or 0)


class Joint:
    """An exported joint, a foreign sender of its lengths, and its node in C."""

    def __init__(self, folder, text):
        (folder / "shoulder.toml").write_text(text)
        export(folder / "shoulder.toml", folder / "shoulder")
        self.exported = open_exported(folder / "shoulder")
        self.directory = self.exported.directory
        self.library = compile_shared(self.directory, folder)
        self.database = cantools.database.load_file(self.directory / "shoulder.dbc")
        layout = self.exported.layout
        self.layout, self.numbers = layout, layout.numbers
        steps = np.arange(SNAPSHOTS)[:, None] + np.arange(len(layout.sensors))
        self.counts = 37 * steps - 1500

    def lengths(self, k, number=None):
        """Frames of snapshot k, in the way of a sender that knows the DBC and AUTOSAR alone."""
        number = (FIRST + k if number is None else number) % self.numbers
        turn, counter = divmod(number, 256 if self.layout.fd else 15)
        frames, first = [], 0
        for spec in self.layout.frames_of("lengths"):
            message = self.database.get_message_by_name(spec.name)
            signals = {signal.name: 0 for signal in message.signals}
            signals["counter"] = counter
            if "turn" in signals:
                signals["turn"] = turn
            for own in spec.payload:
                signals[own.name] = int(self.counts[k % SNAPSHOTS, first])
                first += 1
            data = bytearray(message.encode(signals, scaling=False, strict=False))
            frames.append(self.frame(spec.id, data))
        return frames

    def frame(self, identifier, data):
        data = bytearray(data)
        protect = e2e.p05.e2e_p05_protect if self.layout.fd else e2e.p01.e2e_p01_protect
        protect(data, identifier & 0xFFFF, increment_counter=False)
        return can.Message(
            arbitration_id=identifier, is_extended_id=False, is_fd=self.layout.fd, data=data
        )

    def plan(self, snapshots=SNAPSHOTS):
        """When each frame of the sensors is sent, microseconds."""
        return [
            (CYCLE * k + GAP * i, frame)
            for k in range(snapshots)
            for i, frame in enumerate(self.lengths(k))
        ]

    def answered(self, plan, window_us=CYCLE):
        """The whole bus: what the sensors send and what the node answers, with its times."""
        node, frames = _Node(self.library, self.layout), []
        node._functions.ccgen_shared_node_set_window(node._state, window_us)

        def drain(now):
            answers = iter(lambda: node.transmit(now), None)
            frames.extend((now + 1 + k, answer) for k, answer in enumerate(answers))

        clock = 0
        for now, message in sorted(plan, key=lambda item: item[0]):
            while clock + CYCLE // 10 <= now:
                clock += CYCLE // 10
                drain(clock)
            frames.append((now, message))
            node.receive(message, now)
            drain(now)
        for message in frames:
            message[1].timestamp = START + 1e-6 * message[0]
        return [message for _, message in sorted(frames, key=lambda item: item[0])]


@pytest.fixture(scope="module", params=VARIANTS)
def joint(request, tmp_path_factory):
    text = VARIANTS[request.param](SHOULDER.read_text())
    return Joint(tmp_path_factory.mktemp("monitor"), text)


@pytest.fixture(scope="module")
def classic(tmp_path_factory):
    return Joint(tmp_path_factory.mktemp("monitor"), SHOULDER.read_text())


def watched(joint, frames, folder, capsys, *words, status=0):
    """Lines of `ccgen monitor --json` on a log of the frames, and the summary."""
    log = folder / "run.blf"
    with frame_log(log) as take:
        for message in frames:
            take(message)
    assert ccgen("monitor", joint.directory, "--source", log, "--json", *words) == status
    *lines, last = map(json.loads, capsys.readouterr().out.splitlines())
    return lines, last["summary"]


def at(plan, k, frame):
    """Place in the plan of one frame of snapshot k."""
    return 2 * k + frame if len(plan) == 2 * SNAPSHOTS else k


def faults(lines):
    """What was wrong, by how many numbers after the first."""
    return {line["counter"] - FIRST: line["faults"] for line in lines if line["faults"] != ["good"]}


def check_good(joint, lines, but=()):
    """Every snapshot but these is there once, as it was sent and as the model answers it."""
    good = {line["counter"] - FIRST: line for line in lines if line["faults"] == ["good"]}
    wanted = set(range(SNAPSHOTS)) - set(but)
    assert set(good) == wanted
    model, rows = joint.exported.model, sorted(wanted)
    values = model.estimate(joint.counts[rows])
    for axis, part in model.split(values).items():
        angles = np.array([good[k]["angles_deg"][axis] for k in rows])
        exact = np.degrees(model.axis(axis).radians(part))
        np.testing.assert_allclose(angles, exact, rtol=0, atol=1e-9)
    assert [good[k]["counts"] for k in rows] == joint.counts[rows].tolist()


def test_a_bus_without_faults_is_good_snapshot_by_snapshot(joint, tmp_path, capsys):
    lines, summary = watched(joint, joint.answered(joint.plan()), tmp_path, capsys)
    check_good(joint, lines)
    assert lines[0].keys() == {
        "t", "counter", "counts", "angles_deg", "elongation", "tip_m", "missing", "suspected",
        "faults",
    }  # fmt: skip
    times = [line["t"] - START for line in lines]
    np.testing.assert_allclose(times, 0.01 * np.arange(SNAPSHOTS), atol=1e-5)
    assert (summary["snapshots"], summary["mismatches"]) == (60, 0)
    assert summary["compared"] >= 50
    assert summary["rate_hz"] == pytest.approx(100)
    assert summary["faults"] == {"good": 60}
    states = summary["messages"].values()
    assert {key for frame in states for key in frame} == {"good"}
    assert summary["frames"] == sum(frame["good"] for frame in states)


def drop_one(joint, plan):
    del plan[at(plan, VICTIM, 0)]


def drop_whole(joint, plan):
    plan[:] = [item for item in plan if item[0] // CYCLE != VICTIM]


def duplicate(joint, plan):
    now, frame = plan[at(plan, VICTIM, 0)]
    plan.append((now + 1, joint.frame(frame.arbitration_id, frame.data)))


def swap(joint, plan):
    """Snapshot 30's last frame goes after 31's first."""
    place = at(plan, VICTIM, 1)
    first = plan[at(plan, VICTIM + 1, 0)]
    plan[at(plan, VICTIM + 1, 0)] = (first[0] - 2000, first[1])
    plan[place] = (first[0] - 1000, plan[place][1])


def late(joint, plan):
    """A millisecond after the window, and the next snapshot waits for it."""
    place = at(plan, VICTIM, 1)
    plan[place] = (CYCLE * VICTIM + CYCLE + 1000, plan[place][1])
    for i in range(2):
        place = at(plan, VICTIM + 1, i)
        plan[place] = (plan[place][0] + 2000, plan[place][1])


def wrong_crc(joint, plan):
    plan[at(plan, VICTIM, 1)][1].data[3] ^= 1


def wrong_length(joint, plan):
    now, frame = plan[at(plan, VICTIM, 1)]
    cut = can.Message(
        arbitration_id=frame.arbitration_id, is_extended_id=False, is_fd=frame.is_fd,
        data=frame.data[: 48 if frame.is_fd else 7],
    )  # fmt: skip
    plan[at(plan, VICTIM, 1)] = (now, cut)


def remote(joint, plan):
    """Somebody asks for a frame instead of sending it."""
    now, frame = plan[at(plan, VICTIM, 1)]
    asked = can.Message(
        arbitration_id=frame.arbitration_id, is_extended_id=False, is_remote_frame=True, dlc=8
    )
    plan[at(plan, VICTIM, 1)] = (now, asked)


def wrong_counter(joint, plan):
    """The one value that P01 does not use."""
    now, frame = plan[at(plan, VICTIM, 1)]
    frame.data[1] |= 0x0F
    plan[at(plan, VICTIM, 1)] = (now, joint.frame(frame.arbitration_id, frame.data))


def number_of_the_past(joint, plan):
    place = at(plan, VICTIM, 1)
    plan[place] = (plan[place][0], joint.lengths(VICTIM, FIRST + VICTIM - 4)[-1])


def wrong_turn(joint, plan):
    place = at(plan, VICTIM, 1)
    plan[place] = (plan[place][0], joint.lengths(VICTIM, FIRST + VICTIM - 15)[-1])


def turn_of_the_future(joint, plan):
    place = at(plan, VICTIM, 1)
    plan[place] = (plan[place][0], joint.lengths(VICTIM, FIRST + VICTIM + 15)[-1])


def restart(joint, plan):
    """The sender begins anew with its first number, and keeps no silence."""
    plan[:] = [item for item in plan if item[0] // CYCLE < VICTIM] + [
        (CYCLE * k + GAP * i, frame)
        for k in range(VICTIM, SNAPSHOTS)
        for i, frame in enumerate(joint.lengths(k, FIRST + k - VICTIM))
    ]


def silence(joint, plan):
    plan[:] = [(now + 10 * CYCLE * (now // CYCLE >= VICTIM), frame) for now, frame in plan]


KINDS = {
    "drop of one frame": (drop_one, {30: ["some_lost"]}, []),
    "drop of a whole snapshot": (drop_whole, {31: ["some_lost"]}, [30]),
    "duplicate": (duplicate, {30: ["repeated"]}, []),
    "swap": (swap, {30: ["some_lost"], 31: ["reordered"]}, []),
    "late": (late, {30: ["late"]}, []),
    "wrong CRC": (wrong_crc, {30: ["some_lost", "bad_crc"]}, []),
    "wrong length": (wrong_length, {30: ["some_lost", "bad_format"]}, []),
    "remote": (remote, {30: ["some_lost", "bad_format"]}, []),
    "wrong counter": (wrong_counter, {30: ["some_lost", "bad_format"]}, []),
    "counter of the past": (number_of_the_past, {30: ["some_lost", "reordered"]}, []),
    "wrong turn": (wrong_turn, {30: ["some_lost", "reordered"]}, []),
    "turn of the future": (
        turn_of_the_future,
        {30: ["some_lost"], 45: ["some_lost", "reordered", "stale"], 34: ["stale"]},
        [31, 32, 33],
    ),
    "silence": (silence, {30: ["stale"]}, []),
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_fault_on_the_way_is_named_at_its_snapshot(classic, tmp_path, capsys, kind):
    spoil, named, absent = KINDS[kind]
    plan = classic.plan()
    spoil(classic, plan)
    lines, summary = watched(classic, classic.answered(plan), tmp_path, capsys)
    if kind == "turn of the future":  # number 145 is there twice, once by mistake
        (wrong,) = [k for k, seen in enumerate(lines) if seen["faults"] == named[45]]
        assert lines.pop(wrong)["counter"] == FIRST + 45
        named = {30: named[30], 34: named[34]}
    assert faults(lines) == named
    check_good(classic, lines, but=[*named, *absent])
    assert summary["mismatches"] == 0


def test_a_restart_without_silence_is_old_until_the_numbers_are_forgotten(
    classic, tmp_path, capsys
):
    plan = classic.plan()
    restart(classic, plan)
    lines, summary = watched(classic, classic.answered(plan), tmp_path, capsys)
    assert len(lines) == VICTIM + (SNAPSHOTS - VICTIM - 3)
    assert lines[VICTIM]["counter"] == FIRST + 3
    assert lines[VICTIM]["faults"] == ["reordered", "stale"]
    others = lines[:VICTIM] + lines[VICTIM + 1 :]
    assert {tuple(line["faults"]) for line in others} == {("good",)}
    assert summary["messages"]["SHOULDER_LENGTHS_0"] == {"good": 57, "reordered": 3}
    assert summary["mismatches"] == 0


@pytest.mark.parametrize("lost", [[1], [0, 1]])
def test_a_sensor_without_a_reading_is_named(lost, joint, tmp_path, capsys):
    kept = joint.counts
    joint.counts = kept.copy()
    joint.counts[VICTIM, lost] = joint.layout.frames_of("lengths")[0].payload[1].no_reading
    told = joint.exported.guarded.follow(joint.counts[[VICTIM]]).values[0]
    frames = joint.answered(joint.plan())
    joint.counts = kept
    lines, summary = watched(joint, frames, tmp_path, capsys)
    assert faults(lines) == {30: ["missing"]}
    victim = lines[VICTIM]
    assert victim["missing"] == [f"u{j}" for j in lost]
    assert victim["counts"] == [
        None if j in lost else count for j, count in enumerate(joint.counts[VICTIM].tolist())
    ]
    angles = joint.exported.model.split(told)
    for axis in "uv":
        known = np.degrees(joint.exported.model.axis(axis).radians(angles[axis]))
        gone = axis == "u" and len(lost) > 1
        assert victim["angles_deg"][axis] == ([None] * 12 if gone else pytest.approx(known))
    assert (None in victim["tip_m"]) == (len(lost) > 1)
    check_good(joint, lines, but=[30])
    assert summary["node_faults"] == ["MISSING"]
    assert summary["mismatches"] == 0


def test_a_sensor_that_the_node_suspects_is_named(joint, tmp_path, capsys):
    """A HEALTH frame that suspects the second v sensor, from a node that watches its sensors."""
    frames, health = joint.answered(joint.plan()), joint.layout.frames_of("health")[0]
    (start,) = [s.start for s in health.signals if s.name == "suspected_sensors"]
    victims = [m for m in frames if m.arbitration_id == health.id and m.timestamp > START + 0.25]
    for message in victims[:2]:
        bit = start + joint.layout.missing_bits[4]
        message.data[bit // 8] |= 1 << bit % 8
        message.data[:] = joint.frame(health.id, message.data).data
    lines, _ = watched(joint, frames, tmp_path, capsys)
    suspected = [line["counter"] - FIRST for line in lines if line["suspected"] == ["v1"]]
    assert len(suspected) == 20
    assert faults(lines) == {k: ["suspected"] for k in suspected}
    check_good(joint, lines, but=suspected)


@pytest.fixture(scope="module")
def swinging(tmp_path_factory):
    """A joint with enough sensors to hold against each other, swinging slowly to one side."""
    joint = Joint(tmp_path_factory.mktemp("monitor"), along(6, name="shoulder"))
    parsed = joint.exported.joint
    angles = np.radians(2.0) * np.sin(np.pi * np.arange(SNAPSHOTS) / SNAPSHOTS)[:, None]
    along_joint = np.cos(np.arange(12) / 8.0)  # bends most at the base
    state = np.concatenate([angles * along_joint, 0.7 * angles * along_joint, 0 * angles], axis=1)
    steps = [sensor.metres_per_count for sensor in parsed.sensors]
    joint.counts = np.rint(length_changes(parsed, state) / steps).astype(np.int64)
    return joint


@pytest.mark.parametrize("stuck", [2, 9])
def test_a_sensor_that_sticks_while_the_joint_moves_is_suspected(swinging, tmp_path, capsys, stuck):
    moving = swinging.counts
    swinging.counts = moving.copy()
    swinging.counts[10:, stuck] = moving[10, stuck]
    frames = swinging.answered(swinging.plan())
    swinging.counts = moving
    lines, summary = watched(swinging, frames, tmp_path, capsys)
    name = swinging.exported.joint.sensors[stuck].name
    told = [line["counter"] - FIRST for line in lines if line["suspected"]]
    assert {tuple(line["suspected"]) for line in lines if line["suspected"]} == {(name,)}
    assert 10 < told[0] <= 30
    assert set(range(told[0], SNAPSHOTS - 20)) <= set(told)  # while the joint moves away
    assert faults(lines) == {k: ["suspected"] for k in told}
    assert summary["faults"]["suspected"] == len(told)
    assert summary["mismatches"] == 0


def test_sensors_of_a_joint_that_moves_are_not_suspected(swinging, tmp_path, capsys):
    lines, summary = watched(swinging, swinging.answered(swinging.plan()), tmp_path, capsys)
    assert faults(lines) == {}
    assert summary["mismatches"] == 0


@pytest.mark.parametrize("victim", range(3))
def test_a_frame_of_the_answer_that_is_lost_is_named(classic, tmp_path, capsys, victim):
    """One of ANGLES, TIP and STATUS."""
    frames = classic.answered(classic.plan())
    spec = [classic.layout.frames_of(kind)[0] for kind in ("angles", "tip", "status")][victim]
    places = [k for k, m in enumerate(frames) if m.arbitration_id == spec.id]
    del frames[places[VICTIM]]
    lines, summary = watched(classic, frames, tmp_path, capsys)
    (place,) = faults(lines).values()
    assert place == ["some_lost"]
    assert summary["messages"][spec.name].get("some_lost", victim == 2)
    assert len(lines) == SNAPSHOTS


def test_without_lengths_on_the_bus_the_answers_are_the_snapshots(joint, tmp_path, capsys):
    ids = {frame.id for frame in joint.layout.frames_of("lengths")}
    plan = joint.plan()
    drop_whole(joint, plan)
    frames = [m for m in joint.answered(plan) if m.arbitration_id not in ids]
    lines, summary = watched(joint, frames, tmp_path, capsys)
    assert len(lines) == 59
    assert faults(lines) == {31: ["some_lost"]}
    assert all(line["counts"] is None for line in lines)
    assert summary["compared"] == 0
    assert summary["messages"]["SHOULDER_LENGTHS_0"] == {"never_seen": 0}


def test_without_a_node_on_the_bus_its_frames_are_never_seen(joint, tmp_path, capsys):
    plan = joint.plan()
    for now, message in plan:
        message.timestamp = START + 1e-6 * now
    lines, summary = watched(joint, [message for _, message in plan], tmp_path, capsys)
    assert [line["counts"] for line in lines] == joint.counts.tolist()
    assert {tuple(line["faults"]) for line in lines} == {("never_seen",)}
    assert summary["messages"]["SHOULDER_TIP"] == {"never_seen": 0}


def test_a_node_with_a_wider_window_knows_better_what_is_late(classic, tmp_path, capsys):
    plan = classic.plan()
    late(classic, plan)
    lines, summary = watched(classic, classic.answered(plan, 3 * CYCLE), tmp_path, capsys)
    check_good(classic, lines)
    assert summary["compared"] >= 50


def test_a_watch_that_begins_within_a_snapshot_misses_nothing(classic, tmp_path, capsys):
    frames = classic.answered(classic.plan())
    second = next(k for k, m in enumerate(frames) if m.arbitration_id == 0x301)
    lines, _ = watched(classic, frames[second:], tmp_path, capsys)
    assert faults(lines) == {}


def test_an_angle_that_differs_from_the_model_is_status_one(classic, tmp_path, capsys):
    frames = classic.answered(classic.plan())
    victim = [m for m in frames if m.arbitration_id == classic.layout.frames_of("angles")[2].id][9]
    victim.data[2] ^= 1
    victim.data[:] = classic.frame(victim.arbitration_id, victim.data).data
    log = tmp_path / "run.log"
    with frame_log(log) as take:
        for message in frames:
            take(message)
    assert ccgen("monitor", classic.directory, "--source", log) == 1
    out, err = capsys.readouterr()
    assert "1 values of 60 snapshots differ" in out
    assert err.endswith(f"{log}: 1 values of 60 snapshots differ from the reference model\n")


def test_a_node_of_another_model_is_refused(classic, tmp_path, capsys):
    text = SHOULDER.read_text().replace('"wam"', '"equal"')
    (tmp_path / "other").mkdir()
    other = Joint(tmp_path / "other", text)
    log = tmp_path / "run.blf"
    with frame_log(log) as take:
        for message in other.answered(other.plan()):
            take(message)
    assert ccgen("monitor", classic.directory, "--source", log) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"ccgen: error: {log}: the node is of another model (0x")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), "--interface: name the bus to listen to, such as --interface socketcan --channel c"),
        (("--interface", "virtual", "--source", "run.blf"), "--interface: name the bus"),
        (("--interface", "virtual", "--speed", "max"), "--speed: is for logs; a bus has its own"),
        (("--source", "nowhere.blf"), "nowhere.blf: no such file; name a log of the bus"),
        (("--source", "run.txt"), "run.txt: cannot be read as a CAN log"),
        (("--source", "empty.log"), "empty.log: holds no frame of shoulder; name a log of this j"),
        (("--source", "cut.log"), "cut.log: the log is cut off; copy it again, whole"),
        (("--source", "empty.log", "--log", "a.xyz"), "--log: a.xyz: no log ends so; end it in"),
        (("--source", "empty.log", "--udp", "here"), "--udp: here is no HOST:PORT, such as 127.0"),
        (("--source", "empty.log", "--udp", "1:99999"), "--udp: 1:99999 is no HOST:PORT"),
        (("--interface", "slcan", "--channel", "/dev/nowhere"), "slcan /dev/nowhere cannot be o"),
    ],
)
def test_what_does_not_fit_is_one_line(classic, tmp_path, monkeypatch, capsys, words, says):
    monkeypatch.chdir(tmp_path)
    Path("run.txt").write_text("nothing\n")
    Path("empty.log").write_text("")
    Path("cut.log").write_text("(1.000000) can0 123#11\n(1.100000) can0 300#00112233445")
    assert ccgen("monitor", classic.directory, *words) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert says in err


def test_a_bus_without_the_joint_is_status_one(classic, capsys):
    words = ("--interface", "virtual", "--channel", "nobody-there", "--seconds", "0.1")
    assert ccgen("monitor", classic.directory, *words) == 1
    assert capsys.readouterr().err.endswith(
        "virtual nobody-there: no frame of shoulder was heard; is it on this bus?\n"
    )


def test_what_is_monitored_is_logged_with_its_times(classic, tmp_path, capsys):
    frames = classic.answered(classic.plan())
    again = tmp_path / "again.log"
    watched(classic, frames, tmp_path, capsys, "--log", again)
    copied = list(read_frames(again))
    assert [bytes(m.data) for m in copied] == [bytes(m.data) for m in frames]
    times = [m.timestamp for m in frames]
    np.testing.assert_allclose([m.timestamp for m in copied], times, rtol=0, atol=1e-5)


def test_snapshots_are_sent_as_datagrams_of_json(classic, tmp_path, capsys):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(PATIENCE)
        port = receiver.getsockname()[1]
        frames = classic.answered(classic.plan())
        lines, _ = watched(classic, frames, tmp_path, capsys, "--udp", port)
        received = [json.loads(receiver.recv(1 << 16)) for _ in range(SNAPSHOTS)]
    assert received == lines


def test_datagrams_that_nobody_receives_end_nothing(classic, tmp_path, capsys):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
    frames = classic.answered(classic.plan())
    lines, _ = watched(classic, frames, tmp_path, capsys, "--udp", f"localhost:{port}")
    assert len(lines) == SNAPSHOTS


def test_an_mcap_file_holds_what_its_schema_says(classic, tmp_path, capsys):
    plan, path = classic.plan(), tmp_path / "run.mcap"
    drop_one(classic, plan)
    lines, _ = watched(classic, classic.answered(plan), tmp_path, capsys, "--mcap", path)
    with path.open("rb") as file:
        read = list(make_reader(file).iter_messages())
    assert {(s.name, s.encoding, c.topic, c.message_encoding) for s, c, _ in read} == {
        ("ccgen.Snapshot", "jsonschema", "/shoulder/snapshot", "json")
    }
    described = json.loads(read[0][0].data)
    Draft202012Validator.check_schema(described)
    records = [json.loads(message.data) for _, _, message in read]
    for record in records:
        Draft202012Validator(described).validate(record)
    assert [message.log_time for _, _, message in read] == [round(1e9 * x["t"]) for x in lines]
    assert [record["faults"] for record in records] == [seen["faults"] for seen in lines]
    good, victim = records[VICTIM - 1], records[VICTIM]
    assert good["angles_deg"] == lines[VICTIM - 1]["angles_deg"]
    assert good["tip_m"] == lines[VICTIM - 1]["tip_m"]
    assert list(good["counts"].values()) == lines[VICTIM - 1]["counts"]
    assert victim["angles_deg"] == {"u": [], "v": []}
    there = zip(classic.layout.sensors, lines[VICTIM]["counts"] or (), strict=False)
    assert victim["counts"] == {name: count for name, count in there if count is not None}


def test_without_mcap_the_package_is_named(classic, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    (tmp_path / "empty.log").write_text("")
    words = ("--source", tmp_path / "empty.log", "--mcap", tmp_path / "run.mcap")
    assert ccgen("monitor", classic.directory, *words) == 2
    assert capsys.readouterr().err == (
        "ccgen: error: an MCAP file needs mcap; install it with `pip install 'ccgen[view]'`\n"
    )
    assert not (tmp_path / "run.mcap").exists()


def test_a_reader_that_closes_its_pipe_ends_the_watch(classic, tmp_path):
    """The log is read at its own times, for longer than a test waits."""
    log, plan = tmp_path / "run.blf", classic.plan(int(3 * PATIENCE * 1e6 / CYCLE))
    with frame_log(log) as take:
        for now, message in plan:
            message.timestamp = START + 1e-6 * now
            take(message)
    words = ["monitor", classic.directory, "--source", log, "--speed", "1", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "ccgen", *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert json.loads(process.stdout.readline())["counter"] == FIRST
    process.stdout.close()
    assert process.wait(PATIENCE) == 0
    assert process.stderr.read() == b""


def test_the_live_table_shows_the_snapshot_and_every_frame(classic):
    from rich.console import Console

    exported = classic.exported
    watch = Monitor(exported.guarded, exported.codec, exported.fingerprint)
    plan = classic.plan()
    wrong_crc(classic, plan)
    seen = [one for m in classic.answered(plan) for one in watch.take(m)]
    console = Console(width=140)
    with console.capture() as shown:
        console.print(table(watch, exported, "can0"))
    text = shown.get()
    assert "shoulder on can0" in text
    for count in classic.counts[seen[-1].number - FIRST]:
        assert str(count) in text
    x, y, z = (1000 * value for value in plain(seen[-1], exported.model, exported.layout)["tip_m"])
    assert f"{x:7.1f} {y:7.1f} {z:7.1f} mm" in text
    assert "1 bad checksum" in text
    assert "u good, v good, zero of the model" in text
    assert line(watch).startswith(f"{len(seen)} snapshots, 100 a second: ")
    assert watch.states()["SHOULDER_TIP"] == "good"
    watch.now += 1.0
    assert watch.states()["SHOULDER_TIP"] == "stale"


def slcan(message):
    head = b"t%03X%d" % (message.arbitration_id, len(message.data))
    return head + message.data.hex().encode() + b"\r"


@pytest.mark.slow
@pytest.mark.parametrize("end", ["pulled", signal.SIGINT, signal.SIGTERM])
def test_five_thousand_frames_a_second_come_through_a_terminal(classic, tmp_path, end):
    """Ten seconds of them, logged and monitored; then the plug is pulled, or a signal comes."""
    snapshots = 4100
    frames = classic.answered(classic.plan(snapshots))
    log, far, near = tmp_path / "run.blf", *os.openpty()
    tty.setraw(near)
    words = [sys.executable, "-m", "ccgen", "monitor", classic.directory, "--interface", "slcan"]
    words += ["--channel", os.ttyname(near), "--log", log, "--window-ms", "1000", "--json"]
    process = subprocess.Popen(
        list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    said: list[str] = []
    reader = threading.Thread(target=lambda: said.extend(process.stdout))
    reader.start()
    try:
        read_until(far, lambda data: b"L\r" in data)
        begin = time.monotonic()
        for k in range(0, len(frames), 50):
            write_all(far, b"".join(map(slcan, frames[k : k + 50])))
            time.sleep(max(0.0, begin + (k + 50) / 5000 - time.monotonic()))
        assert becomes(lambda: len(said) == snapshots), len(said)
        os.close(near)
        if end == "pulled":
            os.close(far)
        else:
            process.send_signal(end)
        process.wait(PATIENCE)
        err = process.stderr.read()
        reader.join(PATIENCE)
    finally:
        process.kill()
    assert process.returncode == (2 if end == "pulled" else 0), err
    logged = [bytes(m.data) for m in read_frames(log)]
    assert logged == [bytes(m.data) for m in frames]
    lines = list(map(json.loads, said[:snapshots]))
    # Where the machine leaves the terminal alone for three cycles, snapshots are stale indeed.
    assert {tuple(seen["faults"]) for seen in lines} <= {("good",), ("stale",)}
    assert [seen["counter"] for seen in lines] == [(FIRST + k) % 240 for k in range(snapshots)]
    if end == "pulled":
        assert err.splitlines()[-1].startswith("ccgen: error: slcan /dev/pts/")
        assert "the bus went away" in err
        return
    os.close(far)
    summary = json.loads(said[-1])["summary"]
    assert (summary["frames"], summary["mismatches"]) == (len(frames), 0)
