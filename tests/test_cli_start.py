"""Signals end the program in one line, whenever they come, and leave nothing behind."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import PATIENCE, becomes

from ccgen.export.package import export

ROOT = Path(__file__).resolve().parent.parent
IMPORTING = """
import os, signal, sys
class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == "ccgen.cli.main":
            os.kill(os.getpid(), signal.{signal})
sys.meta_path.insert(0, Interrupt())
from ccgen.cli.start import start
start()
"""


@pytest.mark.parametrize(
    ("number", "status", "said"), [("SIGINT", 130, "ccgen: interrupted\n"), ("SIGTERM", 143, "")]
)
def test_a_signal_while_modules_are_imported_shows_no_traceback(number, status, said):
    program = IMPORTING.format(signal=number)
    done = subprocess.run(
        [sys.executable, "-c", program, "--help"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (status, "", said)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_verification_that_is_ended_leaves_no_files_behind(tmp_path, number, status):
    export(ROOT / "examples" / "shoulder.toml", tmp_path / "shoulder")
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "ccgen", "verify", str(tmp_path / "shoulder")],
        env={**os.environ, "TMPDIR": str(temporary)}, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    assert becomes(lambda: list(temporary.glob("ccgen-*/*.so")))
    process.send_signal(number)
    assert process.wait(timeout=PATIENCE) == status
    assert list(temporary.iterdir()) == []
