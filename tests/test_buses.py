"""Buses as they are: adapters of all manners, drivers that are missing, plugs that are pulled."""

import json
import logging
import os
import select
import subprocess
import sys
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import can
import pytest
from waiting import PATIENCE

from ccgen.can.layout import FrameLayout
from ccgen.can.transports.interface import interface_node
from ccgen.can.transports.slcan import BlockSlcanBus
from ccgen.cli.main import main
from ccgen.errors import InputError
from ccgen.export.package import export
from ccgen.targets.host import compile_process

SHOULDER = Path(__file__).resolve().parent.parent / "examples" / "shoulder.toml"
SENSORS = ("u0", "u1", "u2", "v0", "v1", "v2")
LAYOUT = FrameLayout("shoulder", 0x300, False, False, SENSORS, (12, 12, 0), 2, 2, 10, 17)


def ccgen(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("buses") / "shoulder"
    export(SHOULDER, directory)
    return directory


@pytest.fixture(scope="module")
def program(folder):
    return compile_process(folder, folder.parent)


@contextmanager
def adapter(
    program: Path, spoil=lambda data: data, pulled_after: int | None = None
) -> Iterator[str]:
    """A device whose other end is the node; what the node says passes through `spoil`.

    Args:
        program: the node's.
        spoil: what becomes of a block of the node's bytes.
        pulled_after: frames from the node after which the plug is pulled.
    """
    far, near = os.openpty()
    tty.setraw(near)
    node = subprocess.Popen(
        [program, "--window-ms", "1000"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert node.stdin is not None
    assert node.stdout is not None

    pulled = threading.Event()

    def to_node() -> None:
        with suppress(OSError, ValueError):
            while not pulled.is_set():
                if select.select([far], [], [], 0.02)[0]:
                    os.write(node.stdin.fileno(), os.read(far, 65536))

    def from_node() -> None:
        frames = 0
        while data := os.read(node.stdout.fileno(), 65536):
            os.write(far, spoil(data))
            frames += data.count(b"t")
            if pulled_after is not None and frames > pulled_after:
                break
        # Closed where nobody reads any more: the number may be another file's at once.
        pulled.set()
        reader.join()
        os.close(far)

    reader, writer = (threading.Thread(target=move, daemon=True) for move in (to_node, from_node))
    reader.start()
    writer.start()
    try:
        yield os.ttyname(near)
    finally:
        node.terminate()
        writer.join(PATIENCE)
        node.communicate(timeout=PATIENCE)
        os.close(near)


@pytest.mark.parametrize("end", [b"\r\n", b"\n", b"\n\r"])
def test_an_adapter_may_end_its_lines_as_it_likes(folder, program, capsys, end):
    with adapter(program, lambda data: data.replace(b"\r", end)) as device:
        words = ("--interface", "slcan", "--channel", device, "--seconds", "0.3", "--json")
        assert ccgen("bridge", str(folder), *words) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["answered"], record["snapshots"]) == (30, 30)
    assert (record["lost_frames"], record["corrupted"]) == (0, 0)


def test_lines_that_come_in_pieces_are_put_together():
    far, near = os.openpty()
    tty.setraw(near)
    with BlockSlcanBus(os.ttyname(near)) as bus:
        for piece in (b"z\r", b"\nt12", b"3155\r", b"\n", b"\r\nt1", b"24166\r\n"):
            os.write(far, piece)
        received = [bus.recv(PATIENCE) for _ in range(2)]
    assert [(m.arbitration_id, bytes(m.data)) for m in received if m] == [
        (0x123, b"\x55"), (0x124, b"\x66")
    ]  # fmt: skip
    assert bus.malformed_lines == 0
    os.close(near)
    os.close(far)


def test_an_adapter_that_is_unplugged_is_said_to_be(folder, program, capsys):
    # Far more than a terminal holds, which is lost with it.
    with adapter(program, pulled_after=1000) as device:
        words = ("--interface", "slcan", "--channel", device, "--seconds", "5", "--json")
        assert ccgen("bridge", str(folder), *words) == 2
    out, err = capsys.readouterr()
    record = json.loads(out)
    assert 0 < record["answered"] < 500
    last = err.splitlines()[-1]
    assert last.startswith(f"ccgen: error: slcan {device}: the bus went away, with ")
    assert record["gone"] in last
    assert "frames lost" not in last


def test_an_adapter_that_is_not_there_is_named(folder, capsys):
    words = ("--interface", "slcan", "--channel", "/dev/ttyACM77", "--seconds", "1")
    assert ccgen("bridge", str(folder), *words) == 2
    err = capsys.readouterr().err
    assert err.startswith("ccgen: error: --interface: slcan /dev/ttyACM77 cannot be opened: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("channel", [(), ("--channel", "0")])
@pytest.mark.parametrize(
    "interface", sorted({*can.VALID_INTERFACES} - {"virtual", "slcan", "udp_multicast"})
)
def test_a_driver_that_is_missing_is_one_line(folder, interface, channel):
    words = ["bridge", str(folder), "--interface", interface, *channel, "--seconds", "0.01"]
    done = subprocess.run(
        [sys.executable, "-m", "ccgen", *words], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"ccgen: error: --interface: {interface}")
    assert "cannot be opened: " in done.stderr
    assert done.stderr.count("\n") == 1


def test_an_interface_that_nobody_knows_is_one_line(folder, capsys):
    assert ccgen("bridge", str(folder), "--interface", "telepathy", "--channel", "0") == 2
    err = capsys.readouterr().err
    assert "--interface: telepathy 0 cannot be opened: " in err
    assert err.count("\n") == 1


def test_a_binding_that_breaks_says_what_its_log_says(monkeypatch):
    def broken(**options):
        logging.getLogger("can.kvaser").warning("Kvaser canlib is unavailable.")
        raise NameError("name 'canGetNumberOfChannels' is not defined")

    monkeypatch.setattr(can, "Bus", broken)
    with pytest.raises(InputError) as error, interface_node(LAYOUT, "kvaser", "0", 500_000):
        pytest.fail("the block must not run")
    assert str(error.value) == (
        "interface: kvaser 0 cannot be opened: Kvaser canlib is unavailable "
        "(NameError: name 'canGetNumberOfChannels' is not defined)"
    )


def test_a_bit_rate_that_slcan_lacks_names_its_key(folder, tmp_path, capsys):
    text = SHOULDER.read_text()
    assert "bitrate" in text
    joint = tmp_path / "shoulder.toml"
    joint.write_text(text.replace("bitrate = 1_000_000", "bitrate = 800_000"))
    export(joint, tmp_path / "slow")
    words = ("--interface", "slcan", "--channel", "/dev/null", "--seconds", "1")
    assert ccgen("bridge", str(tmp_path / "slow"), *words) == 2
    assert capsys.readouterr().err == (
        "ccgen: error: --interface: slcan /dev/null cannot be opened: SLCAN has no 800000 bit/s, "
        "the can.bitrate of joint.toml; write one of 10000, 20000, 50000, 83300, 100000, 125000, "
        "250000, 500000, 750000, 1000000 there\n"
    )


def test_requests_for_the_joints_frames_are_no_damage(folder, program, capsys):
    """Somebody on the bus asks for every frame of the joint, again and again."""
    asked = b"".join(b"r%03X8\r" % frame_id for frame_id in range(0x300, 0x30C))
    with adapter(program, lambda data: asked + data if data[-1:] == b"\r" else data) as device:
        words = ("--interface", "slcan", "--channel", device, "--seconds", "0.2", "--json")
        assert ccgen("bridge", str(folder), *words) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["answered"], record["lost_frames"], record["corrupted"]) == (20, 0, 0)


WITHOUT_TERMINALS = """
import os, sys
for name in ("tty", "termios", "fcntl", "pty", "resource", "pwd", "grp"):
    sys.modules[name] = None
for name in ("openpty", "ttyname", "statvfs", "getuid", "fork", "sched_getaffinity"):
    if hasattr(os, name):
        delattr(os, name)
from ccgen.cli.start import start
start()
"""
"""The program on a system without what POSIX alone has. (Python's own subprocess needs more.)"""


def without_terminals(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_TERMINALS, *words], capture_output=True, text=True,
        check=False,
    )  # fmt: skip


def test_without_terminals_a_folder_is_verified_but_for_its_process(folder):
    done = without_terminals(
        "verify", str(folder), "--snapshots", "20", "--values", "1000", "--json"
    )
    assert done.returncode == 0, done.stderr
    assert [run["transport"] for run in json.loads(done.stdout)["runs"]] == ["batch", "virtual"]
    assert done.stderr == (
        "ccgen: left out: host, slcan-pty: it needs a pseudo-terminal, which this system has not\n"
    )


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ("--interface", "pcan", "--channel", "PCAN_USBBUS1"),
            "pcan PCAN_USBBUS1 cannot be opened",
        ),
        (("--interface", "slcan"), "needs a pseudo-terminal, which this system has not"),
        (("--target", "cortex-m0"), "needs a pseudo-terminal, which this system has not"),
    ],
)
def test_without_terminals_a_bridge_says_what_is_missing(folder, words, says):
    done = without_terminals("bridge", str(folder), *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert says in done.stderr
    assert done.stderr.count("\n") == 1


def test_without_terminals_the_bridge_on_a_virtual_bus_runs(folder):
    done = without_terminals("bridge", str(folder), "--seconds", "0.1", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["answered"] == 10
