import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation",
         "--wheel-dir", folder, ROOT],
        check=True,
    )  # fmt: skip
    (path,) = folder.glob("*.whl")
    return path


def test_the_wheel_carries_templates_and_runtime_and_its_types(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    for source, target in (("templates", "templates"), ("firmware_c", "firmware_c")):
        files = [f for f in (ROOT / source).rglob("*") if f.is_file()]
        assert files
        for file in files:
            relative = file.relative_to(ROOT / source).as_posix()
            assert f"ccgen/_data/{target}/{relative}" in names
    assert "ccgen/py.typed" in names


def test_the_installed_wheel_exports_away_from_the_repository(wheel, tmp_path):
    environment = tmp_path / "env"
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    python = environment / "bin" / "python"
    subprocess.run(
        [python, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", wheel], check=True
    )
    away = tmp_path / "away"
    away.mkdir()
    (away / "joint.toml").write_bytes((ROOT / "examples" / "wrist.toml").read_bytes())
    # The dependencies come from this environment, ccgen itself from the new one.
    paths = {**os.environ, "PYTHONPATH": sysconfig.get_paths()["purelib"]}
    run = [environment / "bin" / "ccgen", "export", "joint.toml", "-o", "wrist"]
    subprocess.run(run, check=True, cwd=away, env=paths)
    assert (away / "wrist" / "src" / "ccgen" / "version.h").is_file()
    where = [python, "-c", "import ccgen; print(ccgen.__file__)"]
    origin = subprocess.run(where, check=True, cwd=away, env=paths, capture_output=True, text=True)
    assert str(environment) in origin.stdout
