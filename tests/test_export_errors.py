"""What an exported folder tells of the errors of its estimate."""

import re

import numpy as np
import pytest
from joint_files import joint_text
from test_fit_recordings import angle_columns, bends, recorded

import ccgen
from ccgen.export.package import render


def folder_of(fitted):
    _, files = render(fitted)
    return {path: data.decode() for path, data in files.items() if path.endswith((".md", ".h"))}


@pytest.fixture
def fitted(tmp_path):
    return ccgen.fit(recorded(tmp_path, {"run.csv": angle_columns(bends(0), bends(1))}))


def test_the_readme_tells_a_row_for_each_source(fitted):
    readme = folder_of(fitted)["README.md"]
    told = {row.source: row for row in fitted.errors if row.noise}
    plain = {row.source: row for row in fitted.errors if not row.noise}
    for source, row in told.items():
        name = source + (" (held out)" if row.held_out else "")
        (line,) = re.findall(rf"^\| {re.escape(name)} \| (.*) \|$", readme, re.MULTILINE)
        mean, worst = line.split(" | ")[0], line.split(" | ")[-1]
        assert (
            mean == f"{plain[source].mean_percent_rom['u']:.3g} / {row.mean_percent_rom['u']:.3g}"
        )
        assert worst == f"{1e3 * plain[source].tip_max_m:.3g} / {1e3 * row.tip_max_m:.3g}"


def test_the_header_holds_the_standard_deviation_of_every_angle_and_of_the_tip(fitted):
    header = folder_of(fitted)["src/shoulder.h"]
    found = fitted.recorded.judged(0, True)
    for axis in ("u", "v"):
        (steps,) = re.findall(rf"SHOULDER_STD_{axis.upper()}_STEPS {{(.*)}}", header)
        rms = np.sqrt(np.mean(np.square(found.known(axis)) + np.square(found.spread(axis)), axis=0))
        expected = np.ceil(np.ldexp(rms, fitted.model.axis(axis).fraction_bits))
        assert [int(step) for step in steps.split(", ")] == expected.tolist()
    (tip,) = re.findall(r"SHOULDER_STD_TIP_UM (\d+)", header)
    known, spread = found.tip
    assert int(tip) == np.ceil(1e6 * np.sqrt(np.mean(known**2 + spread**2)))
    assert "on\n * recording:run.csv" in header


def test_the_same_is_told_of_a_joint_without_recordings():
    fitted = ccgen.fit(ccgen.parse(joint_text(transducer="noise = 1e-5")))
    files = folder_of(fitted)
    assert "| other loads (held out) |" in files["README.md"]
    assert "SHOULDER_STD_U_STEPS" in files["src/shoulder.h"]
