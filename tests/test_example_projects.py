"""Two joints in one Arduino sketch, through Arduino's own builder.

Projects of any joint: test_export_examples.py.
"""

import shutil
import subprocess
from pathlib import Path

import pytest

from ccgen.export.package import export

EXAMPLES = Path(__file__).parent.parent / "examples"
STRICT = "-Wall -Wextra -Wconversion -Wdouble-promotion -Werror"
# Arduino's core for AVR asks C++ for a macro that Debian's avr-gcc offers to C alone.
BUILDER = (
    "arduino-builder", "-compile", "-hardware", "/usr/share/arduino-builder",
    "-hardware", "/usr/share/arduino/hardware", "-tools", "/usr/bin", "-warnings", "all",
    "-prefs=compiler.cpp.extra_flags=-DDECIMAL_DIG=__DECIMAL_DIG__",
)  # fmt: skip
TWO_JOINTS_SKETCH = """
#include <shoulder_can.h>
#include <wrist_can.h>
static shoulder_node_t shoulder;
static wrist_node_t wrist;
void setup() { Serial.begin(9600); shoulder_node_init(&shoulder); wrist_node_init(&wrist); }
void loop() {
  ccgen_frame_t frame = {};
  frame.length = Serial.readBytes(frame.data, 8);
  shoulder_node_receive(&shoulder, &frame, micros());
  wrist_node_receive(&wrist, &frame, micros());
  while (shoulder_node_transmit(&shoulder, micros(), &frame) == 1) Serial.write(frame.data, 8);
  while (wrist_node_transmit(&wrist, micros(), &frame) == 1) Serial.write(frame.data, 8);
}
"""


@pytest.fixture(scope="module")
def joints(tmp_path_factory):
    """Exported folders of the joints that the examples use."""
    folder = tmp_path_factory.mktemp("joints")
    for name in ("shoulder", "wrist"):
        export(EXAMPLES / f"{name}.toml", folder / name)
    return folder


def require(*programs_and_packages: str) -> None:
    pairs = zip(programs_and_packages[::2], programs_and_packages[1::2], strict=True)
    for program, package in pairs:
        present = shutil.which(program) or Path(program).exists()
        assert present, f"needs {program}; install the Debian package {package}"


def run(*command: object, **options: object) -> str:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def arduino(sketch: Path, libraries: Path, board: str, out: Path) -> list[str]:
    """Build a sketch; gives the compiler's messages about files of ours."""
    require("arduino-builder", "arduino-builder", "avr-gcc", "gcc-avr")
    require("/usr/share/arduino/hardware/arduino/avr", "arduino-core-avr")
    out.mkdir()
    command = [*BUILDER, "-libraries", libraries, "-fqbn", board, "-build-path", out, sketch]
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    ours = (str(libraries), str(sketch.parent))
    return [line for line in done.stderr.splitlines() if line.startswith(ours)]


def test_two_joints_are_two_arduino_libraries_in_one_sketch(joints, tmp_path):
    sketch = tmp_path / "two" / "two.ino"
    sketch.parent.mkdir()
    sketch.write_text(TWO_JOINTS_SKETCH)
    board = "arduino:avr:mega:cpu=atmega2560"
    assert arduino(sketch, joints, board, tmp_path / "build") == []
    runtimes = (tmp_path / "build" / "libraries").rglob("ccgen/crc.c.o")
    assert {f.parent.parent.name for f in runtimes} == {"shoulder", "wrist"}
