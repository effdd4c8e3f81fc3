"""`ccgen export --example mcp2515`: on an emulated ATmega1284P at a modelled MCP2515.

10,000 snapshots: tests/benchmarks/mcp2515_snapshots.py.
"""

import configparser
import json
import shutil
from pathlib import Path

import pytest
from avr_mcp2515 import Board, build
from test_both_ends import ODD
from test_example_projects import arduino

from ccgen.errors import InputError
from ccgen.export.banks import strangers, two_masks
from ccgen.export.package import export
from ccgen.joint.file import parse_joint
from ccgen.targets.exported import open_exported

EXAMPLES = Path(__file__).parent.parent / "examples"
JOINTS = {"odd": ODD, **{n: (EXAMPLES / f"{n}.toml").read_text() for n in ("shoulder", "wrist")}}
SNAPSHOTS = 60


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mcp2515")
    for name, text in JOINTS.items():
        export(parse_joint(text, f"{name}.toml"), folder / name, examples=["mcp2515", "platformio"])
    return folder


@pytest.fixture(scope="module")
def board(folders, tmp_path_factory):
    return Board(folders / "odd", tmp_path_factory.mktemp("board"))


@pytest.mark.parametrize("name", JOINTS)
def test_the_example_builds_for_a_chip_with_its_own_converter(folders, tmp_path, name):
    assert build(folders / name, tmp_path / "build").is_file()


@pytest.mark.parametrize("name", JOINTS)
def test_the_platformio_example_builds_as_arduino_builds_it(folders, tmp_path, name):
    project = folders / name / "examples" / "platformio"
    settings = configparser.ConfigParser()
    settings.read(project / "platformio.ini")
    mega = settings["env:mega"]
    assert (mega["board"], mega["framework"]) == ("megaatmega2560", "arduino")
    (library, path), *_ = (row.split("=", 1) for row in mega["lib_deps"].split("\n") if "=" in row)
    assert (project / path.removeprefix("symlink://")).resolve() == (folders / name).resolve()
    assert json.loads((folders / name / "library.json").read_text())["name"] == library == name
    sketch = shutil.copytree(project / "src", tmp_path / "sketch")
    (sketch / "sketch.ino").write_text(f"#include <{name}.h>\n")  # as the README says
    board = "arduino:avr:mega:cpu=atmega2560"
    assert arduino(sketch / "sketch.ino", folders, board, tmp_path / "build") == []


def test_can_fd_is_refused_with_the_controllers_name(tmp_path):
    with pytest.raises(InputError, match=r"can.fd: true, but the MCP2515 of the example mcp2515"):
        export(EXAMPLES / "spine.toml", tmp_path / "spine", examples=["mcp2515"])
    assert not (tmp_path / "spine").exists()


@pytest.mark.parametrize("name", JOINTS)
def test_two_masks_let_in_what_is_the_nodes_and_tell_whom_else(folders, name):
    layout = open_exported(folders / name).layout
    masks = two_masks(layout)
    assert len({mask for _, mask in masks[:2]}) == len({mask for _, mask in masks[2:]}) == 1
    wanted = {frame.id for frame in layout.frames_of("lengths")}
    wanted |= {layout.last_id} if layout.commands else set()
    near = range(max(0, layout.base_id - 70), layout.last_id + 70)
    let_in = {i for i in near if any((i ^ id_) & mask == 0 for id_, mask in masks)}
    assert let_in == wanted | {int(text, 16) for text in strangers(layout, masks)}


def test_every_snapshot_is_answered(board):
    told = board.run(board.traffic(SNAPSHOTS), SNAPSHOTS)
    assert board.answers(told, SNAPSHOTS) == (set(range(SNAPSHOTS)), 0)
    assert told.violations == ""
    lengths = board.exported.layout.lengths_frames
    assert told.counters == {"received": lengths * SNAPSHOTS, "sent": len(told.sent), "dropped": 0,
                             "aborted": 0, "bus_off": 0, "errors": 0}  # fmt: skip


def test_mishaps_are_counted_and_over_within_three_cycles(board):
    off, deaf = board.time_of(10), board.time_of(25)
    reset, burst = board.time_of(40) + 300, board.time_of(48) + 500
    layout = board.exported.layout
    strange = [f"frame {burst + 50 * i} {layout.base_id:x} {int(layout.extended)} 8 {'00' * 8}"
               for i in range(40)]  # fmt: skip
    script = sorted([*board.traffic(SNAPSHOTS), *strange], key=lambda line: int(line.split()[1]))
    script += [f"broken {off} {off + 45_000}", f"deaf {deaf} {deaf + 200_000}", f"reset {reset}"]
    told = board.run(script, SNAPSHOTS)
    answered, wrong = board.answers(told, SNAPSHOTS)
    assert (wrong, told.violations) == (0, "")
    lost = set(range(SNAPSHOTS)) - answered
    assert lost <= {*range(10, 13 + 3), *range(40, 43), *range(48, 51)}
    assert told.counters["bus_off"] >= 1
    assert told.counters["aborted"] > 0
    assert told.counters["errors"] > 0
    assert told.counters["dropped"] > 0
