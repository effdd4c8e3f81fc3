"""The SLCAN bus that reads in blocks, and processes that speak SLCAN on a pseudo-terminal."""

import os
import sys
import time
import tty
from contextlib import suppress
from pathlib import Path

import can
import pytest
from processes import children
from waiting import PATIENCE, read_until

from ccgen.can.layout import FrameLayout
from ccgen.can.transports import process
from ccgen.can.transports.interface import interface_node
from ccgen.can.transports.process import process_node
from ccgen.can.transports.slcan import BlockSlcanBus
from ccgen.errors import InputError, ToolError

SENSORS = ("u0", "u1", "u2", "v0", "v1", "v2")
LAYOUT = FrameLayout("shoulder", 0x300, False, False, SENSORS, (12, 12, 0), 2, 2, 10, 17)

ECHO = """
import os
rest = b""
while True:
    try:
        data = os.read(0, 65536)
    except OSError:
        break
    if not data:
        break
    *lines, rest = (rest + data).split(b"\\r")
    for line in lines:
        os.write(1, line + b"\\rz\\r" if line[:1] in b"tTdDbBrR" and line else b"\\r")
"""


@pytest.fixture
def line():
    """The far end of a line as a file descriptor, and the bus on the near end."""
    far, near = os.openpty()
    tty.setraw(near)
    bus = BlockSlcanBus(os.ttyname(near))
    read_until(far, lambda said: said.endswith(b"O\r"))
    yield far, bus
    bus.shutdown()
    os.close(near)
    os.close(far)


@pytest.fixture
def program(tmp_path):
    def write(text):
        path = tmp_path / "node"
        path.write_text(f"#!{sys.executable}\n{text}", encoding="utf-8")
        path.chmod(0o755)
        return path

    return write


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (can.Message(arbitration_id=0x300, is_extended_id=False, data=b"\1\xff"), b"t300201FF\r"),
        (can.Message(arbitration_id=0x18FF0301, data=b""), b"T18FF03010\r"),
        (
            can.Message(arbitration_id=0x7FF, is_extended_id=False, is_fd=True, data=bytes(64)),
            b"d7FFF" + b"00" * 64 + b"\r",
        ),
        (
            can.Message(arbitration_id=5, is_extended_id=False, is_remote_frame=True, dlc=8),
            b"r0058\r",
        ),
    ],
)
def test_frames_take_the_form_of_a_line_both_ways(line, message, text):
    far, bus = line
    bus.send(message, timeout=PATIENCE)
    assert read_until(far, lambda sent: len(sent) >= len(text)) == text
    os.write(far, b"\rz\r" + text)
    received = bus.recv(PATIENCE)
    assert received.equals(message, timestamp_delta=None, check_direction=False)


def test_several_frames_leave_in_one_write(line):
    far, bus = line
    frames = [can.Message(arbitration_id=k, is_extended_id=False, data=[k]) for k in (1, 2, 3)]
    bus.send_all(frames, timeout=PATIENCE)
    text = b"t001101\rt002102\rt003103\r"
    assert read_until(far, lambda sent: len(sent) >= len(text)) == text


def test_lines_may_arrive_in_pieces(line):
    far, bus = line
    for piece in (b"t3", b"002", b"01F", b"F\rt301", b"0\r"):
        os.write(far, piece)
        time.sleep(0.002)
    assert bytes(bus.recv(PATIENCE).data) == b"\1\xff"
    assert bus.recv(PATIENCE).arbitration_id == 0x301


def test_a_malformed_line_is_counted_and_the_next_frame_still_comes(line):
    far, bus = line
    os.write(far, b"t3zz1\rT12\rt300401\xc3\x28\rt3010\r")
    assert bus.recv(PATIENCE).arbitration_id == 0x301
    assert bus.malformed_lines == 3


def test_refusals_are_counted(line):
    far, bus = line
    os.write(far, b"\a\at3010\r")
    assert bus.recv(PATIENCE).arbitration_id == 0x301
    assert bus.refused_lines == 2


def test_waiting_ends_with_the_time_out(line):
    _, bus = line
    begin = time.monotonic()
    assert bus.recv(0.05) is None
    assert time.monotonic() - begin < 10.0


def test_a_full_line_ends_the_send_with_an_error(line):
    _, bus = line
    frame = can.Message(arbitration_id=1, is_extended_id=False, data=bytes(8))

    def fill():
        for _ in range(200):
            bus.send_all([frame] * 50, timeout=0.05)

    with pytest.raises(can.CanOperationError):
        fill()


def test_a_line_that_is_gone_ends_the_send_with_the_same_error():
    far, near = os.openpty()
    bus = BlockSlcanBus(os.ttyname(near))
    os.close(far)
    with pytest.raises(can.CanOperationError):
        bus.send(can.Message(arbitration_id=1), timeout=0.5)
    bus.shutdown()
    os.close(near)


def test_a_process_receives_and_answers(program):
    with process_node(program(ECHO)) as bus:
        for number in range(50):
            frame = can.Message(arbitration_id=number, is_extended_id=False, data=[number])
            bus.send(frame, timeout=PATIENCE)
            assert bus.recv(PATIENCE).arbitration_id == number


def test_a_process_is_given_time_for_a_snapshot_that_a_busy_machine_may_need(program):
    tell = "import sys\nsys.stdin.read(1)\nsys.exit(str(sys.argv[1:]))"
    with pytest.raises(ToolError, match=r"\['--patient'\]"), process_node(program(tell)):
        pass


def test_a_process_that_fails_says_why(program):
    failing = program("import sys\nsys.stdin.read(1)\nsys.exit('no such luck')")

    def listen():
        with process_node(failing) as bus, suppress(can.CanOperationError):
            while True:
                bus.recv(0.1)

    with pytest.raises(ToolError, match="ended with status 1: no such luck"):
        listen()


def test_a_process_that_does_not_end_is_ended(program, monkeypatch):
    monkeypatch.setattr(process, "_GRACE", 0.1)
    before = children()
    with process_node(program("import time\ntime.sleep(100)")):
        assert len(children() - before) == 1
    assert children() <= before


def test_a_program_that_cannot_run_is_named(tmp_path):
    with pytest.raises(ToolError, match="does not start as a node"), process_node(tmp_path / "no"):
        pass


def open_files():
    """Descriptors and what they are open for; not the one that lists them, closed by then."""
    found = set()
    for descriptor in Path("/proc/self/fd").iterdir():
        with suppress(FileNotFoundError):
            found.add((descriptor.name, descriptor.readlink()))
    return found


def test_an_error_in_the_block_still_ends_the_process(program):
    files, processes = open_files(), children()
    with pytest.raises(RuntimeError, match="mine"), process_node(program(ECHO)):
        raise RuntimeError("mine")
    assert children() <= processes
    assert open_files() <= files


def test_an_interface_that_does_not_open_is_bad_input():
    with (
        pytest.raises(InputError, match="interface: slcan /dev/nowhere cannot be opened"),
        interface_node(LAYOUT, "slcan", "/dev/nowhere"),
    ):
        pass
    with (
        pytest.raises(InputError, match="interface: pigeon cannot be opened"),
        interface_node(LAYOUT, "pigeon"),
    ):
        pass
    with (
        pytest.raises(InputError, match="name a serial device as channel"),
        interface_node(LAYOUT, "slcan"),
    ):
        pass


def test_an_interface_lets_the_joints_frames_through_and_not_others(request):
    with (
        interface_node(LAYOUT, "virtual", request.node.name) as bus,
        can.Bus(interface="virtual", channel=request.node.name) as other,
    ):
        for number in (0x2FF, 0x300, 0x30B, 0x310, 0x7FF):
            other.send(can.Message(arbitration_id=number, is_extended_id=False))
        received = [bus.recv(0.1) for _ in range(3)]
    assert [m and m.arbitration_id for m in received] == [0x300, 0x30B, None]
