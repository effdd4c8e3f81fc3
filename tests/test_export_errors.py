"""What an exported folder tells of the errors of its estimate."""

import re

import numpy as np
import pytest
from joint_files import joint_text
from test_fit_recordings import angle_columns, bends, recorded
from test_without import JOINTS

import ccgen
from ccgen.export.package import render


def folder_of(fitted):
    _, files = render(fitted)
    return {path: data.decode() for path, data in files.items() if path.endswith((".md", ".h"))}


def rows_behind(readme, start):
    """Cells of the first table behind a text, by their titles."""
    behind = readme[readme.index(start) :].split("\n\n")[1].splitlines()
    titles, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in behind)
    return [dict(zip(titles, cells, strict=True)) for cells in rows]


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


@pytest.mark.parametrize("name", ["shoulder", "nine, precision 16", "planar, noise"])
def test_the_readme_tells_what_each_sensor_lost_leaves_beside_what_all_give(name):
    fitted = ccgen.fit(ccgen.parse(JOINTS[name]))
    rows = rows_behind(folder_of(fitted)["README.md"], "While one sensor is missing")
    whole = next(row for row in fitted.errors if row.noise and row.source == "cases")
    told = [("none", whole), *((row.sensor, row) for row in fitted.without)]
    for cells, (sensor, row) in zip(rows, told, strict=True):
        assert cells["missing"] == sensor
        for axis, rms in row.rms_deg.items():
            assert cells[f"{axis}: RMS of a segment, °"] == f"{rms:.3g}"
        assert cells["tip, RMS, mm"] == f"{1e3 * row.tip_rms_m:.3g}"
        if row.elongation_rms_percent is not None:
            assert cells["elongation, RMS, %"] == f"{row.elongation_rms_percent:.3g}"
    assert ("elongation, RMS, %" in rows[0]) == ("h" in fitted.joint.axes)


def test_a_section_that_elongates_errs_by_its_own_share_of_its_own_length():
    fitted = ccgen.fit(ccgen.parse(JOINTS["nine, precision 16"]))
    rows = rows_behind(folder_of(fitted)["README.md"], "While one sensor is missing")
    lengths = 1e3 * fitted.joint.geometry.segment_length * np.array([4, 8])
    shares = [
        fitted.standard_deviations.axes["h"],
        *(row.deviations["h"] for row in fitted.without),
    ]
    for cells, own in zip(rows, shares, strict=True):
        expected = np.sqrt(np.mean(np.square(np.array(own) * lengths)))
        assert float(cells["of a section, RMS, mm"]) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("name", ["shoulder", "nine, precision 16", "planar, noise"])
def test_the_header_holds_the_standard_deviations_while_a_sensor_is_missing(name):
    fitted = ccgen.fit(ccgen.parse(JOINTS[name]))
    joint = fitted.joint
    header = folder_of(fitted)[f"src/{joint.name}.h"]
    found = dict(re.findall(r"#define \w+?_STD_(\w+_WITHOUT_\w+) {?([\d, ]+)", header))
    expected = {}
    for j, row in enumerate(fitted.without):
        for axis, values in row.deviations.items():
            if j in range(*joint.own(axis).indices(len(joint.sensors))):
                steps = np.ceil(np.ldexp(values, fitted.model.axis(axis).fraction_bits))
                told = ", ".join(f"{step:.0f}" for step in steps)
                expected[f"{axis.upper()}_STEPS_WITHOUT_{row.sensor.upper()}"] = told
        expected[f"TIP_UM_WITHOUT_{row.sensor.upper()}"] = f"{np.ceil(1e6 * row.tip_rms_m):.0f}"
    assert found == expected


def test_the_only_sensor_that_tells_an_axis_is_told_to_lose_it():
    text = joint_text(tables='[estimator]\nmethod = "wam"\n[sensors.v]\ncount = 1')
    files = folder_of(ccgen.fit(ccgen.parse(text)))
    *_, row = rows_behind(files["README.md"], "While one sensor is missing")
    assert list(row.values())[0::2] == ["v0", "lost"]
    assert row["tip, RMS, mm"] == "not known"
    assert "/* Lost without v0: v */" in files["src/shoulder.h"]
    assert "WITHOUT_V0" not in files["src/shoulder.h"]


def test_where_nothing_serves_nothing_is_told_of_it():
    files = folder_of(ccgen.fit(ccgen.parse(joint_text(tables="[estimator]\nfallback = false"))))
    assert "While one sensor is missing" not in files["README.md"]
    assert "WITHOUT" not in files["src/shoulder.h"]
