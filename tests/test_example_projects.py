"""The projects under examples/, built with the commands of their READMEs, and run where possible.

The sketch goes through Arduino's own builder. For PlatformIO, Zephyr and ESP-IDF, which are not
here, the parts of the program that need nothing of theirs are compiled as they would be.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ccgen.export.package import export
from ccgen.fixedpoint import load_model

EXAMPLES = Path(__file__).parent.parent / "examples"
COUNTS = np.array([1500, 1200, 900])
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


@pytest.fixture
def examples(tmp_path):
    """A copy of the examples, so that nothing is built among the sources."""
    return shutil.copytree(EXAMPLES, tmp_path / "examples")


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


def run_readme(project: Path) -> str:
    """Run the commands of a README, with this ccgen and warnings as errors; gives their output."""
    blocks = re.findall(r"```sh\n(.*?)```", (project / "README.md").read_text(), re.DOTALL)
    assert len(blocks) == 1
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return run(
        "sh", "-eu", "-c", blocks[0],
        cwd=project, env=os.environ | {"PATH": path, "CFLAGS": STRICT}, timeout=600,
    )  # fmt: skip


def u_angles(joints: Path) -> np.ndarray:
    return load_model(joints / "shoulder" / "model.json").u.estimate(COUNTS)


def printed_integers(text: str) -> list[int]:
    return [int(line) for line in text.splitlines() if re.fullmatch(r"-?\d+", line)]


def test_the_cmake_example_for_a_host_prints_the_models_angles(examples, joints):
    require("cmake", "cmake")
    lines = run_readme(examples / "cmake_host").splitlines()
    printed = {line.split()[0]: np.array(line.split()[1:], dtype=float) for line in lines[-3:]}
    fraction_bits = load_model(joints / "shoulder" / "model.json").u.fraction_bits
    expected = np.degrees(u_angles(joints) * 2.0**-fraction_bits)
    assert np.allclose(printed["u"], expected, rtol=0.0, atol=6e-5)
    assert not printed["v"].any()
    assert printed["tip"][1] < 0.0 < printed["tip"][2]


def test_the_cmake_example_for_a_cortex_m_prints_the_models_angles_in_qemu(examples, joints):
    require("cmake", "cmake", "arm-none-eabi-gcc", "gcc-arm-none-eabi")
    require("qemu-system-arm", "qemu-system-arm")
    printed = run_readme(examples / "cmake_cortex_m")
    assert printed_integers(printed) == u_angles(joints).tolist()


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


def test_the_arduino_sketch_builds_for_an_uno_without_a_warning(joints, tmp_path):
    sketch = EXAMPLES / "arduino" / "shoulder_serial" / "shoulder_serial.ino"
    assert arduino(sketch, joints, "arduino:avr:uno", tmp_path / "build") == []
    built = tmp_path / "build" / "libraries" / "shoulder"
    assert {f.name for f in built.rglob("*.o")} == {
        f"{f.name}.o" for f in (joints / "shoulder" / "src").rglob("*.c")
    }
    symbols = run("avr-nm", "--defined-only", tmp_path / "build" / "shoulder_serial.ino.elf")
    assert " u_rows" in symbols
    assert "ccgen_node_init" not in symbols


def test_two_joints_are_two_arduino_libraries_in_one_sketch(joints, tmp_path):
    sketch = tmp_path / "two" / "two.ino"
    sketch.parent.mkdir()
    sketch.write_text(TWO_JOINTS_SKETCH)
    board = "arduino:avr:mega:cpu=atmega2560"
    assert arduino(sketch, joints, board, tmp_path / "build") == []
    runtimes = (tmp_path / "build" / "libraries").rglob("ccgen/crc.c.o")
    assert {f.parent.parent.name for f in runtimes} == {"shoulder", "wrist"}


@pytest.mark.parametrize(
    ("main", "compiler"),
    [("platformio/src/main.cpp", ["g++", "-std=c++14"]), ("esp_idf/main/main.c", ["gcc"])],
)
def test_the_programs_for_platformio_and_esp_idf_print_the_models_angles(
    joints, tmp_path, main, compiler
):
    source = joints / "shoulder" / "src"
    objects = []
    for file in source.rglob("*.c"):
        objects.append(tmp_path / f"{file.stem}.o")
        run("gcc", "-ffp-contract=off", f"-I{source}", "-c", file, "-o", objects[-1])
    entry = tmp_path / "entry.c"
    entry.write_text("void app_main(void);\nint main(void) { app_main(); return 0; }\n")
    program = tmp_path / "program"
    run(
        *compiler, *STRICT.split(), f"-I{source}", EXAMPLES / main, *objects,
        *([entry] if "app_main" in (EXAMPLES / main).read_text() else []), "-o", program,
    )  # fmt: skip
    assert printed_integers(run(program)) == u_angles(joints).tolist()


def test_every_example_names_only_options_and_targets_that_the_folder_has(joints):
    shoulder = joints / "shoulder"
    configuration = (EXAMPLES / "zephyr" / "prj.conf").read_text()
    option = re.search(r"CONFIG_(CCGEN_\w+)=y", configuration)
    assert option is not None
    assert f"config {option[1]}\n" in (shoulder / "zephyr" / "Kconfig").read_text()
    component = (EXAMPLES / "esp_idf" / "main" / "CMakeLists.txt").read_text()
    assert f"REQUIRES {shoulder.name})" in component
    for name in ("cmake_host", "cmake_cortex_m"):
        project = (EXAMPLES / name / "CMakeLists.txt").read_text()
        assert "shoulder::shoulder" in project
        assert "shoulder::shoulder" in (shoulder / "CMakeLists.txt").read_text()
