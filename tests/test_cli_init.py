"""`ccgen init`, and what all commands share: help, exit status, errors in one line."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
import typer

from ccgen import __version__
from ccgen.cli.failures import in_one_line
from ccgen.cli.init import joint_text
from ccgen.cli.main import app, main
from ccgen.cli.output import print_json
from ccgen.errors import ArgumentError, CheckError, InputError
from ccgen.joint.file import parse_joint
from ccgen.shapes.loads.library import loads_library, shortfall

REQUIRED_ONLY = """\
name = "elbow"
[geometry]
segments = 12
length = 0.24
range_of_motion = 3.0
[sensors]
radius = 0.05
[sensors.transducer]
metres_per_count = 2.0e-6
noise = 2.0e-5
"""


def ccgen(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_init_writes_a_file_that_works(capsys):
    assert ccgen("init", "elbow") == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "ccgen: wrote elbow.toml; `ccgen fit elbow.toml` tells how well its sensors do\n"
    assert parse_joint(Path("elbow.toml").read_text(), "elbow.toml").name == "elbow"


def test_the_values_it_shows_are_the_defaults():
    assert parse_joint(joint_text("elbow"), "a") == parse_joint(REQUIRED_ONLY, "b")


def test_every_line_of_the_file_fits_the_screen():
    for name in ("a", "x" * 20):
        assert max(len(line) for line in joint_text(name).splitlines()) <= 100


def test_the_lines_that_are_commented_out_work():
    text = joint_text("elbow")
    for line in (
        "range = [-20000, 20000]",
        "[sensors.v]",
        "radius = 0.04",
        "[sensors.v.transducer]",
        "metres_per_count = 1.0e-6",
    ):
        assert f"\n# {line}" in text
        text = text.replace(f"\n# {line}", f"\n{line}")
    joint = parse_joint(text, "elbow.toml")
    assert (joint.u.transducer.range, joint.v.radius) == ((-20000, 20000), 0.04)
    assert (joint.u.radius, joint.v.transducer.metres_per_count) == (0.05, 1e-6)


def uncommented(text, table):
    """A file with the lines of one table that were commented out."""
    before, _, after = text.partition(f"\n# {table}\n")
    lines, blank, rest = after.partition("\n\n")
    return f"{before}\n{table}\n" + re.sub("^# ", "", lines, flags=re.MULTILINE) + blank + rest


def test_the_loads_that_are_commented_out_bend_the_joint_as_far_as_it_goes():
    joint = parse_joint(uncommented(joint_text("elbow"), "[loads]"), "elbow.toml")
    assert joint.loads.samples == 300
    drawn = loads_library(joint)
    assert shortfall(drawn, 300) is None
    bent = np.abs(drawn.shapes.u).max() / joint.geometry.range_of_motion
    assert 0.8 < bent <= 1.0 + 1e-9


def test_the_kinematics_that_are_commented_out_are_the_default_and_can_be_left_out():
    text = uncommented(joint_text("elbow"), "[kinematics]")
    assert "\nfloat = true " in text
    assert parse_joint(text, "elbow.toml").float_kinematics
    without = text.replace("\nfloat = true ", "\nfloat = false")
    assert not parse_joint(without, "elbow.toml").float_kinematics


def test_the_recording_that_is_commented_out_is_read(capsys):
    text = uncommented(joint_text("elbow"), "[[recordings]]")
    (recording,) = parse_joint(text, "elbow.toml").recordings
    assert recording.stations == (("tip", 0.24),)
    Path("elbow.toml").write_text(text)
    assert ccgen("fit", "elbow.toml") == 2
    assert "run1.csv" in capsys.readouterr().err


def test_init_replaces_a_file_only_when_told_to(capsys):
    Path("mine.toml").write_text("mine")
    assert ccgen("init", "elbow", "-o", "mine.toml") == 2
    assert capsys.readouterr().err == (
        "ccgen: error: mine.toml: exists already; give another file with -o, or --force\n"
    )
    assert Path("mine.toml").read_text() == "mine"
    assert ccgen("init", "elbow", "-o", "mine.toml", "--force") == 0
    assert Path("mine.toml").read_text() == joint_text("elbow")


@pytest.mark.parametrize("name", ["int", 'a"b', "../elbow", "", "x" * 21])
def test_init_refuses_names_that_c_cannot_take(capsys, name):
    assert ccgen("init", name) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"ccgen: error: NAME: {name!r} ")
    assert err.endswith("give a C identifier of at most 20 characters, such as shoulder\n")
    assert list(Path().iterdir()) == []


def test_init_names_a_folder_that_cannot_be_written(capsys):
    assert ccgen("init", "elbow", "-o", "/proc/ccgen/elbow.toml") == 2
    assert "/proc/ccgen: cannot be written" in capsys.readouterr().err


def test_the_version_is_printed(capsys):
    assert ccgen("--version") == 0
    assert capsys.readouterr().out == f"ccgen {__version__}\n"


def test_every_help_carries_an_example(capsys):
    assert ccgen("--help") == 0
    listed = capsys.readouterr().out
    for command in app.registered_commands:
        assert command.callback is not None
        name = command.callback.__name__
        assert f"\n  {name} " in listed
        assert ccgen(name, "--help") == 0
        assert f"\n    ccgen {name} " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["init"], "ccgen init: missing argument 'NAME'; `ccgen init --help` tells more"),
        (["init", "elbow", "--colour"], "ccgen init: no such option: --colour"),
        (["initt"], "Did you mean 'init'?; `ccgen --help` tells more"),
        (["fit", "x.toml", "--method", "wan"], "'--method': 'wan' is not one of 'direct', 'equal'"),
    ],
)
def test_wrong_usage_is_one_line_and_ends_with_status_2(capsys, words, said):
    assert ccgen(*words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.startswith("ccgen: error: ")
    assert err.count("\n") == 1


def test_without_a_word_it_tells_what_there_is(capsys):
    assert ccgen() == 0
    assert "Commands:" in capsys.readouterr().out


def test_an_interruption_is_one_line_and_status_130(capsys, monkeypatch, tmp_path):
    def interrupted(path, data):
        raise KeyboardInterrupt

    monkeypatch.setattr("ccgen.outputs.write_file", interrupted)
    assert ccgen("init", "elbow", "-o", str(tmp_path / "elbow.toml")) == 130
    assert capsys.readouterr() == ("", "ccgen: interrupted\n")


@pytest.mark.parametrize("place", ["before", "after"])
def test_debug_shows_the_traceback_before_the_line(capsys, place):
    words = ["--debug", "init", "int"] if place == "before" else ["init", "int", "--debug"]
    assert ccgen(*words) == 2
    err = capsys.readouterr().err
    assert err.startswith("Traceback (most recent call last):")
    assert err.splitlines()[-1].startswith("ccgen: error: NAME: 'int' is a keyword")
    assert ccgen("init", "int") == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (InputError("joint.toml: x"), 2, "ccgen: error: joint.toml: x\n"),
        (CheckError("3 mismatches"), 1, "ccgen: error: 3 mismatches\n"),
        (OSError(28, "No space left", "f"), 2, "ccgen: error: f: no space left\n"),
    ],
)
def test_errors_are_one_line_and_a_status(capsys, error, status, line):
    def command() -> None:
        raise error

    with pytest.raises(typer.Exit) as end:
        in_one_line(command)()
    assert end.value.exit_code == status
    assert capsys.readouterr() == ("", line)


def test_an_error_of_an_argument_names_the_word_of_the_command_that_has_it(capsys):
    def command(
        directory: Annotated[Path, typer.Argument(metavar="DIR")],
        output: Annotated[str, typer.Option("-o", "--output-file")] = "",
        max_ram: Annotated[int, typer.Option()] = 0,
    ) -> None:
        raise ArgumentError("do not fit; give others", "directory", "output", "max_ram")

    with pytest.raises(typer.Exit):
        in_one_line(command)(Path())
    assert capsys.readouterr().err == (
        "ccgen: error: DIR, --output-file, --max-ram: do not fit; give others\n"
    )


def test_a_defect_of_the_program_keeps_its_traceback():
    def command() -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        in_one_line(command)()


def test_json_is_one_object_of_real_numbers(capsys):
    print_json({"a": [1, 2.5], "b": {"c": None}})
    assert json.loads(capsys.readouterr().out) == {"a": [1, 2.5], "b": {"c": None}}
    with pytest.raises(ValueError, match="not JSON compliant"):
        print_json({"a": float("nan")})


def test_help_imports_nothing_heavy():
    program = (
        "import sys, ccgen.cli.main\n"
        "heavy = {'numpy', 'scipy', 'pydantic', 'casadi', 'matplotlib', 'can', 'cantools',\n"
        "         'jinja2', 'rich'}\n"
        "print(heavy & set(sys.modules))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip
    assert run.stdout == "set()\n"
