"""HEALTH and COMMAND of an exported node: what it tells, and zeros asked for over the bus."""

import ctypes
from functools import cache

import can
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime_c import HERE, UNDEFINED, Frame, compile_c, completed, load
from test_runtime_snapshot import CLASSIC

from ccgen.can.codec import Health, health_of
from ccgen.export.package import export
from ccgen.joint.file import parse_joint
from ccgen.targets.compiler import sources
from ccgen.targets.exported import open_exported

CYCLE = 10_000
SECOND = 1_000_000
NONE, DONE, BUSY, SILENCE, MOVING, RANGE, UNKNOWN, NOTHING = range(8)
CAPTURE, MODEL, RESTORED = 1, 2, 3
LAST = 2**31 - 1
FROM_MODEL, CAPTURED, FROM_RESTORED = range(3)

TEXT = """
name = "elbow"
[geometry]
segments = 3
length = 0.06
range_of_motion = 5.0
[sensors]
radius = 0.02
count = 2
[sensors.transducer]
bits = 12
metres_per_count = 4.0e-6
noise = 8.0e-6
range = [-2000, 2000]
[fixed_point]
precision = 16
[can]
commands = true
"""
WIDE = (
    TEXT.replace("precision = 16", "precision = 32")
    .replace("bits = 12", "bits = 30")
    .replace("range = [-2000, 2000]", "range = [-500000000, 400000000]")
)
WIDEST = (
    TEXT.replace("precision = 16", "precision = 32")
    .replace("bits = 12", "bits = 32\nzero = 0")
    .replace("range = [-2000, 2000]\n", "")
)
FD = TEXT.replace("[can]", "[can]\nfd = true\nrate_switch = true")


@cache
def exported_from(text):
    """The folder of a joint, opened, and its node as a shared library."""
    folder = _FOLDERS.mktemp("health") / "elbow"
    export(parse_joint(text, "elbow.toml"), folder)
    files = [*sources(folder), folder / "ports" / "shared" / "shared.c", HERE / "zero.c"]
    include = [f"-I{folder / part}" for part in ("src", "ports")]
    flags = (*UNDEFINED, "-O1", "-shared", "-fPIC", *include, "-DPORT_ZERO(name)=elbow_##name")
    return open_exported(folder), ctypes.CDLL(str(compile_c(files, flags)))


_FOLDERS: pytest.TempPathFactory


@pytest.fixture(autouse=True, scope="module")
def folders(tmp_path_factory):
    global _FOLDERS
    _FOLDERS = tmp_path_factory


class Node:
    """A node that is spoken to through its DBC, and its clock."""

    def __init__(self, text=TEXT):
        self.exported, self.c = exported_from(text)
        self.codec, self.layout = self.exported.codec, self.exported.layout
        self.c.ccgen_shared_node_size.restype = ctypes.c_size_t
        self.state = ctypes.create_string_buffer(self.c.ccgen_shared_node_size())
        assert self.c.ccgen_shared_node_init(self.state) == 0
        self.integer = np.dtype(f"int{self.exported.joint.precision}")
        self.now = self.number = self.sent = 0
        self.heard = []

    def receive(self, message):
        return self.c.ccgen_shared_node_receive(
            self.state, message.arbitration_id, int(message.is_extended_id), int(message.is_fd),
            ctypes.c_size_t(len(message.data)), bytes(message.data), ctypes.c_uint32(self.now),
        )  # fmt: skip

    def fetch(self, at_most=1000):
        """Frames that are due, decoded; HEALTH goes to `heard` as well."""
        id_, flags, data = ctypes.c_uint32(), (ctypes.c_uint8 * 3)(), (ctypes.c_uint8 * 64)()
        parts = [ctypes.byref(flags, index) for index in range(3)]
        fetched = []
        while (
            len(fetched) < at_most
            and self.c.ccgen_shared_node_transmit(
                self.state, ctypes.c_uint32(self.now), ctypes.byref(id_), *parts, data
            )
            == 1
        ):
            message = can.Message(
                arbitration_id=id_.value, is_extended_id=bool(flags[0]), is_fd=bool(flags[1]),
                data=bytes(data[: flags[2]]),
            )  # fmt: skip
            decoded = self.codec.decode(message)
            assert decoded is not None
            fetched.append(decoded)
            if decoded.kind == "health":
                self.heard.append(health_of(decoded))
        return fetched

    def send(self, counts, after=CYCLE):
        """A snapshot; the answer's angles, or None."""
        self.now += after
        for message in self.codec.encode(list(counts), self.number % self.layout.numbers):
            self.receive(message)
        self.number += 1
        angles = [v for d in self.fetch() if d.kind == "angles" for v in d.values]
        return angles or None

    def command(self, number, command, snapshots=1, damage=0):
        """A COMMAND frame, and HEALTH in answer."""
        values = (number, command, snapshots)
        message = self.codec.encode_frame("command", 0, values, self.sent % 15)
        self.sent += 1
        message.data[3] ^= damage
        self.receive(message)
        return self.health()

    def health(self):
        """The latest HEALTH."""
        self.fetch()
        return self.heard[-1]

    def zero(self):
        """Read out by function, u then v."""
        counts = np.zeros(len(self.exported.joint.sensors), dtype=self.integer)
        assert self.c.zero_read(self.state, ctypes.c_void_p(counts.ctypes.data)) == 0
        return counts.tolist()

    def restore(self, counts):
        given = np.array(counts, dtype=self.integer)
        return self.c.zero_restore(self.state, ctypes.c_void_p(given.ctypes.data))


REST = (100, -50, 30, 20)


def test_health_comes_at_the_start_and_every_tenth_of_a_second():
    node = Node()
    counters = []
    for now in range(0, SECOND, 1000):
        node.now = now
        counters += [d.number for d in node.fetch() if d.kind == "health"]
    assert counters == list(range(10))
    own = node.exported.fingerprint & 0xFFFF
    assert set(node.heard) == {Health(own, 0, 2, 2, 3, FROM_MODEL, 0, NONE)}


def test_health_follows_the_axes_of_the_latest_snapshot():
    node = Node()
    node.send(REST)
    node.now += SECOND // 10
    assert (node.health().axis_u, node.health().axis_v, node.c.zero_axes(node.state)) == (0, 0, 0)
    for counts, state in (((-2001, 0, 0, 0), 1), ((-2001, 2001, 0, 0), 2), (REST, 0)):
        node.send(counts)
        node.now += SECOND // 10
        health, mask = node.health(), node.c.zero_axes(node.state)
        assert (mask & 3, mask >> 2 & 3) == (health.axis_u, health.axis_v) == (state, 0)


def test_a_health_that_could_not_be_sent_comes_again_under_its_counter():
    node = Node()
    first = next(d for d in node.fetch(at_most=1))
    assert first.kind == "health"
    assert node.c.ccgen_shared_node_unsent(node.state) == 1
    again = next(d for d in node.fetch() if d.kind == "health")
    assert again == first
    node.now += SECOND // 10
    assert next(d.number for d in node.fetch() if d.kind == "health") == first.number + 1


def test_an_answer_that_is_taken_back_before_the_first_health_takes_nothing_from_it():
    node, twin = Node(), Node()
    for one in (node, twin):
        for message in one.codec.encode(list(REST), 0):
            one.receive(message)
    expected = twin.fetch()
    assert {d.kind for d in expected} == {"angles", "tip", "status", "health"}
    first = node.fetch(at_most=1)
    assert first == expected[:1]
    assert node.c.ccgen_shared_node_unsent(node.state) == 1
    assert node.fetch() == expected


@pytest.mark.parametrize("turn", [2**32 + 2 * CYCLE, 2**32 + SECOND // 20])
def test_while_an_answer_is_taken_back_the_clock_may_come_round(turn):
    """What was due long ago is due, though the clock says that it was sent a moment ago."""
    node = Node()
    node.fetch()
    for message in node.codec.encode(list(REST), 0):
        node.receive(message)
    for now in (*range(0, turn, 2**30), turn):
        node.now = now
        assert node.fetch(at_most=1)[0].kind in {"angles", "status", "health"}
        assert node.c.ccgen_shared_node_unsent(node.state) == 1
    kinds = [d.kind for d in node.fetch()]
    assert {"status", "health"} <= set(kinds)


def test_an_answer_that_is_taken_back_brings_no_health_of_its_own():
    node = Node()
    node.fetch()
    for message in node.codec.encode(list(REST), 0):
        node.receive(message)
    first = node.fetch(at_most=1)
    assert node.c.ccgen_shared_node_unsent(node.state) == 1
    again = node.fetch()
    assert again[:1] == first
    assert "health" not in {d.kind for d in again}


def test_the_next_snapshots_become_the_zero_and_the_answer_to_the_last_has_it_already():
    node = Node()
    model = node.exported.model
    before = node.send(REST)
    assert before == model.estimate(REST).tolist()
    assert node.command(5, CAPTURE, snapshots=4).result == BUSY
    readings = [(100, -50, 30, 20), (101, -51, 33, 20), (102, -52, 30, 20), (103, -53, 31, 20)]
    for counts in readings[:3]:
        assert node.send(counts) == model.estimate(counts).tolist()
    assert node.zero() == model.readings.zero.tolist()
    zero = [102, -52, 31, 20]
    assert node.send(readings[3]) == model.estimate(readings[3], zero).tolist()
    health = node.health()
    assert (health.last_command, health.result, health.zero) == (5, DONE, CAPTURED)
    assert node.zero() == zero
    assert node.send((7, 8, 9, 10)) == model.estimate((7, 8, 9, 10), zero).tolist()


def test_a_repeated_number_acts_once_and_is_acknowledged_again():
    node = Node()
    node.command(9, CAPTURE)
    node.send(REST)
    assert node.zero() == list(REST)
    node.send((0, 0, 0, 0))
    heard = len(node.heard)
    for kind in (CAPTURE, MODEL, 7):
        assert node.command(9, kind).result == DONE
    assert len(node.heard) == heard + 3
    node.send((0, 0, 0, 0))
    assert node.zero() == list(REST)


def test_the_first_command_acts_whatever_its_number():
    for number in (0, 15):
        node = Node()
        assert node.command(number, MODEL).result == DONE
        assert node.heard[-1].last_command == number


@pytest.mark.parametrize("seen", [0, 1, 3])
def test_a_capture_fails_a_second_after_the_last_complete_snapshot(seen):
    node = Node()
    node.send((5, 5, 5, 5))
    node.command(1, CAPTURE, snapshots=4)
    for _ in range(seen):
        node.send((5, 5, 5, 5))
    node.now += SECOND
    assert node.health().result == BUSY
    node.now += 1
    assert node.health().result == SILENCE
    node.send((5, 5, 5, 5))
    assert (node.health().result, node.zero()) == (SILENCE, [0, 0, 0, 0])


def test_a_snapshot_that_comes_after_the_second_does_not_save_the_capture():
    node = Node()
    node.command(1, CAPTURE)
    node.send(REST, after=SECOND + 1)
    assert (node.health().result, node.zero()) == (SILENCE, [0, 0, 0, 0])


def test_snapshots_without_a_reading_of_some_sensor_do_not_count():
    node = Node()
    node.command(1, CAPTURE, snapshots=2)
    for counts in (REST, (2001, 0, 0, 0), (-(2**15), 0, 0, 0), REST):
        assert node.health().result == BUSY
        node.send(counts)
    assert (node.health().result, node.zero()) == (DONE, list(REST))


@pytest.mark.parametrize("sensor", range(4))
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_joint_that_moves_is_refused(sensor, sign):
    # Noise of 2 counts and a twelfth: six deviations of a difference, and one count.
    still = 19
    for step, result in ((still, DONE), (still + 1, MOVING)):
        node = Node()
        moved = list(REST)
        moved[sensor] += sign * step
        node.command(1, CAPTURE, snapshots=2)
        node.send(REST)
        node.send(moved)
        assert node.health().result == result


@pytest.mark.parametrize("end", [-1, 1])
def test_from_one_end_of_32_bits_to_the_other_is_far(end):
    node = Node(WIDEST)
    node.command(1, CAPTURE, snapshots=2)
    for reading in (end * LAST, -end * LAST):
        node.send((reading, 0, 0, 0))
    assert node.health().result == MOVING


def test_the_snapshot_before_the_command_shows_a_movement_too_where_it_is_fresh():
    for silence, result in ((0, MOVING), (5 * CYCLE, DONE)):
        node = Node()
        node.send((500, 0, 0, 0))
        node.now += silence
        node.command(1, CAPTURE)
        node.send(REST)
        assert node.health().result == result


def test_back_to_the_zero_of_the_model():
    node = Node()
    node.command(1, CAPTURE)
    node.send(REST)
    health = node.command(2, MODEL)
    assert (health.result, health.zero) == (DONE, FROM_MODEL)
    assert node.zero() == node.exported.model.readings.zero.tolist()


def test_back_to_the_zero_that_was_restored_last():
    node = Node()
    health = node.command(1, RESTORED)
    assert (health.result, health.zero, node.zero()) == (NOTHING, FROM_MODEL, [0, 0, 0, 0])
    assert node.restore((1, 2, 3, 4)) == 0
    assert node.restore((2001, 0, 0, 0)) < 0
    node.command(2, CAPTURE)
    node.send(REST)
    assert node.zero() == list(REST)
    health = node.command(3, RESTORED)
    assert (health.result, health.zero, node.zero()) == (DONE, FROM_RESTORED, [1, 2, 3, 4])


def test_a_capture_knows_nothing_of_the_one_before_it():
    node, moved = Node(), tuple(count + 4 for count in REST)
    node.command(1, CAPTURE, snapshots=3)
    node.send(REST)
    node.send(moved)
    for number in (2, 3):  # the first was ended, the second is done
        node.command(number, CAPTURE, snapshots=2)
        node.send(moved)
        assert node.health().result == BUSY
        node.send(moved)
        assert (node.health().result, node.zero()) == (DONE, list(moved))
    node.now += 5 * CYCLE
    node.command(4, CAPTURE)
    far = tuple(count + 100 for count in REST)
    node.send(far)
    assert (node.health().result, node.zero()) == (DONE, list(far))


def test_a_reading_out_of_its_range_is_not_where_a_capture_begins():
    node = Node()
    node.send((2001, 500, 0, 0))
    node.command(1, CAPTURE)
    node.send(REST)
    assert (node.health().result, node.zero()) == (DONE, list(REST))


@pytest.mark.parametrize("commands", [False, True])
def test_a_command_is_one_where_the_layout_has_commands(commands):
    layout = completed(CLASSIC, commands=commands)
    index = 3 + 8 + 3  # behind lengths, angles, tip, status, health
    sent = Frame()
    load().ccgen_layout_begin(ctypes.byref(layout), ctypes.c_uint16(index), ctypes.byref(sent))
    assert (
        load().ccgen_layout_protect(ctypes.byref(layout), ctypes.c_uint8(3), ctypes.byref(sent))
        == 0
    )
    assert load().ccgen_command_is(ctypes.byref(layout), ctypes.byref(sent)) == commands
    for damage in ("data", "length", "id"):
        spoilt = Frame.from_buffer_copy(sent)
        if damage == "data":
            spoilt.data[4] ^= 1
        else:
            setattr(spoilt, damage, getattr(spoilt, damage) - 1)
        assert not load().ccgen_command_is(ctypes.byref(layout), ctypes.byref(spoilt))


def test_a_new_command_ends_a_capture():
    node = Node()
    for kind, result in ((MODEL, DONE), (RESTORED, NOTHING), (9, UNKNOWN), (CAPTURE, BUSY)):
        node.command(1, CAPTURE, snapshots=3)
        node.send(REST)
        assert node.command(2, kind, snapshots=3).result == result
        for _ in range(2):
            node.send((9, 9, 9, 9))
        assert node.zero() == [0, 0, 0, 0]


@pytest.mark.parametrize(("command", "snapshots"), [(0, 1), (4, 1), (15, 1), (CAPTURE, 0)])
def test_what_is_no_command_is_said_and_changes_nothing(command, snapshots):
    node = Node()
    assert node.command(3, command, snapshots).result == UNKNOWN
    node.send(REST)
    assert node.zero() == [0, 0, 0, 0]


def test_a_damaged_command_is_not_heard():
    node = Node()
    node.fetch()
    heard = len(node.heard)
    node.command(3, CAPTURE, damage=1)
    assert (len(node.heard), node.heard[-1].result) == (heard, NONE)


def test_a_joint_without_commands_obeys_none():
    commanded, _ = exported_from(TEXT)
    message = commanded.codec.encode_frame("command", 0, (1, CAPTURE, 1), 0)
    node = Node(TEXT.replace("commands = true", "") + "base_id = 0x300\n")
    node.receive(message)
    node.send(REST)
    assert (node.health().result, node.zero()) == (NONE, [0, 0, 0, 0])


@pytest.mark.parametrize("text", [TEXT, WIDE])
@given(
    data=st.data(),
    centre=st.integers(-2000, 2000),
    snapshots=st.sampled_from((1, 2, 3, 10, 255)),
)
@settings(max_examples=12)
def test_the_captured_zero_is_the_mean_to_the_nearest_halves_away_from_the_first(
    text, data, centre, snapshots
):
    node = Node(text)
    zeros = node.exported.model.readings.zeros
    base = np.array([centre, -centre, centre // 2, 0])
    if text is WIDE:
        base = np.array([zeros.maximum[0], zeros.minimum[1], centre, 7 * centre])
    base = np.clip(base, zeros.minimum + 9, zeros.maximum - 9)
    seed = data.draw(st.integers(0, 2**32 - 1))
    readings = base + np.random.default_rng(seed).integers(-9, 10, (snapshots, 4))
    node.command(1, CAPTURE, snapshots)
    for counts in readings.tolist():
        node.send(counts)
    away = (readings - readings[0]).sum(axis=0)
    half = snapshots // 2
    mean = np.where(away >= 0, (away + half) // snapshots, -((half - away) // snapshots))
    assert node.health().result == DONE
    assert node.zero() == (readings[0] + mean).tolist()


@pytest.mark.parametrize("published", [[], ["tip"], ["angles", "health"], ["status"], ["health"]])
def test_a_node_sends_what_its_joint_publishes_and_nothing_is_overrun(published):
    listed = ", ".join(f'"{kind}"' for kind in published)
    node = Node(TEXT.replace("commands = true", f"publish = [{listed}]"))
    kinds = []
    for _ in range(30):
        node.now += CYCLE
        for message in node.codec.encode([0] * 4, node.number % 240):
            node.receive(message)
        node.number += 1
        kinds += [d.kind for d in node.fetch()]
    assert set(kinds) == set(published)
    per_snapshot = {"tip": 1, "status": 1, "angles": 2}
    for kind in set(published) & set(per_snapshot):
        assert kinds.count(kind) == 30 * per_snapshot[kind]
    counters = (ctypes.c_uint32 * 10)()
    assert node.c.ccgen_shared_node_counters(node.state, counters) == 0
    assert counters[9] == 0


def test_can_fd_carries_commands_and_switches_the_rate():
    node = Node(FD)
    assert node.codec.encode_frame("command", 0, (1, CAPTURE, 1), 0).bitrate_switch
    node.command(1, CAPTURE)
    node.send(REST)
    assert (node.health().result, node.zero()) == (DONE, list(REST))


def test_the_fingerprint_is_of_numbers_and_not_of_names():
    own = exported_from(TEXT)[0].fingerprint
    header = (exported_from(TEXT)[0].directory / "src" / "elbow.h").read_text(encoding="utf-8")
    assert f"#define ELBOW_FINGERPRINT UINT32_C(0x{own:08X})" in header
    other = parse_joint(TEXT.replace('"elbow"', '"knee"'), "knee.toml")
    assert (
        open_exported(export(other, _FOLDERS.mktemp("knee") / "knee").directory).fingerprint == own
    )
    moved = parse_joint(TEXT.replace("radius = 0.02", "radius = 0.0201"), "elbow.toml")
    changed = export(moved, _FOLDERS.mktemp("moved") / "elbow").directory
    assert open_exported(changed).fingerprint != own
