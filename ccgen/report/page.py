"""The page: a fit, its pictures and its tables, in one file that needs nothing else."""

from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from ccgen import __version__, resources
from ccgen.errors import InputError
from ccgen.figures.bands import bands_figure
from ccgen.figures.matrix import matrix_figure
from ccgen.figures.strings import strings_figure, unrolled_figure
from ccgen.figures.style import figure_svg
from ccgen.figures.trends import noise_figure, sensors_figure
from ccgen.figures.worst import worst_figure
from ccgen.fixedpoint import Fit
from ccgen.fixedpoint import fit as fitted_to
from ccgen.joint import Joint
from ccgen.joint.file import load
from ccgen.outputs import write_file
from ccgen.report.tables import (
    Table,
    bus,
    checks,
    errors,
    facts,
    fixed_point,
    sensors,
    stations,
    warnings,
    without,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def report(subject: Fit | Joint | str | Path, output: str | Path, cost: bool = False) -> Path:
    """Write the page of a joint.

    Args:
        subject: a fit, a joint, the path of its file, or of a folder that was exported from it.
        output: the file to write.
        cost: whether it tells what the firmware costs on each core whose tools are installed.

    Raises:
        InputError: the joint cannot be fitted; or a folder that was changed since it was exported,
            or whose recordings are not at hand.
        ToolError: nothing that measures costs is installed.
    """
    fit, notes = _fitted(subject)
    path = Path(output)
    write_file(path, page(fit, notes, _costs(fit) if cost else None))
    return path


def page(fit: Fit, notes: dict[str, str] | None = None, costs: Table | None = None) -> bytes:
    """The page as HTML; the same fit gives the same bytes.

    Args:
        fit: of the joint.
        notes: more to say of where it comes from, by title.
        costs: of its firmware, a row a core.
    """
    of_joint, of_recordings = warnings(fit)
    html = resources.template("joint_report.html.j2").render(
        name=fit.joint.name,
        facts=facts(fit),
        warnings=of_joint,
        notes=of_recordings,
        errors=errors(fit),
        stations=stations(fit),
        without=without(fit),
        fallback=fit.sensed.fallback,
        checks=checks(fit),
        check_notes=fit.checks.notes,
        false_alarms=f"{fit.joint.false_alarms:g}",
        fixed_point=fixed_point(fit),
        bus=bus(fit),
        costs=costs,
        sensors=sensors(fit),
        told_on=fit.stated.name,
        pictures={name: _svg(figure) for name, figure in _figures(fit).items()},
        provenance=_provenance(fit) | (notes or {}),
    )
    return html.encode()


def _figures(fit: Fit) -> "dict[str, Figure]":
    figures = {
        "strings": strings_figure(fit.sensed),
        "unrolled": unrolled_figure(fit.sensed),
        "weights": matrix_figure(fit),
        "bands": bands_figure(fit),
        "worst": worst_figure(fit),
        "count": sensors_figure(fit),
    }
    noise = noise_figure(fit)
    return figures if noise is None else figures | {"noise": noise}


def _svg(figure: "Figure") -> str:
    return figure_svg(figure)


def _costs(fit: Fit) -> Table:
    """What the exported folder costs on each core."""
    from ccgen.cost.costs import cost
    from ccgen.cost.readme import main_table
    from ccgen.export.package import export

    with TemporaryDirectory() as folder:
        directory = export(fit, Path(folder) / fit.joint.name).directory
        titles, rows = main_table(cost(directory).targets)
        return Table(titles, tuple(rows))


def _provenance(fit: Fit) -> dict[str, str]:
    joint = fit.joint
    found = {"ccgen": __version__}
    if joint.content:
        found["joint file, SHA-256"] = sha256(joint.content).hexdigest()
    if joint.calibration_content:
        found["calibration, SHA-256"] = sha256(joint.calibration_content).hexdigest()
    for recording in fit.recordings:
        found |= {f"{name}, SHA-256": digest for name, digest in recording.hashes}
    return found


def _fitted(subject: Fit | Joint | str | Path) -> tuple[Fit, dict[str, str]]:
    if isinstance(subject, Fit):
        return subject, {}
    if isinstance(subject, Joint):
        return fitted_to(subject), {}
    path = Path(subject)
    if not path.exists():
        raise InputError(f"{path}: no such folder or joint file")
    if not path.is_dir():
        return fitted_to(load(path)), {}
    from ccgen.report.folder import fitted_folder

    return fitted_folder(path)
