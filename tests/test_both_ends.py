"""Both ends of the bus in C: a sensor board that packs, a node that answers, a chip that measures.

The first example of the exported README, a chip that reads its own converter, runs on an emulated
Cortex-M4; what it sends is decoded with cantools and checked with autosar-e2e.
"""

import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import cantools
import e2e.p01
import e2e.p05
import numpy as np
import pytest
from runtime_c import ADDRESS, COMPILERS, CXX14, HERE, INCLUDE, WARNINGS

from ccgen.export.package import export
from ccgen.joint.file import parse_joint
from ccgen.targets.compiler import sources
from ccgen.targets.exported import open_exported

EXAMPLES = Path(__file__).parent.parent / "examples"
SNAPSHOTS = 10_000
ODD = """
name = "odd"
[geometry]
segments = 5
length = 0.1
range_of_motion = 4.0
[sensors.transducer]
bits = 12
signed = false
metres_per_count = 1e-5
zero = 2048
noise = 2e-5
""" + "".join(
    f'[[sensor]]\nname = "{name}"\nspan = {span}\nangle = {angle}\nradius = 0.02\n'
    for name, span, angle in (
        ("near", [0, 4], 10.0), ("far", [0, 4], 130.0), ("third", [0, 2], 250.0),
        ("fourth", [1, 4], 300.0), ("fifth", [2, 4], 70.0),
    )
) + """
[can]
base_id = 0x18DA0100
extended = true
commands = true
cycle_ms = 20
"""  # fmt: skip
WIDE = """
name = "wide"
[geometry]
segments = 3
length = 0.06
range_of_motion = 5.0
[sensors]
radius = 0.02
count = 2
[sensors.transducer]
bits = 24
metres_per_count = 1.0e-8
[fixed_point]
precision = 32
[can]
turn = false
"""
JOINTS = {
    "shoulder": (EXAMPLES / "shoulder.toml").read_text(),
    "spine": (EXAMPLES / "spine.toml").read_text(),
    "odd": ODD,
    "wide": WIDE,
    "narrow_fd": WIDE.replace('"wide"', '"narrow_fd"').replace("precision = 32", "precision = 16")
    .replace("bits = 24", "bits = 16").replace("1.0e-8", "2.0e-6")
    .replace("turn = false", "fd = true"),
}  # fmt: skip


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Exported folders by name: classic and FD, 16 and 32 bits, with and without the turn."""
    folder = tmp_path_factory.mktemp("ends")
    for name, text in JOINTS.items():
        export(parse_joint(text, f"{name}.toml"), folder / name)
    return folder


def of(name: str) -> list[str]:
    """Flags that give a program the joint."""
    return ["-include", f"{name}_can.h", f"-DOF(x)={name}_##x",
            f"-DOF_CYCLE_US={name.upper()}_CYCLE_US"]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "compiler"), [*((name, COMPILERS[0]) for name in JOINTS), ("odd", COMPILERS[-1])]
)
def test_a_board_and_a_node_answer_as_a_chip_with_its_own_converter(
    folders, tmp_path, name, compiler
):
    folder, program = folders / name, tmp_path / "loop"
    command = [
        compiler, "-std=c99", *WARNINGS, *ADDRESS, "-O1", f"-I{folder / 'src'}", *INCLUDE,
        *of(name), str(HERE / "loop.c"), *map(str, sources(folder)), "-o", str(program),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("3000 snapshots, ")


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize(
    "command",
    [
        ["arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "-std=c99", "-Os"],
        ["avr-gcc", "-mmcu=atmega1284p", "-std=c99", "-Os"],
        ["g++", *CXX14],
    ],
    ids=["cortex-m0", "avr", "c++"],
)
def test_the_generated_files_compile_without_a_warning(folders, tmp_path, name, command):
    assert shutil.which(command[0]), f"needs {command[0]}"
    src = folders / name / "src"
    files = [*src.glob("*.c"), *src.glob("ccgen/*.c")]
    done = subprocess.run(
        [*command, *WARNINGS, f"-I{src}", "-c", *map(str, files)],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


class Client:
    """A folder's frames to another implementation: cantools, autosar-e2e and nothing of ours."""

    def __init__(self, folder: Path) -> None:
        self.database = cantools.database.load_file(folder / f"{folder.name}.dbc")
        (self.status,) = (m for m in self.database.messages if m.name.endswith("_STATUS"))
        self.seen: Counter[str] = Counter()

    def decode(self, line: str):
        """Name and raw signals of an SLCAN line."""
        extended, fd = line[0] in "TDB", line[0] in "dDbB"
        digits = 8 if extended else 3
        identifier, data = int(line[1 : 1 + digits], 16), bytes.fromhex(line[2 + digits :])
        message = self.database.get_message_by_frame_id(identifier)
        assert (message.is_extended_frame, message.is_fd) == (extended, fd)
        assert message.length == len(data)
        data_id = message.dbc.attributes["E2EDataId"].value
        profile = message.dbc.attributes["E2EProfile"].value
        check = {"P01": e2e.p01.e2e_p01_check, "P05": e2e.p05.e2e_p05_check}[profile]
        assert check(bytearray(data), data_id), message.name
        self.seen[message.name] += 1
        return message.name, message.decode(data, scaling=False, decode_choices=False)


def first_example(folder: Path, out: Path, snapshots: int, reach: int) -> str:
    """Build the first example of the README for the Cortex-M4 and run it; gives the UART's text."""
    (loop, *_) = re.findall(r"```c\n(.*?)```", (folder / "README.md").read_text(), re.DOTALL)
    exported = open_exported(folder)
    zeros = exported.model.readings.zero.tolist()
    reads = re.sub(
        r"board_read_counts\((.*?)\);",
        lambda call: " ".join(
            f"converter_read({field}, sizeof {field} / sizeof {field}[0]);"
            for field in call[1].split(", ")
        ),
        loop,
    )
    declared = (
        '#include "board.h"\n'
        f"void converter_read({folder.name}_count_t *counts, uint8_t number);\n"
        "bool board_can_write(const ccgen_frame_t *frame);\n"
        "uint32_t converter_time_us(void);\n"
        "#define board_time_us converter_time_us\n"
    )
    header, _, rest = reads.partition("\n")
    out.mkdir()
    (out / "main.c").write_text(f"{header}\n{declared}{rest}")
    ports = folder / "ports"
    command = [
        "arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-std=c99", "-Os", *WARNINGS,
        "-ffunction-sections", "-Wl,--gc-sections", "-nostartfiles", "--specs=nosys.specs",
        f"-I{folder / 'src'}", f"-I{ports / 'bare_metal'}", f"-T{ports / 'cortex_m/cortex_m.ld'}",
        *of(folder.name), f"-DSENSORS={len(zeros)}u", f"-DSNAPSHOTS={snapshots}u",
        f"-DREACH={reach}", f"-DZEROS={{{','.join(map(str, zeros))}}}",
        out / "main.c", HERE / "converter.c", *sources(folder),
        *(ports / "cortex_m" / f for f in ("startup.c", "semihosting.c", "board_mps2.c")),
        "-o", out / "firmware.elf",
    ]  # fmt: skip
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    run = [
        "qemu-system-arm", "-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial",
        "stdio", "-semihosting-config", "enable=on,target=native",
        "-kernel", str(out / "firmware.elf"),
    ]  # fmt: skip
    done = subprocess.run(
        run, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=600
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def drawn(zeros: list[int], snapshots: int, reach: int, largest: int) -> np.ndarray:
    """What the converter reads."""
    seed, rows = 1, []
    for k in range(snapshots):
        row = []
        for zero in zeros:
            seed = (seed * 1664525 + 1013904223) % 2**32
            row.append(zero + (seed >> 8) % (2 * reach + 1) - reach)
        if k % 50 == 49:
            row[0] = largest
        rows.append(row)
    return np.array(rows)


@pytest.mark.parametrize(
    ("name", "snapshots", "reach"), [("shoulder", SNAPSHOTS, 800), ("spine", 1000, 2000)]
)
def test_the_first_example_publishes_frames_that_others_accept_with_counters_right(
    folders, tmp_path, name, snapshots, reach
):
    for program in ("arm-none-eabi-gcc", "qemu-system-arm"):
        assert shutil.which(program), f"needs {program}"
    folder = folders / name
    exported, client = open_exported(folder), Client(folder)
    lines = first_example(folder, tmp_path / "m4", snapshots, reach).splitlines()
    model = exported.model
    largest = 2 ** (exported.joint.precision - 1) - 1
    counts = drawn(model.readings.zero.tolist(), snapshots, reach, largest)
    lost, split = np.arange(snapshots) % 50 == 49, model.u.sensors
    whole = counts[~lost]
    expected = np.hstack([model.u.estimate(whole[:, :split]), model.v.estimate(whole[:, split:])])
    angles = np.full((snapshots, 2 * model.segments), 2**40)
    missing: list[int] = []
    columns = {f"angle_{a}{i}": k for k, (a, i) in enumerate(
        (a, i) for a in "uv" for i in range(model.segments))}  # fmt: skip
    upper, numbers = name.upper(), exported.layout.numbers
    answers: dict[str, list[int]] = {}
    for line in lines:
        if not line:
            continue
        kind, values = client.decode(line)
        number = values["counter"] + 15 * values.get("turn", 0)
        if kind.startswith(f"{upper}_ANGLES"):
            k = len(answers.setdefault(kind, []))
            for signal, column in columns.items():
                if signal in values:
                    angles[k, column] = values[signal]
        if kind == f"{upper}_STATUS":
            assert values["faults"] == (0x40 if values["missing_sensors"] else 0)
            missing.append(values["missing_sensors"])
        answers.setdefault(kind, []).append(number)
    for kind, found in answers.items():
        modulus = (
            numbers if "ANGLES" in kind or "TIP" in kind else numbers if name == "spine" else 15
        )
        assert found == [k % modulus for k in range(len(found))], kind
    assert client.seen[f"{upper}_TIP"] == snapshots
    assert np.array_equal(angles[~lost], expected)
    assert missing == lost.astype(int).tolist()
