"""Files and folders that appear whole or not at all.

Everything is written beside its destination and renamed into place, so a failed or interrupted
run leaves what was there, and nothing besides. A folder that cannot give way, because somebody
stands in it, because it is mounted, or because the folder above is closed to us, keeps its place:
then its files are exchanged one by one, or, where that fails, put back.
"""

import os
import secrets
import shutil
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import FrameType

from ccgen.errors import InputError


def write_file(path: Path, data: bytes) -> None:
    """Write a file, replacing an older one in one step; missing folders above it are made.

    Raises:
        InputError: the place cannot be written, or something else than a file is there.
    """
    path = _resolved(path)
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is not a file; choose another name")
    with _parent(path), interruptible(), _beside(path) as temporary, _explained(path.parent):
        temporary.write_bytes(data)
        temporary.replace(path)


@contextmanager
def new_folder(path: Path, is_ours: Callable[[Path], bool]) -> Iterator[Path]:
    """Give an empty folder to fill, and put it at `path` once the block has ended well.

    A folder that is already there survives whole when the block raises or is interrupted, by
    Ctrl-C or by SIGTERM (which ends the program with status 143).

    Args:
        path: the destination; missing folders above it are made.
        is_ours: whether the folder that is there may be replaced; asked before the block and
            again after it, and free to raise an InputError that says more.

    Raises:
        InputError: the place cannot be written, or what is there is not ours.
    """
    path = _resolved(path)
    _check_replaceable(path, is_ours)
    if path.is_dir() and _stays(path):
        with interruptible(), tempfile.TemporaryDirectory(prefix="ccgen-") as apart:
            yield Path(apart)
            _check_replaceable(path, is_ours)
            with _explained(path):
                _refill(path, Path(apart))
        return
    with _parent(path), interruptible(), _beside(path) as temporary:
        with _explained(path.parent):
            temporary.mkdir()
        yield temporary
        _check_replaceable(path, is_ours)
        with _explained(path.parent):
            _swap(temporary, path)


def _check_replaceable(path: Path, is_ours: Callable[[Path], bool]) -> None:
    if not path.exists():
        return
    if not path.is_dir():
        raise InputError(f"{path}: is a file; choose another folder")
    if any(path.iterdir()) and not is_ours(path):
        raise InputError(f"{path}: was not written by ccgen; choose another folder or remove it")


def _resolved(path: Path) -> Path:
    try:
        return Path(os.path.realpath(path))
    except FileNotFoundError:  # of the current folder
        raise InputError(
            f"{path}: the current folder is gone; change to one that is there"
        ) from None


def _stays(folder: Path) -> bool:
    """Whether a folder cannot give way to another: see the module."""
    above = os.access(folder.parent, os.W_OK | os.X_OK)
    return not above or os.path.ismount(folder) or _resolved(Path()).is_relative_to(folder)


def _refill(folder: Path, new: Path) -> None:
    """Put the files of `new` in the place of those in a folder, which stays; all or none."""
    with _beside(folder / "new") as stage:
        shutil.copytree(new, stage / "new")
        (stage / "old").mkdir()
        with _held_signals():
            _exchange(folder, stage)


def _exchange(folder: Path, stage: Path) -> None:
    """Move a folder's files to stage/old and those of stage/new to it; undone where that fails."""
    undo: list[Callable[[], object]] = []

    def move(source: Path, target: Path) -> None:
        for above in reversed([above for above in target.parents if not above.exists()]):
            above.mkdir()
            undo.append(above.rmdir)
        source.rename(target)
        undo.append(partial(target.rename, source))

    wanted = {p.relative_to(stage / "new") for p in (stage / "new").rglob("*") if p.is_dir()}
    try:
        for path in _below(folder, stage):
            if path.is_symlink() or not path.is_dir():
                move(path, stage / "old" / path.relative_to(folder))
            elif path.relative_to(folder) not in wanted:
                path.rmdir()
                undo.append(path.mkdir)
        for path in _below(stage / "new", stage / "old"):
            if path.is_symlink() or not path.is_dir():
                move(path, folder / path.relative_to(stage / "new"))
    except BaseException:
        for step in reversed(undo):
            step()
        raise


def _below(folder: Path, but: Path) -> Iterator[Path]:
    """Everything below a folder, what is in a folder before it, without one of them."""
    for path in sorted(folder.iterdir()):
        if path == but:
            continue
        if path.is_dir() and not path.is_symlink():
            yield from _below(path, but)
        yield path


def _swap(new: Path, path: Path) -> None:
    """Rename `new` to `path`; what is there gives way and comes back if that fails."""
    if not path.exists():
        new.rename(path)
        return
    with _beside(path) as old, _held_signals():
        path.rename(old)
        try:
            new.rename(path)
        except BaseException:
            old.rename(path)
            raise


@contextmanager
def _beside(path: Path) -> Iterator[Path]:
    """Give a name beside `path` that is free, and remove what is there in the end."""
    temporary = path.with_name(f".ccgen-{secrets.token_hex(4)}")  # of no longer a name than fits
    try:
        yield temporary
    finally:
        if temporary.is_dir():
            shutil.rmtree(temporary, ignore_errors=True)
        else:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


@contextmanager
def _parent(path: Path) -> Iterator[None]:
    """Make the folders above `path` that are missing; take them back if the block fails."""
    missing = [folder for folder in path.parents if not folder.exists()]
    try:
        with _explained(path.parent):
            path.parent.mkdir(parents=True, exist_ok=True)
            if not path.parent.is_dir() or not os.access(path.parent, os.W_OK | os.X_OK):
                raise PermissionError(None, "permission denied")
        yield
    except BaseException:
        for folder in missing:
            with suppress(OSError):
                folder.rmdir()
        raise


@contextmanager
def _explained(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"{folder}: cannot be written ({reason}); choose a folder you may write to"
        ) from error


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGTERM end the program by way of the clean-up, where nobody else handles it."""
    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    )
    if not ours:
        yield
        return
    signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


@contextmanager
def _held_signals() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back until the block has ended."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    arrived: list[int] = []
    handlers = {
        number: signal.signal(number, lambda signum, frame: arrived.append(signum))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for signal_number, handler in handlers.items():
            signal.signal(signal_number, handler or signal.SIG_DFL)
        for arrival in arrived:
            signal.raise_signal(arrival)


def terminate(signum: int, frame: FrameType | None) -> None:
    """Handle SIGTERM: leave by way of every clean-up, with the status that a shell gives to it."""
    raise SystemExit(128 + signum)
