"""A fit that is kept beside its joint file: what export makes of it, and when it does not."""

import json
from dataclasses import asdict

import numpy as np
import pytest
from joint_files import joint_text
from test_fit_recordings import angle_columns, bends, table

import ccgen
from ccgen.cli.main import main
from ccgen.errors import InputError
from ccgen.export import package
from ccgen.fixedpoint.kept import kept_fit, rounded

LOADS = "[loads]\nsamples = 30\nstiffness = 0.4\ntip_force = [0.0, 2.0]\n"


@pytest.fixture
def joint_file(tmp_path):
    (tmp_path / "run.csv").write_text(table(angle_columns(bends(0), bends(1))))
    path = tmp_path / "shoulder.toml"
    tables = f'{LOADS}[[recordings]]\nfile = "run.csv"\n'
    path.write_text(joint_text(transducer="noise = 1e-5", tables=tables))
    return path


def files_of(folder):
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def ran(*words, status=0):
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    assert (ended.value.code or 0) == status


def test_export_takes_the_kept_fit_and_fits_nothing(joint_file, tmp_path, monkeypatch, capsys):
    ran("fit", joint_file, "--write", "--json")
    told = json.loads(capsys.readouterr().out)
    monkeypatch.setattr(package, "fit", None)
    ran("export", joint_file, "-o", tmp_path / "a")
    assert "the fit is that of" in capsys.readouterr().err
    kept = kept_fit(ccgen.load(joint_file)).fit
    assert [asdict(row) | {"stations": None} for row in kept.errors] == [
        row | {"stations": None} for row in told["errors"]
    ]
    assert list(kept.warnings) == told["warnings"]
    for axis, figures in told["axes"].items():
        np.testing.assert_array_equal(kept.weights[axis].matrix, figures["weights"])
        digits = {f"{weight:.12g}" for row in figures["weights"] for weight in row}
        assert {repr(float(text)) for text in digits} == {
            repr(weight) for row in figures["weights"] for weight in row
        }


def test_the_kept_fit_is_the_one_that_was_told(joint_file):
    fitted = rounded(ccgen.fit(ccgen.load(joint_file)))
    ran("fit", joint_file, "--write", "--json")
    kept = kept_fit(ccgen.load(joint_file)).fit
    assert kept.sensors == fitted.sensors
    counts = np.random.default_rng(0).integers(-300, 300, (50, 6))
    np.testing.assert_array_equal(kept.model.estimate(counts), fitted.model.estimate(counts))
    absent = np.zeros_like(counts, dtype=bool)
    absent[:, 1] = True
    np.testing.assert_array_equal(
        kept.guarded.estimate(counts, absent), fitted.guarded.estimate(counts, absent)
    )
    gone, bound = np.where(absent, np.nan, counts), 1e-2 * fitted.joint.geometry.range_of_motion
    assert np.abs(kept.estimate(gone).u - fitted.estimate(gone).u).max() < bound
    assert kept.checks.sensors == fitted.checks.sensors
    assert [asdict(row) for row in kept.without] == [asdict(row) for row in fitted.without]
    assert [asdict(row) for _, row in kept.left] == [asdict(row) for _, row in fitted.left]


def test_the_same_files_give_the_same_bytes(joint_file, tmp_path):
    ran("fit", joint_file, "--write", "--json")
    first = joint_file.with_name("shoulder.fit.json").read_bytes()
    ran("export", joint_file, "-o", tmp_path / "a")
    ran("fit", joint_file, "--write", "--json")
    assert joint_file.with_name("shoulder.fit.json").read_bytes() == first
    ran("export", joint_file, "-o", tmp_path / "b")
    assert files_of(tmp_path / "a") == files_of(tmp_path / "b")
    inputs = json.loads((tmp_path / "a/manifest.json").read_text())["inputs"]
    assert set(inputs) == {"joint.toml", "run.csv", "shoulder.fit.json"}


def test_a_fit_that_is_older_than_a_recording_is_not_used(joint_file, tmp_path, capsys):
    ran("fit", joint_file, "--write", "--json")
    with (tmp_path / "run.csv").open("a") as file:
        file.write(",".join(["0.5"] * 24) + "\n")
    ran("export", joint_file, "-o", tmp_path / "a")
    said = capsys.readouterr().err
    assert "shoulder.fit.json: is older than run.csv and not used" in said
    assert "shoulder.fit.json" not in (tmp_path / "a/manifest.json").read_text()
    joint_file.write_text(joint_file.read_text() + "\n# another comment\n")
    assert "is older than joint.toml" in kept_fit(ccgen.load(joint_file)).note


@pytest.mark.parametrize("spoilt", ["", "[1]", '{"tool": "ccgen", "kept": 2}'])
def test_a_damaged_fit_is_one_line(joint_file, tmp_path, capsys, spoilt):
    joint_file.with_name("shoulder.fit.json").write_text(spoilt)
    ran("export", joint_file, "-o", tmp_path / "a", status=2)
    said = capsys.readouterr().err
    assert "shoulder.fit.json: damaged" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "a").exists()


def test_a_fit_of_another_form_is_not_used(joint_file):
    joint_file.with_name("shoulder.fit.json").write_text('{"tool": "ccgen", "kept": 0}')
    kept = kept_fit(ccgen.load(joint_file))
    assert kept.fit is None
    assert "is of another ccgen and not used" in kept.note


def test_what_is_kept_follows_the_joint_file_alone(joint_file, capsys):
    ran("fit", joint_file, "--write", "--method", "wam", status=2)
    assert "--method: takes no part in what --write keeps" in capsys.readouterr().err
    assert not joint_file.with_name("shoulder.fit.json").exists()


def test_a_joint_without_a_file_keeps_nothing(joint_file):
    text = joint_file.read_text()
    assert kept_fit(ccgen.parse(text, folder=joint_file.parent)) is None


def test_a_recording_that_is_gone_is_said_before_anything_is_written(joint_file, tmp_path, capsys):
    ran("fit", joint_file, "--write", "--json")
    (tmp_path / "run.csv").unlink()
    ran("export", joint_file, "-o", tmp_path / "a", status=2)
    assert "run.csv: no such file" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"run\.csv: no such file"):
        kept_fit(ccgen.load(joint_file))
