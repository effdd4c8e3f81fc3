"""The SocketCAN port on vcan0, python-can's socketcan on the other side; `run.py` starts this.

Not collected by the suite: it needs a kernel with vcan and the right to set up interfaces.
"""

import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from run import variants

from ccgen.can.exchange import Pace
from ccgen.can.layout import FrameLayout
from ccgen.can.transports.interface import interface_node
from ccgen.cli.main import main
from ccgen.errors import InputError
from ccgen.targets.exported import Exported, open_exported
from ccgen.targets.inputs import bus_counts
from ccgen.verify.bus import verify_bus
from ccgen.verify.plan import silent

FOLDER = Path("/run/vcan")
SNAPSHOTS = 1000
PACE = Pace(timeout=10.0)


@pytest.fixture(autouse=True)
def _fresh_interface():
    set_up(mtu=72)


def set_up(mtu: int) -> None:
    link("down")
    link("mtu", str(mtu), "up")


def link(*settings: str) -> None:
    subprocess.run(["ip", "link", "set", "vcan0", *settings], check=True)


@contextmanager
def node(name: str) -> Iterator[subprocess.Popen[bytes]]:
    """The joint's node on vcan0, ended by a signal and without a complaint if it still runs."""
    program = FOLDER / f"{name}.node"
    # Patient: a loaded machine may pause everything between two frames.
    with subprocess.Popen([program, "--patient", "vcan0"], stderr=subprocess.PIPE) as running:
        try:
            yield running
        finally:
            still_there = running.poll() is None
            running.send_signal(signal.SIGTERM)
        assert not still_there or (running.wait(30), running.stderr.read()) == (0, b"")


def compare(name: str, snapshots: int) -> None:
    """Shapes, corners and random counts, as fast as answers come; prints what came of it."""
    exported = open_exported(FOLDER / name)
    counts = bus_counts(exported, snapshots, seed=1)
    with node(name), on_bus(exported) as bus:
        run = verify_bus(exported, bus, counts, PACE, silent, "host", "socketcan")
    print(
        f"{run.snapshots:,} snapshots, {run.compared_values:,} angles, {run.mismatches} wrong, "
        f"{run.lost_frames} frames lost, {run.rate_hz:,.0f} snapshots/s ",
        end="",
    )
    assert run.passed, run
    assert run.snapshots == snapshots


def on_bus(exported: Exported):
    return interface_node(exported.layout, "socketcan", "vcan0")


@pytest.mark.parametrize("name", variants())
def test_every_angle_is_the_models_and_no_frame_is_lost(name):
    compare(name, SNAPSHOTS)


def test_four_answers_of_98_frames_wait_for_a_busy_host():
    compare("large", 100)


def test_a_queue_of_ten_frames_on_a_slow_bus_loses_nothing():
    """Both sides find the queue full and wait, as on a real interface left as it comes."""
    queue = ["tc", "qdisc", "add", "dev", "vcan0", "root", "tbf"]
    subprocess.run([*queue, "rate", "125kbit", "burst", "32", "limit", "160"], check=True)
    try:
        compare("classic-32-11", 100)
        shown = subprocess.run(
            ["tc", "-s", "-j", "qdisc", "show", "dev", "vcan0"], capture_output=True, check=True
        )
    finally:
        subprocess.run(["tc", "qdisc", "del", "dev", "vcan0", "root"], check=True)
    assert json.loads(shown.stdout)[0]["drops"] > 0


def test_the_bridge_streams_to_it(capsys):
    with node("classic-16-11"), pytest.raises(SystemExit) as end:
        main([
            "bridge", str(FOLDER / "classic-16-11"), "--interface", "socketcan",
            "--channel", "vcan0", "--seconds", "3", "--json",
        ])  # fmt: skip
    record = json.loads(capsys.readouterr().out)
    assert not end.value.code
    assert (record["snapshots"], record["answered"]) == (300, 300)
    assert (record["lost_frames"], record["corrupted"], record["mismatches"]) == (0, 0, 0)


@pytest.mark.parametrize("name", ["classic-16-11", "fd-32-29"])
def test_candump_and_the_dbc_show_what_was_estimated(name):
    exported = open_exported(FOLDER / name)
    model, counts = exported.model, bus_counts(exported, 20, seed=2)
    with (
        node(name),
        subprocess.Popen(["candump", "-L", "vcan0"], stdout=subprocess.PIPE, text=True) as dump,
        on_bus(exported) as bus,
    ):
        dump.stdout.readline()  # a STATUS: it listens
        verify_bus(exported, bus, counts, PACE, silent, "host", "socketcan")
        logged = lines_to_tip(dump.stdout, exported.layout, len(counts))
        dump.terminate()
    decode = [sys.executable, "-m", "cantools", "decode", "--single-line"]
    decoded = subprocess.run(
        [*decode, FOLDER / name / "shoulder.dbc"],
        input=logged,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    shown = re.findall(r"angle_([uv])\d+: (\S+) rad", decoded.stdout)
    raw = [float(value) * 2.0 ** model.axis(axis).fraction_bits for axis, value in shown]
    assert raw == model.estimate(counts).ravel().tolist()


def lines_to_tip(lines: Iterable[str], layout: FrameLayout, wanted: int) -> str:
    """Lines of candump's log up to the wanted number of TIP frames; STATUS frames keep coming."""
    tip = f" {layout.frames_of('tip')[0].id:03X}#"
    logged = []
    for line in lines:
        logged.append(line)
        wanted -= tip in line
        if wanted == 0:
            break
    return "".join(logged)


@pytest.mark.parametrize("name", ["classic-16-11", "fd-16-29"])
def test_an_interface_that_is_down_is_named(name):
    with node(name) as running:
        link("down")
        assert running.wait(30) == 1
        assert running.stderr.read() == b"vcan0: is down; `ip link set vcan0 up`\n"
    with pytest.raises(InputError, match="vcan0: cannot be opened: it is down"):
        on_bus(open_exported(FOLDER / name)).__enter__()


def test_an_interface_without_can_fd_is_named():
    set_up(mtu=16)
    with node("fd-16-11") as running:
        assert running.wait(30) == 1
        assert running.stderr.read().startswith(b"vcan0: takes no CAN FD frames")
    with pytest.raises(InputError, match="vcan0: cannot be opened: it takes no CAN FD frames"):
        on_bus(open_exported(FOLDER / "fd-16-11")).__enter__()


def test_an_interface_that_is_not_there_is_named():
    layout = open_exported(FOLDER / "fd-16-11").layout
    with (
        pytest.raises(InputError, match=r"vcan7: cannot be opened: .*No such device"),
        interface_node(layout, "socketcan", "vcan7"),
    ):
        pass
