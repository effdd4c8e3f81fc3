"""`ccgen report`: what the page says, and how a browser shows it."""

import json
import re
import shutil
import subprocess
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text
from test_fit_recordings import angle_columns, bends, table

import ccgen
from ccgen.cli.main import main
from ccgen.cost.readme import TITLES
from ccgen.report import tables
from ccgen.report.page import page
from ccgen.targets.exported import open_exported

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
LARGEST = 2_000_000


def run(*words) -> int:
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return int(end.value.code or 0)


@pytest.fixture(scope="module")
def fit():
    return ccgen.fit(ccgen.load(EXAMPLES / "shoulder.toml"))


@pytest.fixture(scope="module")
def html(fit):
    return page(fit).decode()


@pytest.fixture(scope="module")
def folder(fit, tmp_path_factory):
    directory = tmp_path_factory.mktemp("report") / "shoulder"
    ccgen.export(fit, directory)
    return directory


class Cells(HTMLParser):
    """Rows of all tables of a page."""

    def __init__(self):
        super().__init__()
        self.rows, self.inside = [], False

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])
        self.inside = tag in ("td", "th")

    def handle_endtag(self, tag):
        self.inside = False

    def handle_data(self, data):
        if self.inside:
            self.rows[-1].append(data)


def rows(html):
    cells = Cells()
    cells.feed(html)
    return {row[0]: row[1:] for row in cells.rows}


def test_the_page_needs_nothing_else(html):
    assert len(html.encode()) < LARGEST
    links = re.findall(r"""(?:src|href)\s*=\s*["']([^"']*)|url\(([^)]*)\)""", html)
    assert {link or style for link, style in links if not (link or style).startswith("#")} == {
        "data:,"
    }
    assert "<script" not in html
    assert "<image" not in html


def test_its_tables_say_what_the_fit_says(fit, html):
    told = rows(html)
    for plain, noisy in zip(fit.errors[::2], fit.errors[1::2], strict=True):
        row = told[plain.source + (" (held out)" if plain.held_out else "")]
        assert row[0] == (f"{plain.mean_percent_rom['u']:.3g} / {noisy.mean_percent_rom['u']:.3g}")
        assert row[-1] == f"{1e3 * plain.tip_max_m:.3g} / {1e3 * noisy.tip_max_m:.3g}"
    assert set(told) >= {sensor.name for sensor in fit.sensed.sensors}
    assert told["v1"] == [f"{x:.3g}" for x in (*fit.without[4].rms_deg.values(),)] + [
        f"{1e3 * fit.without[4].tip_rms_m:.3g}"
    ]
    noisy = next(row for row in fit.errors if row.noise and row.source == fit.stated.name)
    whole = [*noisy.rms_deg.values(), 1e3 * noisy.tip_rms_m]
    assert told["none"] == [f"{value:.3g}" for value in whole]
    assert told["identifiers"] == ["0x300 to 0x30d"]
    assert told["u"][1:4] == ["17", "13", "1"]
    for warning in fit.warnings:
        assert warning in unescape(html)


def test_the_same_fit_gives_the_same_bytes(fit, html):
    assert page(fit).decode() == html


def test_every_picture_is_drawn_as_vectors(html):
    assert html.count("<svg") == 7
    assert "nan" not in re.findall(r' d="([^"]*)"', html)


def test_a_folder_is_reported_with_its_fingerprint(folder, html, tmp_path):
    output = tmp_path / "page.html"
    assert run("report", folder, "-o", output) == 0
    text = output.read_text()
    assert f"{open_exported(folder).fingerprint:#010x}" in text
    assert rows(text)["cases"] == rows(html)["cases"]


def test_a_folder_that_was_edited_is_refused(folder, tmp_path, capsys):
    edited = tmp_path / "shoulder"
    shutil.copytree(folder, edited)
    with (edited / "joint.toml").open("a") as file:
        file.write("# mine\n")
    assert run("report", edited, "-o", tmp_path / "page.html") == 2
    err = capsys.readouterr().err
    assert "joint.toml changed since it was exported; export the joint again" in err
    assert err.count("\n") == 1
    assert not (tmp_path / "page.html").exists()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A joint file with a recording of segment angles and counts beside it, and its folder."""
    home = tmp_path_factory.mktemp("recorded")
    (home / "runs").mkdir()
    (home / "runs" / "run.csv").write_text(table(angle_columns(bends(0), bends(1))))
    file = '[[recordings]]\nfile = "runs/run.csv"\n'
    (home / "arm.toml").write_text(joint_text(name="arm", transducer="noise = 1e-5", tables=file))
    ccgen.export(home / "arm.toml", home / "firmware" / "arm")
    return home


def test_a_folder_whose_recordings_are_at_hand_is_reported(recorded, tmp_path, capsys):
    assert run("report", recorded / "firmware" / "arm", "-o", tmp_path / "folder.html") == 0
    assert run("report", recorded / "arm.toml", "-o", tmp_path / "file.html") == 0
    folder, file = (rows((tmp_path / f"{name}.html").read_text()) for name in ("folder", "file"))
    name = "recording:runs/run.csv (held out)"
    assert folder[name] == file[name]
    assert "those that the page tells" in (tmp_path / "folder.html").read_text()
    assert "weights in the folder" not in (tmp_path / "file.html").read_text()


def test_what_is_said_of_recordings_names_them_as_the_joint_file_does():
    class Told:
        def __init__(self, **values):
            self.__dict__.update(values)

    runs = [Told(source=f"/home/me/{n}", file=Told(file=n)) for n in ("a.csv", "b.csv")]
    said = (
        "state the noise",
        "/home/me/a.csv: mid is far off",
        "/home/me/b.csv: mid is far off",
        "recording:b.csv: is short",
    )
    assert tables.warnings(Told(recordings=runs, warnings=said)) == (
        ("state the noise",),
        ("recording:a.csv, recording:b.csv: mid is far off", "recording:b.csv: is short"),
    )


def test_the_page_of_a_recorded_joint_holds_no_path(recorded, tmp_path):
    assert run("report", recorded / "arm.toml", "-o", tmp_path / "page.html") == 0
    html = (tmp_path / "page.html").read_text()
    assert str(recorded) not in html
    assert "recording:runs/run.csv" in html


def test_a_folder_whose_recordings_are_elsewhere_says_which(recorded, tmp_path, capsys):
    moved = tmp_path / "arm"
    shutil.copytree(recorded / "firmware" / "arm", moved)
    assert run("report", moved, "-o", tmp_path / "page.html") == 2
    err = capsys.readouterr().err
    assert "was fitted to runs/run.csv, which is neither in it nor in a folder above it" in err
    assert err.count("\n") == 1
    (tmp_path / "runs").mkdir()
    text = (recorded / "runs" / "run.csv").read_text()
    (tmp_path / "runs" / "run.csv").write_text(text.replace("0", "1", 1))
    assert run("report", moved, "-o", tmp_path / "page.html") == 2
    err = capsys.readouterr().err
    assert "runs/run.csv is not the recording that it was fitted to; export the joint again" in err
    assert err.count("\n") == 1
    assert not (tmp_path / "page.html").exists()


def test_a_folder_of_shapes_that_it_does_not_name_is_refused(tmp_path, capsys):
    joint = ccgen.load(EXAMPLES / "shoulder.toml")
    angles = np.random.default_rng(0).uniform(-0.05, 0.05, (40, joint.geometry.segments))
    ccgen.export(ccgen.fit(joint, shapes=angles), tmp_path / "shoulder")
    assert run("report", tmp_path / "shoulder", "-o", tmp_path / "page.html") == 2
    err = capsys.readouterr().err
    assert "its joint was fitted to shapes that were given in Python" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("nowhere.toml",), "nowhere.toml: no such folder or joint file"),
        ((EXAMPLES / "shoulder.toml", "-o", "."), ": is not a file; choose another name"),
        ((EXAMPLES,), str(EXAMPLES)),
    ],
)
def test_what_does_not_fit_is_one_line(words, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run("report", *words) == 2
    err = capsys.readouterr().err
    assert (says in err, err.count("\n")) == (True, 1)


LOADS = """
[loads]
samples = 60
actuation = [-10.0, 10.0]
elongation = [0.0, 0.03]
[estimator]
axes = ["v", "h"]
"""
STRINGS = "".join(
    f'[[sensor]]\nname = "s{i}"\nspan = [{i // 2 * 3}, {i // 2 * 3 + 2}]\n'
    f"angle = {180 * (i % 2)}.0\nradius = 0.03\n"
    for i in range(4)
)


def test_a_planar_arm_that_elongates_is_reported(tmp_path):
    text = joint_text(name="arm", segments=6, transducer="noise = 2e-4", step=1e-5)
    text = re.sub(r"placement = .*\ncount = .*\nradius = .*\n", "", text)
    text = text.replace("range_of_motion", "elongation = [0.0, 0.04]\nrange_of_motion")
    fit = ccgen.fit(ccgen.parse(text + STRINGS + LOADS))
    html = page(fit).decode()
    assert {"s0", "s1", "s2", "s3", "v", "h"} <= set(rows(html))
    assert html.count("<svg") == 7
    assert "elongation RMS %" in rows(html)["shapes"]


@pytest.mark.parametrize("name", ["spine", "wrist"])
def test_other_examples_are_reported(name, tmp_path, capsys):
    assert run("report", EXAMPLES / f"{name}.toml", "-o", tmp_path / "page.html") == 0
    text = (tmp_path / "page.html").read_text()
    assert f"<h1>{name}</h1>" in text
    assert len(text) < LARGEST
    assert capsys.readouterr().err == f"ccgen: wrote {tmp_path}/page.html\n"


def test_costs_are_told_where_they_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr("ccgen.cost.costs.COUNTED", ("cortex-m0",))
    output = tmp_path / "page.html"
    assert run("report", EXAMPLES / "shoulder.toml", "--cost", "-o", output) == 0
    told = rows(output.read_text())
    assert told["target"] == list(TITLES[1:])
    assert len(told["cortex-m0"]) == len(TITLES) - 1
    assert all(cell.replace(",", "").isdigit() for cell in told["cortex-m0"])


def test_without_noise_the_page_asks_for_it():
    fit = ccgen.fit(ccgen.parse(joint_text()))
    html = page(fit).decode()
    assert "states no noise of its sensors" in html
    assert html.count("<svg") == 6


def test_numbers_that_are_not_known_are_dashes():
    assert (tables.number(None), tables.number(float("nan")), tables.number(0.0012345)) == (
        "–", "–", "0.00123",
    )  # fmt: skip


MEASURE = """
<script>
addEventListener("load", () => parent.postMessage(JSON.stringify({
  wanted: document.documentElement.scrollWidth, width: innerWidth,
  pictures: [...document.querySelectorAll("figure svg")].map(p => p.getBoundingClientRect().width),
  paper: getComputedStyle(document.body).backgroundColor}), "*"));
</script>
"""
AROUND = """<body style="margin:0"><iframe src="page.html" width="{}" height="900" style="border:0">
</iframe><pre id="said"></pre><script>
addEventListener("message", e => document.getElementById("said").textContent = e.data);
</script></body>"""


def browser(folder, *flags):
    return subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
         "--enable-logging=stderr", f"--user-data-dir={folder / 'profile'}",
         "--virtual-time-budget=3000", *flags, "--dump-dom", (folder / "around.html").as_uri()],
        capture_output=True, text=True, check=True,
    )  # fmt: skip


def test_a_long_name_of_a_recording_scrolls_nothing(tmp_path):
    name = "recordings_of_the_second_of_december_in_the_cellar_0123456789.csv"
    rows = ["t," + ",".join(f"{axis}{i}" for axis in "uv" for i in range(12))]
    wave = np.sin(np.linspace(0, 20, 120)[:, None] * (1 + np.arange(24) / 40))
    rows += [f"{0.1 * k:.1f}," + ",".join(f"{x:.3f}" for x in row) for k, row in enumerate(wave)]
    (tmp_path / name).write_text("\n".join(rows))
    text = joint_text(transducer="noise = 1e-4", tables=f'[[recordings]]\nfile = "{name}"\n')
    html = page(ccgen.fit(ccgen.parse(text, folder=tmp_path))).decode()
    assert name in html
    seen = shown(html, tmp_path, 390)
    assert seen["wanted"] <= 390


@pytest.mark.parametrize("width", [390, 1400])
@pytest.mark.parametrize("dark", [False, True])
def test_a_browser_shows_it_without_scrolling_sideways(html, tmp_path, width, dark):
    seen = shown(html, tmp_path, width, dark)
    assert len(seen["pictures"]) == 7
    assert all(300 < picture <= width for picture in seen["pictures"])
    assert seen["wanted"] <= width
    assert seen["paper"] == ("rgb(22, 22, 22)" if dark else "rgb(255, 255, 255)")


def shown(html, tmp_path, width, dark=False):
    """What a browser says of the page in a window of that width; fails where its console does."""
    (tmp_path / "page.html").write_text(html.replace("</body>", MEASURE + "</body>"))
    (tmp_path / "around.html").write_text(AROUND.format(width))
    done = browser(tmp_path, *(["--blink-settings=preferredColorScheme=0"] if dark else []))
    said = re.search(r'<pre id="said">(.+?)</pre>', done.stdout)
    assert said, done.stderr
    seen = json.loads(unescape(said[1]))
    assert seen["width"] == width
    assert "CONSOLE" not in done.stderr
    return seen
