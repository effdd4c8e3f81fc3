import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from waiting import PATIENCE

from ccgen.errors import InputError
from ccgen.outputs import new_folder, write_file


def ours(folder: Path) -> bool:
    return {file.name for file in folder.iterdir()} <= {"a", "b"}


def fill(folder: Path, **files: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def content(folder: Path) -> dict[str, str]:
    return {
        str(file.relative_to(folder)): file.read_text()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def rebuild(out: Path, meanwhile: Callable[[], object] = lambda: None) -> None:
    with new_folder(out, ours) as folder:
        fill(folder, a="new")
        meanwhile()


def fail_with(exception: BaseException) -> Callable[[], None]:
    def fail() -> None:
        raise exception

    return fail


def test_a_file_is_written_with_the_folders_above_it(tmp_path):
    write_file(tmp_path / "x" / "y" / "f", b"data")
    assert content(tmp_path) == {"x/y/f": "data"}


def test_a_file_replaces_an_older_one_and_keeps_a_link_to_it(tmp_path):
    (tmp_path / "f").write_text("old")
    (tmp_path / "link").symlink_to("f")
    write_file(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert content(tmp_path) == {"f": "new", "link": "new"}


def test_a_file_gets_the_permissions_of_any_new_file(tmp_path):
    (tmp_path / "plain").write_text("")
    write_file(tmp_path / "f", b"")
    assert (tmp_path / "f").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    (tmp_path / "f").write_text("old")

    def full(self: Path, target: Path) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(InputError, match=r"cannot be written \(no space left on device\)"):
        write_file(tmp_path / "f", b"new")
    assert content(tmp_path) == {"f": "old"}


@pytest.mark.parametrize("target", ["/dev/null", "."])
def test_what_is_no_file_is_not_replaced(target):
    with pytest.raises(InputError, match="is not a file; choose another name"):
        write_file(Path(target), b"data")
    assert Path(target).exists()
    assert not Path(target).is_file()


def test_a_folder_appears_once_it_is_complete(tmp_path):
    with new_folder(tmp_path / "x" / "out", ours) as folder:
        fill(folder, a="1")
        assert not (tmp_path / "x" / "out").exists()
    assert content(tmp_path) == {"x/out/a": "1"}


def test_a_folder_of_ours_is_replaced_whole(tmp_path):
    out = fill(tmp_path / "out", a="old", b="old")
    rebuild(out)
    assert content(tmp_path) == {"out/a": "new"}


def test_an_empty_folder_is_anybodys(tmp_path):
    (tmp_path / "out").mkdir()
    with new_folder(tmp_path / "out", lambda folder: False) as folder:
        fill(folder, a="new")
    assert content(tmp_path) == {"out/a": "new"}


def test_a_foreign_folder_is_refused_and_left_alone(tmp_path):
    out = fill(tmp_path / "out", a="old", thesis="precious")
    with pytest.raises(InputError, match="out: was not written by ccgen"), new_folder(out, ours):
        pytest.fail("the block must not run")
    assert content(tmp_path) == {"out/a": "old", "out/thesis": "precious"}


def test_a_foreign_file_that_comes_meanwhile_is_not_lost(tmp_path):
    out = fill(tmp_path / "out", a="old")
    with pytest.raises(InputError, match="not written by ccgen"):
        rebuild(out, lambda: fill(out, thesis="precious"))
    assert content(tmp_path) == {"out/a": "old", "out/thesis": "precious"}


def test_a_file_in_the_folders_place_is_refused(tmp_path):
    (tmp_path / "out").write_text("old")
    with pytest.raises(InputError, match="out: is a file"), new_folder(tmp_path / "out", ours):
        pytest.fail("the block must not run")


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt, SystemExit])
def test_the_old_folder_survives_whole_when_the_block_fails(tmp_path, failure):
    out = fill(tmp_path / "out", a="old", b="old")
    with pytest.raises(failure):
        rebuild(out, fail_with(failure()))
    assert content(tmp_path) == {"out/a": "old", "out/b": "old"}


def test_folders_made_above_are_taken_back_when_the_block_fails(tmp_path):
    with pytest.raises(ValueError, match="wrong"):
        rebuild(tmp_path / "x" / "y" / "out", fail_with(ValueError("wrong")))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("failing", [1, 2])
def test_the_old_folder_survives_whole_when_a_rename_fails(tmp_path, monkeypatch, failing):
    out = fill(tmp_path / "out", a="old")
    calls = []
    rename = Path.rename

    def flaky(self: Path, target: Path) -> Path:
        calls.append(target)
        if len(calls) == failing:
            raise OSError(5, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", flaky)
    with pytest.raises(InputError, match="input/output error"):
        rebuild(out)
    assert content(tmp_path) == {"out/a": "old"}


def test_ctrl_c_between_the_renames_waits_for_the_new_folder(tmp_path, monkeypatch):
    out = fill(tmp_path / "out", a="old")
    rename = Path.rename

    def interrupted(self: Path, target: Path) -> Path:
        moved = rename(self, target)
        signal.raise_signal(signal.SIGINT)
        return moved

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        rebuild(out)
    assert content(tmp_path) == {"out/a": "new"}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_the_old_folder_and_nothing_else(tmp_path, number):
    fill(tmp_path / "out", a="old")
    program = (
        "import time\n"
        "from pathlib import Path\n"
        "from ccgen.outputs import new_folder\n"
        "with new_folder(Path('out'), lambda folder: True) as folder:\n"
        "    (folder / 'a').write_text('new')\n"
        "    print('ready', flush=True)\n"
        "    time.sleep(600)\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program], cwd=tmp_path, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    process.send_signal(number)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == (-number if number == signal.SIGINT else 128 + number)
    assert content(tmp_path) == {"out/a": "old"}


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "out", Path("/proc/ccgen/out")):
        with pytest.raises(InputError, match=f"{path.parent}: cannot be written"):
            write_file(path, b"")
        with (
            pytest.raises(InputError, match=f"{path.parent}: cannot be written"),
            new_folder(path, ours),
        ):
            pytest.fail("the block must not run")


def test_a_read_only_folder_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # also for an administrator
    with pytest.raises(InputError, match=f"{tmp_path}: cannot be written .permission denied."):
        write_file(tmp_path / "f", b"")
    assert list(tmp_path.iterdir()) == []


def test_outputs_work_outside_the_main_thread(tmp_path):
    from concurrent.futures import ThreadPoolExecutor

    def make() -> None:
        for text in ("old", "new"):
            with new_folder(tmp_path / "out", ours) as folder:
                fill(folder, a=text)

    with ThreadPoolExecutor() as pool:
        pool.submit(make).result()
    assert content(tmp_path) == {"out/a": "new"}
