"""`--view`: what is drawn, what reaches the page, and how a view ends."""

import json
import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
import urllib.error
import urllib.request
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import viser
from joint_files import joint_text
from viewer import moves, until, viewer
from waiting import PATIENCE, becomes, read_until, write_all
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import ccgen
from ccgen.cli.main import main
from ccgen.errors import ArgumentError, ToolError
from ccgen.figures.curves import frames_along, string_paths
from ccgen.recordings.log_files import read_frames
from ccgen.sensing.bending import Bending, scaled
from ccgen.targets.exported import open_exported
from ccgen.view import page as pages
from ccgen.view.drawing import LONG, MISSING, NEUTRAL, SHORT, SUSPECTED, colour, drawing_of
from ccgen.view.on_bus import BusSights
from ccgen.view.page import open_browser, open_page
from ccgen.view.panel import legend, numbers
from ccgen.view.sight import Bends, Sight, errors_of
from ccgen.view.simulated import as_found, simulated_sights

SHOULDER = Path(__file__).resolve().parent.parent / "examples" / "shoulder.toml"
RANGE = math.radians(3.0)


@pytest.fixture(scope="module")
def fit():
    return ccgen.fit(ccgen.load(SHOULDER))


@pytest.fixture(scope="module")
def joint(fit):
    return as_found(fit)


@pytest.fixture(scope="module")
def sights(fit, joint):
    bending = Bending("end-force", RANGE, "v")
    return simulated_sights(fit, [bending.at(joint, share) for share in (0.01, 0.5, 1.0)])


@pytest.fixture(scope="module")
def folder(fit, tmp_path_factory):
    directory = tmp_path_factory.mktemp("view") / "shoulder"
    ccgen.export(fit, directory)
    return directory


@pytest.fixture(scope="module")
def log(folder):
    path = folder.parent / "run.log"
    with pytest.raises(SystemExit) as end:
        main(["bridge", str(folder), "--seconds", "0.4", "--log", str(path)])
    assert not end.value.code
    return path


@pytest.fixture
def hasty(monkeypatch):
    """A page that is closed at once where nobody looks any more."""
    monkeypatch.setattr(pages, "_GONE_SECONDS", 0.3)


def run(*words) -> int:
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return int(end.value.code or 0)


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def test_the_drawn_joint_ends_at_its_pose(joint, sights):
    simulation = Bending("end-force", RANGE, "v").at(joint)
    drawing = drawing_of(joint, sights[-1])
    np.testing.assert_allclose(drawing.ghost[-1, 1], simulation.tip_pose[:3, 3], atol=1e-9)
    np.testing.assert_allclose(drawing.tip, sights[-1].estimate.tip(joint), atol=1e-9)
    np.testing.assert_array_equal(drawing.backbone[-1, 1], drawing.tip)
    assert len(drawing.places) == len(drawing.turns) == joint.geometry.segments + 1
    half = drawing.turns[-1]
    bend = 2.0 * math.acos(half[0])
    assert bend == pytest.approx(abs(float(sights[-1].estimate.v.sum())), rel=1e-6)


def test_strings_are_as_long_as_the_tendons_that_sensors_measure():
    """Each sensor for itself, so that none is drawn beside its place."""
    whole = ccgen.parse(joint_text())
    for sensor in whole.sensors:
        one = replace(whole, sensors=(sensor,))
        u, v = np.linspace(0.0, RANGE, 12), np.linspace(RANGE, -RANGE, 12)
        frames = frames_along(u, v, np.full(12, one.geometry.segment_length))
        (path,) = string_paths(one, frames)
        drawn = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        covered = slice(round(sensor.start), round(sensor.end))
        sine, cosine = math.sin(sensor.angle), math.cos(sensor.angle)
        change = sensor.radius * (u[covered].sum() * sine - v[covered].sum() * cosine)
        unbent = sensor.segments * one.geometry.segment_length
        assert drawn == pytest.approx(unbent + change, rel=1e-5)


def test_sensors_that_overlap_do_not_hide_each_other(joint):
    frames = frames_along(np.zeros(12), np.zeros(12), np.full(12, 0.02))
    paths = string_paths(joint, frames)
    places = {(round(path[0, 0], 6), round(path[0, 1], 6)) for path in paths}
    for one, path in zip(joint.sensors, paths, strict=True):
        assert math.hypot(*path[0, :2]) == pytest.approx(one.radius)
        for other, beside in zip(joint.sensors, paths, strict=True):
            if one is not other and one.start < other.end and other.start < one.end:
                assert not np.array_equal(path[0, :2], beside[0, :2])
    assert len(places) < len(paths)  # those that do not overlap keep their place


def test_strings_tell_readings_by_colour_and_missing_ones_are_broken(joint):
    n = len(joint.sensors)
    readings = np.array([RANGE, -RANGE, 0.0, *[0.0] * (n - 3)])
    sight = Sight(0.0, Bends.straight(joint), readings)
    colours, strings = drawing_of(joint, sight).string_colours, drawing_of(joint, sight).strings
    assert {tuple(c) for c in colours[:, 0].tolist()} == {LONG, SHORT, NEUTRAL}
    assert (colour(5.0), colour(-0.5)) == (LONG, (107, 164, 196))
    names = [sensor.name for sensor in joint.sensors]
    broken = replace(sight, missing=(names[0],), suspected=(names[1],))
    drawing = drawing_of(joint, broken)
    assert {tuple(c) for c in drawing.string_colours[:, 0].tolist()} == {
        MISSING, SUSPECTED, NEUTRAL,
    }  # fmt: skip
    assert drawing.strings.shape == strings.shape
    own = (drawing.string_colours[:, 0] == MISSING).all(axis=1)
    heights = drawing.strings[own][:, 0, 2]
    assert len(heights) == 40
    assert len(set(heights.tolist())) == 21  # what lies in gaps is drawn on the dash before


def test_errors_are_told_where_the_truth_is_known(joint, sights):
    sight = sights[-1]
    off = replace(sight, estimate=replace(sight.estimate, u=sight.estimate.u + 0.01))
    assert errors_of(joint, off).bends["u"] == pytest.approx(0.01, rel=1e-3)
    assert errors_of(joint, off).tip > 0.001
    assert errors_of(joint, replace(off, truth=None)) is None
    lost = errors_of(joint, replace(off, lost=("u",)))
    assert set(lost.bends) == {"v"}
    assert math.isnan(lost.tip)
    text = numbers(joint, off, errors_of(joint, off))
    assert "<td" in text
    assert f"{math.degrees(0.01):.2f}" in text
    assert "the &lt;shape&gt;" in legend("the <shape>")


def test_what_the_bus_tells_is_held_against_the_reference_model(folder, log):
    from ccgen.can.monitor import Monitor
    from ccgen.can.seen import plain

    exported = open_exported(folder)
    watch = Monitor(exported.guarded, exported.codec, exported.fingerprint)
    seen = [one for m in read_frames(log) for one in watch.take(m)]
    sights = BusSights(exported.joint, exported.guarded)
    record = plain(seen[-1], exported.model, exported.layout)
    sight = sights.sight(record, known_zero=True)
    np.testing.assert_allclose(np.degrees(sight.estimate.u), record["angles_deg"]["u"], atol=1e-8)
    np.testing.assert_allclose(sight.estimate.u, sight.truth.u, atol=1e-8)
    np.testing.assert_allclose(sight.estimate.tip(exported.joint), record["tip_m"], atol=2e-5)
    assert sights.sight(record, known_zero=False).truth is None
    assert np.isnan(sights.sight(record | {"counts": None}, known_zero=True).readings).all()

    lost = {**record, "angles_deg": {"u": [None] * 12, "v": record["angles_deg"]["v"]}}
    kept = sights.sight(lost, known_zero=True)
    assert kept.lost == ("u",)
    np.testing.assert_array_equal(kept.estimate.u, sight.estimate.u)
    one_less = {**record, "counts": [None, *record["counts"][1:]], "missing": ["u0"]}
    assert sights.sight(one_less, known_zero=True).missing == ("u0",)
    assert np.abs(sights.sight(one_less, known_zero=True).truth.u - sight.truth.u).max() > 0


def test_the_page_is_for_this_machine_alone_and_says_nothing(joint, sights, capfd):
    with open_page(joint, "the truth") as page, viewer(page.url) as batch:
        port = int(page.url.rpartition(":")[2])
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", port), timeout=5)
        assert becomes(lambda: page.opened)
        page.show(sights[-1])
        page.settle()
        moved = until(batch, moves)
        assert set(moved["updates"]) == {"points"}
        with pytest.raises(ArgumentError, match=f"view_port: {port} cannot be listened on"):
            next(iter(open_page(joint, None, port).gen))
        with open_page(joint, None) as second:  # the next free one
            assert second.url != page.url
        assert page._server.request_share_url() is None
    assert capfd.readouterr() == ("", "")


def test_pages_from_elsewhere_do_not_see_the_joint(joint):
    with open_page(joint, None) as page:
        socket_of = page.url.replace("http://", "ws://")
        protocol = [f"viser-v{viser.__version__}"]
        for here in (None, page.url, "http://localhost:9000", "http://[::1]:80"):
            with connect(socket_of, origin=here, subprotocols=protocol) as opened:
                assert opened.recv(timeout=PATIENCE)
        for foreign in (
            "https://example.com",
            "http://127.0.0.1.example.com",
            "null",
            "http://[",
            "",
        ):
            with pytest.raises(InvalidStatus, match="403"):
                connect(socket_of, origin=foreign, subprotocols=protocol)
        with urllib.request.urlopen(page.url, timeout=PATIENCE) as answer:
            assert answer.status == 200
        asked = urllib.request.Request(page.url, headers={"Origin": "https://example.com"})
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(asked, timeout=PATIENCE)


def test_an_update_is_few_messages_however_many_sensors_there_are(joint, sights):
    with open_page(joint, "the truth") as page, viewer(page.url) as batch:
        assert becomes(lambda: page.opened)
        page.show(sights[0])
        until(batch, moves)
        time.sleep(0.3)
        page.show(sights[-1])
        end, names = time.monotonic() + PATIENCE, []
        while "/backbone" not in names and time.monotonic() < end:
            names = [m.get("name") for m in batch() if m["type"].startswith(("Scene", "Set"))]
    assert 4 <= len(names) <= 9


def test_a_missing_package_is_named(folder, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "viser", None)
    words = ("--interface", "virtual", "--channel", "v", "--view", "--no-browser")
    assert run("monitor", folder, *words) == 2
    assert capsys.readouterr().err == (
        "ccgen: error: a view needs viser; install it with `pip install 'ccgen[view]'`\n"
    )


def test_a_port_that_is_taken_is_one_line(log, folder, capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        words = ("--source", log, "--view", "--no-browser", "--view-port", port)
        assert run("monitor", folder, *words) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"error: --view-port: {port} cannot be listened on (address already in use)" in err


@pytest.mark.parametrize("option", [("--no-browser",), ("--view-port", "8123")])
def test_options_of_a_page_belong_to_it(folder, option, capsys):
    assert run("monitor", folder, "--interface", "virtual", *option) == 2
    assert f"{option[0]}: belongs to --view" in capsys.readouterr().err


def test_without_a_browser_it_says_what_to_do(folder, log, monkeypatch, capsys):
    import webbrowser

    def none(using=None):
        raise webbrowser.Error("could not locate runnable browser")

    monkeypatch.setattr(webbrowser, "get", none)
    assert run("monitor", folder, "--source", log, "--view") == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "no browser was found to open the page in; with --no-browser" in err


def test_a_browser_of_the_terminal_is_none(monkeypatch):
    import webbrowser

    monkeypatch.delenv("BROWSER", raising=False)
    monkeypatch.setattr(webbrowser, "get", lambda: webbrowser.GenericBrowser("lynx"))
    with pytest.raises(ToolError, match="no browser was found"):
        open_browser("http://127.0.0.1:1")


@contextmanager
def somebody(port, look):
    """Somebody who looks once the page is there, in a thread; what they found, in a list.

    A command goes on until they have looked: where they cannot, Ctrl-C ends it.
    """
    found, over = [], threading.Event()

    def go():
        try:
            with viewer(f"http://127.0.0.1:{port}") as batch:
                found.append(look(batch))
        finally:
            if not found and not over.is_set():
                os.kill(os.getpid(), signal.SIGINT)

    looker = threading.Thread(target=go, daemon=True)
    looker.start()
    try:
        yield found
    finally:
        over.set()
        looker.join(2 * PATIENCE)


def test_a_log_is_shown_from_when_somebody_looks_until_nobody_does(folder, log, hasty, capsys):
    port, again = free_port(), folder.parent / "again.log"
    words = ("--source", log, "--view", "--no-browser", "--view-port", port, "--json")
    with somebody(port, lambda batch: until(batch, moves)) as found:
        assert run("monitor", folder, *words, "--log", again) == 0
    assert len(found) == 1
    out, err = capsys.readouterr()
    lines = list(map(json.loads, out.splitlines()))
    assert lines[-1]["summary"]["snapshots"] == len(lines) - 1 > 20
    assert f"the joint is at http://127.0.0.1:{port}; Ctrl-C ends" in err
    assert len(list(read_frames(again))) == len(list(read_frames(log)))


def test_a_simulated_shape_is_shown_until_the_page_is_closed(tmp_path, hasty, capsys):
    port = free_port()

    def look(batch):
        until(batch, lambda m: moves(m, "/truth"))
        return until(batch, moves)

    words = ("--case", "s-shape", "--first-segment", "2", "--json")
    with somebody(port, look) as found:
        assert run("simulate", SHOULDER, *words, "--view", "--no-browser", "--view-port", port) == 0
    assert len(found) == 1
    assert set(json.loads(capsys.readouterr().out)) >= {"segment_angles_deg", "tip_pose"}


@pytest.mark.parametrize("end", ["pulled", signal.SIGINT])
def test_a_bus_that_goes_away_during_a_view_leaves_the_log_whole(folder, log, tmp_path, end):
    far, near = os.openpty()
    tty.setraw(near)
    frames, copy, port = list(read_frames(log)), tmp_path / "copy.blf", free_port()
    tip = tip_of(folder)
    *told, _ = (k for k, message in enumerate(frames) if message.arbitration_id == tip)
    words = ["monitor", folder, "--interface", "slcan", "--channel", os.ttyname(near)]
    words += ["--log", copy, "--view", "--no-browser", "--view-port", port, "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "ccgen", *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        read_until(far, lambda data: b"L\r" in data)
        with viewer(f"http://127.0.0.1:{port}") as batch:
            for message in frames:
                head = b"t%03X%d" % (message.arbitration_id, len(message.data))
                write_all(far, head + message.data.hex().encode() + b"\r")
                time.sleep(0.001)
            until(batch, moves)
        for _ in told:  # it goes on without anybody who looks
            process.stdout.readline()
        os.close(near)
        if end == "pulled":
            os.close(far)
        else:
            process.send_signal(end)
        out, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == (2 if end == "pulled" else 0), err
    logged = [bytes(message.data) for message in read_frames(copy)]
    assert len(logged) > told[-1]
    assert logged == [bytes(message.data) for message in frames[: len(logged)]]
    assert err.startswith("ccgen: the joint is at http://127.0.0.1:")
    if end == "pulled":
        assert "the bus went away" in err.splitlines()[-1]
    else:
        os.close(far)
        assert "summary" in json.loads(out.splitlines()[-1])


def tip_of(folder):
    """The identifier of the last frame of an answer."""
    (frame,) = open_exported(folder).layout.frames_of("tip")
    return frame.id


def test_loads_are_raised_together(joint):
    from ccgen.joint.loads import Contact, StatedLoads

    loads = StatedLoads(
        0.4, actuation=(0.2, 0.0), tip_force=(1.0, 2.0, -0.5), tip_moment=(0.01, 0.0),
        distributed=(0.0, 0.0, -4.0), contacts=(Contact(0.1, (-2.0, 1.0, 0.0)),),
    )  # fmt: skip
    half = scaled(loads, 0.5)
    assert (half.tip_force, half.distributed) == ((0.5, 1.0, -0.25), (0.0, 0.0, -2.0))
    assert (half.contacts[0].at, half.contacts[0].force) == (0.1, (-1.0, 0.5, 0.0))
    assert (half.actuation, half.tip_moment) == ((0.1, 0.0), (0.005, 0.0))
    whole, part = Bending(loads=loads).at(joint), Bending(loads=loads).at(joint, 0.5)
    assert np.abs(part.u).sum() < np.abs(whole.u).sum()
