"""The example of the guide on calibration gives what the guide says."""

import re
import runpy
import shutil
from pathlib import Path

import pytest

import ccgen
from ccgen.cli.main import main

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "examples" / "calibration"
_NUMBER = re.compile(r"-?\d+\.\d+")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The example's folder with what record.py wrote, and what it gave the sensors."""
    folder = tmp_path_factory.mktemp("example")
    shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
    return folder, runpy.run_path(str(folder / "record.py"))


def test_what_the_script_invents_is_found(made):
    folder, truth = made
    found = ccgen.calibrate(folder / "finger.toml")
    gains = truth["STEP"] / truth["GAIN"]
    for one, gain, zero in zip(found.calibration.sensors, gains, truth["ZERO"], strict=True):
        assert one.metres_per_count == pytest.approx(gain, abs=2 * one.metres_per_count_std)
        assert one.zero == pytest.approx(zero, abs=2 * one.zero_std)
        assert one.noise == pytest.approx(truth["NOISE"], abs=3 * one.noise_std)
    assert found.calibration.delay == pytest.approx(truth["DELAY"], abs=1e-3)


def test_the_guide_shows_what_is_printed(made, monkeypatch, capsys):
    monkeypatch.chdir(made[0])
    monkeypatch.setenv("COLUMNS", "100")
    with pytest.raises(SystemExit):
        main(["calibrate", "finger.toml"])
    out, err = capsys.readouterr()
    guide = (ROOT / "docs" / "calibration.md").read_text(encoding="utf-8")
    for line in err.splitlines():
        assert line in guide
    shown = guide[guide.index("finger: sensors") : guide.index("ccgen: wrote")]
    printed = "\n".join(line.rstrip() for line in out.splitlines())
    assert _NUMBER.sub("#", printed).split() == _NUMBER.sub("#", shown).split()
    for told, given in zip(_NUMBER.findall(shown), _NUMBER.findall(printed), strict=True):
        assert float(told) == pytest.approx(float(given), rel=0.02)
