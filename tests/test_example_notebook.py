"""The notebook of the examples runs as it stands, and tells what it says that it tells."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from ccgen.targets.exported import open_exported

NOTEBOOK = Path(__file__).resolve().parent.parent / "examples" / "notebook"
_NUMBER = re.compile(r"-?\d+\.?\d*")


def code(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def printed(notebook):
    """Texts of all outputs, in order."""
    outputs = [output for cell in code(notebook) for output in cell.outputs]
    return "".join(one.get("text") or one["data"]["text/plain"] for one in outputs)


@pytest.fixture(scope="module")
def stored():
    return nbformat.read(NOTEBOOK / "measured_angles.ipynb", as_version=4)


@pytest.fixture(scope="module")
def executed(stored, tmp_path_factory):
    folder = tmp_path_factory.mktemp("notebook")
    shutil.copytree(NOTEBOOK, folder, dirs_exist_ok=True)
    again = nbformat.from_dict(stored)
    place = {"metadata": {"path": str(folder)}}
    NotebookClient(again, timeout=600, kernel_name="python3", resources=place).execute()
    return folder, again


def test_it_takes_at_most_twenty_lines(stored):
    lines = [line for cell in code(stored) for line in cell.source.splitlines() if line.strip()]
    assert 0 < len(lines) <= 20


def test_it_shows_what_it_gives(stored, executed):
    shown, given = printed(stored), printed(executed[1])
    assert _NUMBER.sub("#", shown) == _NUMBER.sub("#", given)
    numbers = [list(map(float, _NUMBER.findall(text))) for text in (shown, given)]
    assert numbers[0] == pytest.approx(numbers[1], rel=0.2, abs=0.1)


def test_what_it_exports_is_what_it_fitted_to_the_measured_shapes(executed):
    folder, notebook = executed
    cases, measured = (float(x) for x in re.findall(r": (\d\.\d+) degrees RMS", printed(notebook)))
    assert measured < 0.2 * cases
    exported = open_exported(folder / "firmware")
    assert (exported.joint.name, exported.changed) == ("arm", ())
    assert "shapes" in (folder / "firmware" / "manifest.json").read_text()
