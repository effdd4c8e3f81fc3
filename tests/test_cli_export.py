import json

import pytest
from joint_files import joint_text
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.digits import at_least


def run(folder, can, *options):
    text = joint_text("trunk", 48, 6, precision=32, bits=24, step=1e-6, tables=f"[can]\n{can}")
    (folder / "trunk.toml").write_text(text)
    command = ["export", str(folder / "trunk.toml"), "-o", str(folder / "out"), *options]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.stderr
    return result


def test_json_holds_formats_and_files(tmp_path):
    answer = json.loads(run(tmp_path, "cycle_ms = 20", "--json").stdout)
    assert answer["directory"] == str(tmp_path / "out")
    assert "src/trunk.c" in answer["files"]
    for axis in answer["fixed_point"].values():
        assert axis["headroom_bits"] >= 1
        assert 0.0 < axis["rms_error_percent_rom"] < axis["worst_error_percent_rom"] <= 1e-5


# 48 segments at 32 bits: 6 frames in and 98 out, 135 or 160 bits each.
@pytest.mark.parametrize(
    ("can", "percent", "remedy"),
    [
        ("", 140.4, "15 or more, a higher can.bitrate, or can.fd = true would fit"),
        ("extended = true", 166.4, "17 or more"),
        ("fd = true\nbitrate = 500_000", 111.8, "or bit-rate switching would fit"),
        ("cycle_ms = 15", 93.6, None),
    ],
)
def test_frames_that_a_cycle_cannot_hold_are_a_warning(tmp_path, can, percent, remedy):
    result = run(tmp_path, f'publish = ["angles", "tip", "status"]\n{can}', "--json")
    assert json.loads(result.stdout)["bus_load_percent"] == pytest.approx(percent)
    assert f"{at_least(percent)} % of the time" in (tmp_path / "out" / "README.md").read_text()
    if remedy is None:
        assert result.stderr == ""
    else:
        assert "trunk.toml: can.cycle_ms: the " in result.stderr
        assert remedy in result.stderr
        assert result.stderr.count("\n") == 1


def test_the_table_tells_formats_load_and_what_comes_next(tmp_path):
    said = " ".join(run(tmp_path, "cycle_ms = 20").stdout.split())
    assert "104 frames every 20 ms take at most 70 % of a bus at 1,000,000 bit/s" in said
    assert f"Next: ccgen verify {tmp_path / 'out'}" in said
