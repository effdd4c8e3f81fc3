"""The fit behind an exported folder: made again from what the folder and its manifest name."""

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ccgen.errors import InputError
from ccgen.export.manifest import read_manifest
from ccgen.fixedpoint import Fit
from ccgen.fixedpoint import fit as fitted_to
from ccgen.joint import Joint

if TYPE_CHECKING:
    from ccgen.fixedpoint import FixedPointModel

_CHUNK = 1 << 20


def fitted_folder(directory: Path) -> tuple[Fit, dict[str, str]]:
    """The fit of a folder's joint, and what is to be said of the folder, by title.

    A folder names recordings with their hashes and holds none: they are looked for where its
    joint.toml names them, from the folder itself and from each folder above it.

    Args:
        directory: that `ccgen export` wrote.

    Raises:
        InputError: it was changed; or what its joint was fitted to is not there, or not the same.
    """
    from ccgen.targets.exported import open_exported

    exported = open_exported(directory)
    if exported.changed:
        raise InputError(
            f"{directory}: {', '.join(exported.changed[:3])} changed since it was exported; export "
            "the joint again, or name its joint file"
        )
    inputs = read_manifest(directory).inputs
    if "shapes" in inputs:
        raise InputError(
            f"{directory}: its joint was fitted to shapes that were given in Python, which it does "
            "not hold; write the page there, with ccgen.report(fit, FILE)"
        )
    notes = {"fingerprint of the model": f"{exported.fingerprint:#010x}"}
    if not exported.joint.recordings:
        return fitted_to(exported.joint), notes
    fit = fitted_to(_recorded(exported.joint, directory, inputs))
    return fit, notes | {"weights in the folder": _compared(exported.model, fit.model)}


def _recorded(joint: Joint, directory: Path, hashes: dict[str, str]) -> Joint:
    """The joint with its recordings where they are as they were.

    Raises:
        InputError: naming one that is not there, or not the same.
    """
    names = dict.fromkeys(
        name for own in joint.recordings for name in (own.file, own.counts, own.dbc) if name
    )
    below = directory.resolve()
    changed: list[Path] = []
    missing = next(iter(names))
    for place in (below, *below.parents):
        absent = next((name for name in names if not (place / name).is_file()), None)
        if absent is not None:
            missing = absent
            continue
        other = [place / name for name in names if _sha256(place / name) != hashes.get(name)]
        if not other:
            found = tuple(replace(own, folder=place) for own in joint.recordings)
            return replace(joint, recordings=found)
        changed += other
    if changed:
        raise InputError(
            f"{directory}: {changed[0]} is not the recording that it was fitted to; export the "
            "joint again, or name its joint file"
        )
    raise InputError(
        f"{directory}: was fitted to {missing}, which is neither in it nor in a folder above it, "
        "as its joint.toml names it; put it there, or name the joint file"
    )


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while piece := file.read(_CHUNK):
            digest.update(piece)
    return digest.hexdigest()


def _compared(exported: "FixedPointModel", again: "FixedPointModel") -> str:
    """How weights that were exported differ from those of the fit that the page tells."""
    worst = 0.0
    for axis, own in exported.axes.items():
        other = again.axes[axis]
        one, two = (x.weights * 0.5 ** (x.shift + x.fraction_bits) for x in (own, other))
        worst = max(worst, float(np.abs(one - two).max() / np.abs(two).max()))
    if worst == 0.0:
        return "those that the page tells"
    return f"within {100 * worst:.2g} % of the largest of those that the page tells"
