"""Compilers and paths as users write them."""

import errno
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from ccgen.can.transports.library import library_node
from ccgen.can.transports.process import process_node
from ccgen.cli.main import main
from ccgen.errors import InputError, ToolError
from ccgen.export.package import export
from ccgen.outputs import new_folder, write_file
from ccgen.targets.compiler import compiler
from ccgen.targets.emulator import running_node
from ccgen.targets.exported import open_exported
from ccgen.targets.host import compile_process
from ccgen.targets.library import JointLibrary

ROOT = Path(__file__).resolve().parent.parent
SHOULDER = ROOT / "examples" / "shoulder.toml"
FOLDERS = [
    "with space",
    "ärm µ",
    "-o",
    "@args",
    "a,b",
    "it's",
    "$HOME",
    "%s{0}",
    "a;b&c",
    "x" * 255,
]


def ccgen(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)


def contents(folder: Path) -> dict[str, bytes]:
    folder = folder.resolve()
    files = (f for f in folder.rglob("*") if f.is_file())
    return {f.relative_to(folder).as_posix(): f.read_bytes() for f in files}


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paths") / "shoulder"
    export(SHOULDER, folder)
    return folder


def tool(folder: Path) -> Path:
    """A compiler of its own, which leaves a mark with its arguments."""
    folder.mkdir()
    program = folder / "cc"
    program.write_text('#!/bin/sh\necho "$1" > "$(dirname "$0")/mark"\nexec cc "$@"\n')
    program.chmod(0o755)
    return program


def test_a_compiler_in_quotes_with_flags_is_run(tmp_path, monkeypatch, exported):
    program = tool(tmp_path / "my tools")
    monkeypatch.setenv("CC", f"'{program}' -pipe")
    assert compiler() == [str(program), "-pipe"]
    compile_process(exported, tmp_path)
    assert (tmp_path / "my tools" / "mark").read_text() == "-pipe\n"


def test_a_compiler_whose_path_has_spaces_needs_no_quotes(tmp_path, monkeypatch):
    program = tool(tmp_path / "my tools")
    monkeypatch.setenv("CC", str(program))
    assert compiler() == [str(program)]


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("nothing-here -O2", "looked for $CC = nothing-here -O2"),
        ("'/my tools/cc' -pipe", "looked for $CC = '/my tools/cc' -pipe"),
        ("'gcc -O2", "$CC = 'gcc -O2: no closing quotation; close the quotation"),
    ],
)
def test_a_compiler_that_is_none_is_said_as_it_was_written(monkeypatch, value, says):
    monkeypatch.setenv("CC", value)
    with pytest.raises(ToolError) as error:
        compiler()
    assert says in str(error.value)


@pytest.mark.parametrize("value", ["", "  "])
def test_no_compiler_named_is_the_systems(monkeypatch, value):
    monkeypatch.setenv("CC", value)
    assert compiler() == ["cc"]


def test_a_compiler_of_another_language_is_understood(tmp_path, monkeypatch, exported):
    program = tool(tmp_path / "tools")
    program.write_text('#!/bin/sh\necho "x.c:1: $LC_ALL error: \\377" >&2\nexit 1\n')
    monkeypatch.setenv("CC", str(program))
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    with pytest.raises(ToolError, match=r"does not compile the folder: x\.c:1: C error: "):
        compile_process(exported, tmp_path)


@pytest.mark.parametrize("name", FOLDERS, ids=lambda name: name[:8])
def test_any_name_of_a_folder_works(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    assert ccgen("export", str(SHOULDER), f"--output={name}") == 0
    assert names(tmp_path) == [name]
    assert ccgen("verify", "--snapshots", "5", "--values", "1000", "--json", "--", name) == 0
    assert capsys.readouterr().err == ""


def test_a_folder_is_measured_whatever_its_name_and_that_of_the_temporary_one(
    tmp_path, monkeypatch, capsys
):
    folder, temporary = tmp_path / "@a, b", tmp_path / "t,m p"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    export(SHOULDER, folder)
    targets = ("--target", "host", "--target", "cortex-m0", "--target", "avr")
    assert ccgen("cost", str(folder), "--json", *targets) == 0
    assert capsys.readouterr().err == ""


def test_trailing_slashes_links_and_dots_lead_to_the_same_folder(tmp_path, monkeypatch, exported):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    (tmp_path / "to_nothing").symlink_to("new")
    for path in ("a/", "./b/../b", "link", "link/", "to_nothing", "x/y/../z"):
        assert ccgen("export", str(SHOULDER), "-o", path) == 0
        assert contents(tmp_path / path) == contents(exported)
    assert (tmp_path / "link").is_symlink()
    assert contents(tmp_path / "real") == contents(tmp_path / "new") == contents(exported)


def test_a_pipe_is_read_once(tmp_path, exported):
    program = f'"{sys.executable}" -m ccgen export <(cat "{SHOULDER}") -o "{tmp_path}/out"'
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert contents(tmp_path / "out") == contents(exported)


def test_a_bridge_takes_its_joint_from_a_pipe(tmp_path):
    program = f'"{sys.executable}" -m ccgen bridge <(cat "{SHOULDER}") --seconds 0.1 --json'
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_current_folder_stays_the_one_a_shell_stands_in(tmp_path, monkeypatch, exported):
    inside = tmp_path / "firmware"
    inside.mkdir()
    monkeypatch.chdir(inside)
    before = inside.stat().st_ino
    for _ in range(2):
        assert ccgen("export", str(SHOULDER), "-o", ".") == 0
        assert contents(inside) == contents(exported)
        assert Path.cwd().stat().st_ino == before == inside.stat().st_ino


def test_a_folder_below_which_a_shell_stands_stays_too(tmp_path, monkeypatch, exported):
    export(SHOULDER, tmp_path / "firmware")
    monkeypatch.chdir(tmp_path / "firmware" / "src")
    assert ccgen("export", str(SHOULDER), "-o", "..") == 0
    assert "shoulder.h" in names(Path())
    assert contents(tmp_path / "firmware") == contents(exported)


def ours(folder: Path) -> bool:
    return True


def fill(folder: Path, **files: str) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def refill(path: Path, **files: str) -> None:
    with new_folder(path, ours) as folder:
        fill(folder, **files)


def test_a_folder_that_stays_loses_what_is_no_longer_in_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fill(tmp_path, **{"a": "old", "gone": "old", "sub/gone": "old", "was_file": "old"})
    fill(tmp_path, **{"was_folder/x": "old"})
    (tmp_path / "link").symlink_to("sub")
    refill(Path(), **{"a": "new", "was_file/x": "new", "was_folder": "new", "deep/er/b": "new"})
    assert {name: data.decode() for name, data in contents(tmp_path).items()} == {
        "a": "new", "was_file/x": "new", "was_folder": "new", "deep/er/b": "new"
    }  # fmt: skip
    assert names(tmp_path) == ["a", "deep", "was_file", "was_folder"]


@pytest.mark.parametrize("failing", range(1, 8))
def test_a_folder_that_stays_is_as_before_when_a_file_cannot_be_moved(
    tmp_path, monkeypatch, failing
):
    monkeypatch.chdir(tmp_path)
    fill(tmp_path, **{"a": "old", "b": "old", "sub/c": "old", "empty/d": "old"})
    before, rename, calls = contents(tmp_path), Path.rename, []

    def flaky(self: Path, target: Path) -> Path:
        calls.append(target)
        if len(calls) == failing:
            raise OSError(errno.EIO, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", flaky)
    with pytest.raises(InputError, match=r"cannot be written \(input/output error\)"):
        refill(tmp_path, **{"a": "new", "sub/e": "new", "new/f": "new"})
    assert contents(tmp_path) == before
    assert names(tmp_path) == ["a", "b", "empty", "sub"]


def test_a_folder_that_stays_survives_a_block_that_fails(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fill(tmp_path, a="old")

    def interrupted() -> None:
        with new_folder(Path(), ours) as folder:
            fill(folder, a="new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert contents(tmp_path) == {"a": b"old"}


def test_a_folder_of_ones_own_below_a_closed_one_is_written(tmp_path, monkeypatch, exported):
    own = tmp_path / "own"
    own.mkdir()
    access = os.access

    def closed(path, mode):  # also for an administrator
        return access(path, mode) and Path(path) != tmp_path

    monkeypatch.setattr(os, "access", closed)
    for _ in range(2):
        export(SHOULDER, own)
        assert contents(own) == contents(exported)
    with pytest.raises(InputError, match=rf"{tmp_path}: cannot be written \(permission denied\)"):
        export(SHOULDER, tmp_path / "new")


def test_a_current_folder_that_is_gone_is_said(tmp_path, monkeypatch):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    shutil.rmtree(gone)
    said = "the current folder is gone; change to one that is there"
    with pytest.raises(InputError, match=f"out: {said}"):
        write_file(Path("out"), b"")
    with pytest.raises(InputError, match=said), new_folder(Path(), ours):
        pytest.fail("the block must not run")


def test_a_file_of_the_longest_name_is_written(tmp_path):
    write_file(tmp_path / ("ä" * 127), b"data")
    assert contents(tmp_path) == {"ä" * 127: b"data"}


def test_what_a_file_is_called_stays_on_the_line_of_its_message(capsys):
    assert ccgen("fit", "a\nb\x1b[31m\u2028.toml") == 2
    err = capsys.readouterr().err
    assert err.startswith(r"ccgen: error: a\nb\x1b[31m\u2028.toml: no such file")
    assert err.count("\n") == 1


NO_PROGRAMS = r": no program may run there; set TMPDIR to a folder where programs may"


@pytest.fixture
def noexec(monkeypatch, tmp_path):
    """A folder that counts as mounted without the right to run programs."""
    real = os.statvfs

    class Mounted:
        f_flag = os.ST_NOEXEC

    monkeypatch.setattr(
        os,
        "statvfs",
        lambda path: Mounted() if tmp_path in (path, *Path(path).parents) else real(path),
    )
    return tmp_path


def test_a_folder_where_no_program_may_run_is_named_with_the_remedy(noexec, exported):
    model, layout = open_exported(exported).model, open_exported(exported).layout
    library, program = noexec / "libjoint.so", noexec / "node"
    library.write_bytes(b"")
    program.write_text("")
    program.chmod(stat.S_IRUSR)
    with pytest.raises(ToolError, match=NO_PROGRAMS):
        JointLibrary(library, model)
    with pytest.raises(ToolError, match=NO_PROGRAMS), library_node(library, layout):
        pytest.fail("the block must not run")
    with pytest.raises(ToolError, match=NO_PROGRAMS), process_node(program):
        pytest.fail("the block must not run")
    with pytest.raises(ToolError, match=NO_PROGRAMS), running_node([str(program)]):
        pytest.fail("the block must not run")
