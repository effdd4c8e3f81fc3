"""The ports as programs: SLCAN over pipes and pseudo-terminals, and SocketCAN's frames."""

import os
import pty
import select
import signal
import socket
import struct
import subprocess
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from runtime_c import ADDRESS, GLUE, HERE, RUNTIME, SAMPLE, build_program, compile_c
from test_runtime_estimator import sample_model
from waiting import PATIENCE, becomes, read_until

from ccgen.e2e import P01

COUNTS = (100, -200, 300, 4000, -5000, 6000)
ANSWER = 10  # 8 ANGLES, TIP, STATUS
OPEN = b"C\rS8\r\rO\r"
CYCLE_MS = 10
AGE, OLDEST = 7, 255  # of the latest snapshot: its place in STATUS, milliseconds at most
PATIENT = ("--patient",)  # a loaded machine may pause this test between two frames


def lengths(number: int, counts: tuple[int, ...] = COUNTS) -> list[tuple[int, bytes]]:
    """The two LENGTHS frames of a snapshot."""
    body, (turn, counter) = np.array(counts, "<i2").tobytes(), divmod(number % 240, 15)
    halves = ((0x300, body[:6]), (0x301, body[6:]))
    header = bytes((0, turn << 4))
    return [(id_, P01.protect(id_, counter, header + half)) for id_, half in halves]


def line(id_: int, data: bytes) -> bytes:
    return b"t%03X%d" % (id_, len(data)) + data.hex().encode() + b"\r"


def snapshot(number: int) -> bytes:
    return b"".join(line(*sent) for sent in lengths(number))


def frames_in(output: bytes) -> list[tuple[int, bytes]]:
    """Frames of whole lines, each with a check value that holds."""
    found = []
    for text in output.split(b"\r")[:-1]:
        if text.startswith(b"t"):
            id_, data = int(text[1:4], 16), bytes.fromhex(text[5:].decode())
            assert len(data) == int(text[4:5]) == 8
            P01.check(id_, data)
            found.append((id_, data))
    return found


def answers_in(output: bytes) -> list[list[int]]:
    """Angles of every snapshot that was answered, in order."""
    answers, current = [], b""
    for id_, data in frames_in(output):
        if 0x302 <= id_ < 0x30A:
            assert len(current) == 6 * (id_ - 0x302), "ANGLES frames out of order"
            current += data[2:]
        if id_ == 0x30A:
            answers.append(np.frombuffer(current, "<i2").tolist())
            current = b""
    return answers


def expected() -> list[int]:
    u, v = sample_model(0), sample_model(1)
    return [*u.estimate(COUNTS[:3]).tolist(), *v.estimate(COUNTS[3:]).tolist()]


def run(*arguments: str, stdin: bytes = b"", flags: tuple[str, ...] = ("-O2",)):
    program = build_program("posix", flags)
    return subprocess.run(
        [program, *arguments], input=stdin, capture_output=True, timeout=PATIENCE, check=False
    )


def read_answer(fd: int) -> bytes:
    """Whole lines up to a TIP frame, and what comes with it."""
    return read_until(fd, lambda data: b"t30A8" in data and data.endswith(b"\r"))


@contextmanager
def process(program: Path, *arguments: str, keep: tuple[int, ...] = (), **options: object):
    """The program, gone for certain afterwards."""
    running = subprocess.Popen(
        [program, *arguments], pass_fds=keep, stderr=subprocess.PIPE, **options
    )
    try:
        yield running
    finally:
        running.kill()
        running.wait()
        running.stderr.close()


@contextmanager
def on_pseudo_terminal(*arguments: str) -> Iterator[tuple[int, subprocess.Popen[bytes]]]:
    """The node on the far end of a pseudo-terminal, as a serial device; gives the near end."""
    near, far = pty.openpty()
    try:
        tty.setraw(far)  # no echo before the node has set it
        with process(build_program("posix"), os.ttyname(far), *arguments) as running:
            os.write(near, OPEN)
            assert read_until(near, lambda said: len(said) >= 4).startswith(b"\r" * 4)
            yield near, running
    finally:
        os.close(near)
        os.close(far)


def test_a_script_on_standard_input_is_answered_to_its_end():
    script = OPEN + b"".join(snapshot(k) for k in range(15)) + b"V\r"
    done = run(*PATIENT, stdin=script)
    assert (done.returncode, done.stderr) == (0, b"")
    assert answers_in(done.stdout) == [expected()] * 15
    assert done.stdout.endswith(b"V0101\r")


def test_a_closed_channel_carries_no_frames():
    done = run(stdin=b"V\r" + snapshot(0))
    assert done.stdout == b"V0101\r\a\a"


def test_answers_follow_their_snapshot_on_a_pseudo_terminal():
    with on_pseudo_terminal(*PATIENT) as (near, _):
        for k in range(30):
            os.write(near, snapshot(k))
            assert answers_in(read_answer(near)) == [expected()]


def test_the_node_puts_its_terminal_into_raw_mode():
    near, far = pty.openpty()
    try:
        assert os.isatty(far)
        with process(build_program("posix"), os.ttyname(far)):
            assert becomes(lambda: not termios.tcgetattr(far)[3] & termios.ICANON)
            # Cooked, the terminal would echo the line and turn CR into LF.
            os.write(near, b"N\r")
            assert read_until(near, lambda said: len(said) >= 6) == b"NCCGN\r"
    finally:
        os.close(near)
        os.close(far)


def test_hanging_up_ends_the_process_cleanly():
    near, far = pty.openpty()
    tty.setraw(far)
    with process(build_program("posix"), "--fd", str(near), keep=(near,)) as running:
        os.close(near)
        os.write(far, b"V\r")
        assert read_until(far, lambda said: len(said) >= 6) == b"V0101\r"
        os.close(far)
        assert running.wait(PATIENCE) == 0
        assert running.stderr.read() == b""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_the_process_cleanly(number):
    with on_pseudo_terminal() as (_, running):
        running.send_signal(number)
        assert running.wait(PATIENCE) == 0


def statuses_in(output: bytes) -> list[bytes]:
    return [data for id_, data in frames_in(output) if id_ == 0x30B]


def none_is_missing(statuses: list[bytes]) -> bool:
    return {((b[1] & 0x0F) - (a[1] & 0x0F)) % 15 for a, b in pairwise(statuses)} == {1}


def test_status_comes_every_cycle_while_the_channel_is_open():
    """By the node's own clock: the age that a status tells of the snapshot before."""

    def aged(output: bytes) -> bool:
        return b"t30A8" in output and statuses_in(output)[-1][AGE] == OLDEST

    output, steps, deadline, number = b"", [], time.monotonic() + PATIENCE, 0
    with on_pseudo_terminal("--window-ms", "1000") as (near, _):
        # A busy machine delays most of them, but never all, and brings none forward.
        while min(steps, default=OLDEST) > 1.5 * CYCLE_MS:
            assert time.monotonic() < deadline, steps
            os.write(near, snapshot(number))
            number += 1
            output += read_until(near, aged)
            ages = [data[AGE] for data in statuses_in(output)]
            steps = [b - a for a, b in pairwise(ages) if a < b < OLDEST]
    assert min(steps) >= CYCLE_MS - 1
    assert none_is_missing(statuses_in(output))


def write_until_stalled(fd: int, data: bytes) -> int:
    """Bytes that the other end took before it took none for a fifth of a second."""
    os.set_blocking(fd, False)
    sent = 0
    while sent < len(data) and select.select([], [fd], [], 0.2)[1]:
        sent += os.write(fd, data[sent : sent + 4096])
    return sent


def exchange(fd: int, data: bytes, answers: int) -> bytes:
    """Send the rest and read until so many snapshots are answered, or nothing goes any more."""
    output, answered, sent = bytearray(), 0, 0
    while answered < answers:
        writers = [fd] if sent < len(data) else []
        readable, writable, _ = select.select([fd], writers, [], PATIENCE)
        if readable:
            seen = max(0, len(output) - 4)
            output += os.read(fd, 1 << 16)
            answered += output.count(b"t30A8", seen)
        elif writable:
            sent += os.write(fd, data[sent : sent + 4096])
        else:
            break
    return bytes(output) + read_until(fd, lambda rest: b"\r" in rest)


def test_a_host_that_does_not_listen_loses_nothing():
    """It sends until the line stalls, far beyond what the buffers hold, and only then reads."""
    total = 4000
    data = b"".join(snapshot(k) for k in range(total))
    with on_pseudo_terminal(*PATIENT) as (near, running):
        sent = write_until_stalled(near, data)
        assert 0 < sent < len(data)
        output = exchange(near, data[sent:], total)
        assert running.poll() is None
    assert answers_in(output) == [expected()] * total
    assert b"\a" not in output
    assert none_is_missing(statuses_in(output))


def test_garbage_under_the_sanitizers_neither_ends_nor_confuses_it():
    draw = np.random.default_rng(11)
    alphabet = np.frombuffer(b"tTrRdDbBOCLSVNZF0123456789abcdef\r\r\r\n\x00\xff~", np.uint8)
    noise = b"\r".join(draw.choice(alphabet, draw.integers(0, 300)).tobytes() for _ in range(2000))
    raw = draw.integers(0, 256, 50_000, dtype=np.uint8).tobytes()
    script = OPEN + noise + raw + b"\r" * 2 + OPEN + snapshot(3)
    done = run(*PATIENT, stdin=script, flags=("-O0", *ADDRESS))
    assert (done.returncode, done.stderr) == (0, b"")
    assert answers_in(done.stdout)[-1] == expected()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--fd",), "--fd"), (("--fd", "x"), "--fd"), (("--fd", "-1"), "--fd"),
        (("--window-ms", "0"), "--window-ms"), (("--window-ms", "1x"), "--window-ms"),
        (("--window-ms", "1001"), "--window-ms needs 1 to 1000"),
        (("--unknown",), "--unknown"), (("/dev/null", "/dev/zero"), "/dev/zero"),
        (("/nowhere/tty",), "No such file"), (("/dev/null",), "terminal"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_said_in_one_line(arguments, word):
    done = run(*arguments)
    assert done.returncode == 2
    assert word in done.stderr.decode()
    assert done.stderr.count(b"\n") == 1
    assert done.stdout == b""


def test_a_descriptor_that_is_not_open_is_an_error_of_the_line():
    done = run("--fd", "77")
    assert done.returncode == 1
    assert b"Bad file descriptor" in done.stderr


def test_help_is_on_standard_output():
    done = run("--help")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"--window-ms" in done.stdout
    assert b"--patient" in done.stdout


def test_a_patient_node_leaves_a_held_up_sender_its_time():
    """1.2 seconds are past the widest window by the machine's clock, and 12 cycles by its own."""
    with on_pseudo_terminal(*PATIENT) as (near, _):
        first, second = (line(*sent) for sent in lengths(0))
        os.write(near, first)
        time.sleep(1.2)
        os.write(near, second)
        assert answers_in(read_answer(near)) == [expected()]


def wire(id_: int, data: bytes, fd: bool = False) -> bytes:
    """A frame as SocketCAN lays it out."""
    return struct.pack("=IB3x", id_, len(data)) + data.ljust(64 if fd else 8, b"\0")


@cache
def build_driver(*flags: str) -> Path:
    """The SocketCAN port behind the opening of an interface."""
    files = (*RUNTIME, *GLUE, SAMPLE / "sample.c", HERE / "socketcan_driver.c")
    return compile_c(files, ("-O0", *ADDRESS, *flags))


@contextmanager
def on_socket(*flags: str) -> Iterator[tuple[socket.socket, subprocess.Popen[bytes]]]:
    """The SocketCAN port's loop, on one end of a socket that keeps messages apart."""
    program = build_driver(*flags)
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with near, far, process(program, str(far.fileno()), keep=(far.fileno(),)) as running:
        near.settimeout(PATIENCE)
        yield near, running


def receive_answer(near: socket.socket, tip: int) -> list[tuple[int, bytes]]:
    """Frames up to the TIP frame, without STATUS."""
    got: list[tuple[int, bytes]] = []
    deadline = time.monotonic() + PATIENCE
    while not got or got[-1][0] != tip:
        assert time.monotonic() < deadline, f"nothing but {got} and statuses"
        message = near.recv(100)
        id_, length = struct.unpack_from("=IB", message)
        if id_ != tip + 1:
            got.append((id_, message[8 : 8 + length]))
    return got


def test_socketcan_frames_are_answered():
    with on_socket() as (near, running):
        for k in range(20):
            for sent in lengths(k):
                near.send(wire(*sent))
            got = receive_answer(near, 0x30A)
            assert [id_ for id_, _ in got] == list(range(0x302, 0x30B))
            body = b"".join(data[2:] for _, data in got[:8])
            assert np.frombuffer(body, "<i2").tolist() == expected()
        running.send_signal(signal.SIGTERM)
        assert running.wait(PATIENCE) == 0
        assert running.stderr.read() == b""


def test_socketcan_ignores_what_is_no_frame():
    error = 0x20000000
    with on_socket() as (near, _):
        near.send(b"short")
        near.send(wire(0x300 | error, bytes(8)))
        near.send(struct.pack("=IB3x", 0x300, 99) + bytes(8))
        for sent in lengths(4):
            near.send(wire(*sent))
        assert len(receive_answer(near, 0x30A)) == 9


def test_socketcan_carries_can_fd():
    from ccgen.e2e import P05

    data = P05.protect(0x300, 77, bytes(3) + np.array(COUNTS, "<i2").tobytes() + bytes(1))
    with on_socket("-DSAMPLE_FD=1") as (near, _):
        near.send(wire(0x300, data, fd=True))
        (angles_id, angles), (tip_id, tip) = receive_answer(near, 0x302)
        assert (angles_id, tip_id, len(angles), len(tip)) == (0x301, 0x302, 64, 12)
        assert (P05.check(angles_id, angles), P05.check(tip_id, tip)) == (77, 77)
        assert np.frombuffer(angles[3:51], "<i2").tolist() == expected()


def socketcan(*arguments: str) -> subprocess.CompletedProcess[bytes]:
    program = build_program("socketcan")
    return subprocess.run([program, *arguments], capture_output=True, timeout=PATIENCE, check=False)


@pytest.mark.parametrize(
    "window",
    [(), ("--window-ms", "1"), ("--window-ms", "1000"), PATIENT],
)
def test_socketcan_names_an_interface_that_is_not_there(window):
    done = socketcan(*window, "vcan_none")
    assert done.returncode == 2
    assert done.stderr.startswith(b"vcan_none: cannot be opened:")


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ((), "INTERFACE"), (("-x",), "INTERFACE"), (("can0", "can1"), "INTERFACE"),
        (("--window-ms", "5"), "INTERFACE"), (("--window-ms",), "--window-ms"),
        (("--window-ms", "0", "can0"), "--window-ms"),
        (("--window-ms", "1001", "can0"), "--window-ms needs 1 to 1000"),
        (("--patient",), "INTERFACE"), (("--window-ms", "9", "--patient"), "INTERFACE"),
        (("--window-ms", "1x", "can0"), "--window-ms"), (("--window-ms", "", "x"), "--window-ms"),
    ],
)  # fmt: skip
def test_socketcan_says_wrong_arguments_in_one_line(arguments, word):
    done = socketcan(*arguments)
    assert done.returncode == 2
    assert word in done.stderr.decode()
    assert done.stderr.count(b"\n") == 1
    assert done.stdout == b""


def test_socketcan_has_its_help_on_standard_output():
    done = socketcan("--help")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"--window-ms" in done.stdout
