"""The manifest: what wrote a folder, from what, and the fingerprint of every file in it."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from ccgen import FORMAT_VERSION, __version__
from ccgen.errors import InputError
from ccgen.outputs import write_file

FILE_NAME = "manifest.json"


@dataclass(frozen=True)
class Manifest:
    """What ccgen noted of a folder that it wrote.

    Attributes:
        joint: name of the joint.
        format: version of what generator and C runtime agree on.
        inputs: SHA-256 of what the folder was made from, by name.
        files: SHA-256 of what was written, by path below the folder.
    """

    joint: str
    format: int
    inputs: dict[str, str]
    files: dict[str, str]


def manifest_json(name: str, inputs: dict[str, str], files: dict[str, bytes]) -> str:
    """Return the manifest's text.

    Args:
        name: of the joint.
        inputs: SHA-256 of what the folder was made from, by name.
        files: content by path below the folder, without the manifest itself.
    """
    record = {
        "tool": "ccgen",
        "version": __version__,
        "format": FORMAT_VERSION,
        "joint": name,
        "inputs": {one: inputs[one] for one in sorted(inputs)},
        "files": {path: hashlib.sha256(files[path]).hexdigest() for path in sorted(files)},
    }
    return json.dumps(record, indent=1) + "\n"


def read_manifest(directory: Path) -> Manifest:
    """What ccgen noted of a folder.

    Raises:
        InputError: there is no manifest, or it is not one of ccgen's.
    """
    path = directory / FILE_NAME
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        if record["tool"] != "ccgen":
            raise ValueError("not written by ccgen")
        return Manifest(
            joint=str(record["joint"]),
            format=int(record["format"]),
            inputs=_texts(record["inputs"]),
            files=_texts(record["files"]),
        )
    except OSError as error:
        raise InputError(
            f"{path}: {error.strerror}; name a folder that `ccgen export` wrote"
        ) from error
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: damaged ({error}); export the joint again") from error


def _texts(record: object) -> dict[str, str]:
    if not isinstance(record, dict):
        raise TypeError("a list of files is none")
    return {str(name): str(digest) for name, digest in record.items()}


def replace_file(directory: Path, path: str, content: bytes) -> None:
    """Replace a listed file, and its fingerprint in the manifest.

    Raises:
        InputError: the folder has no manifest of ccgen's, or cannot be written.
    """
    read_manifest(directory)
    manifest = directory / FILE_NAME
    record = json.loads(manifest.read_text(encoding="utf-8"))
    record["files"][path] = hashlib.sha256(content).hexdigest()
    write_file(directory / path, content)
    write_file(manifest, (json.dumps(record, indent=1) + "\n").encode("utf-8"))


def foreign_files(directory: Path) -> list[str]:
    """Paths in the folder that its manifest does not list; all of them without a manifest."""
    present = sorted(
        file.relative_to(directory).as_posix()
        for file in directory.rglob("*")
        if not file.is_dir() or file.is_symlink()
    )
    try:
        known = {*read_manifest(directory).files, FILE_NAME}
    except InputError:
        known = set()
    return [file for file in present if file not in known]


def changed_files(directory: Path) -> list[str]:
    """Listed files that are gone or differ from what was written."""
    return [
        file
        for file, digest in read_manifest(directory).files.items()
        if not (directory / file).is_file()
        or hashlib.sha256((directory / file).read_bytes()).hexdigest() != digest
    ]
