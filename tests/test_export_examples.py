"""`ccgen export --example KIND`: complete projects for any joint, built, and run where possible."""

import os
import shutil
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from runtime_c import HERE
from test_both_ends import ODD, WIDE, Client
from test_example_projects import STRICT, arduino, require, run

from ccgen.cli.main import main
from ccgen.errors import InputError
from ccgen.export import examples
from ccgen.export.manifest import changed_files
from ccgen.export.package import export
from ccgen.joint.file import parse_joint
from ccgen.targets.exported import open_exported

EXAMPLES = Path(__file__).parent.parent / "examples"
JOINTS = {
    **{name: (EXAMPLES / f"{name}.toml").read_text() for name in ("shoulder", "wrist", "spine")},
    "odd": ODD,
    "wide": WIDE,
    "bellows": """
name = "bellows"
[geometry]
segments = 6
length = 0.12
range_of_motion = 4.0
elongation = [0.0, 0.05]
sections = [3, 3]
[estimator]
axes = ["u", "h"]
[sensors.transducer]
bits = 14
metres_per_count = 2e-6
"""
    + "".join(
        f'[[sensor]]\nname = "s{j}"\nspan = [{j}, {j + 2}]\nangle = {angle}\nradius = 0.02\n'
        for j, angle in enumerate((90.0, 270.0, 80.0, 280.0))
    )
    + "[can]\nfd = true\nrate_switch = true\nbase_id = 0x123\ncommands = true\n",
}
KINDS = tuple(kind for kind, own in examples.EXAMPLES.items() if not own.classic_only)
"""Those for every joint."""
DLC = {n: code for code, n in enumerate((*range(9), 12, 16, 20, 24, 32, 48, 64))}
"""What a frame's length is called in its header (ISO 11898-1)."""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("examples")
    for name, text in JOINTS.items():
        export(parse_joint(text, f"{name}.toml"), folder / name, examples=KINDS)
    return folder


@pytest.mark.parametrize("name", JOINTS)
def test_the_cmake_example_prints_the_models_values(folders, tmp_path, name):
    require("cmake", "cmake")
    folder = folders / name
    exported = open_exported(folder)
    build(folder / "examples" / "cmake", tmp_path)
    counts = exported.model.readings.zero + np.arange(len(exported.joint.sensors)) + 3
    done = subprocess.run(
        [tmp_path / "build" / "angles"], input=" ".join(map(str, counts)), capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    lines = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    assert set(lines) == {*exported.joint.axes, "tip"}
    for axis, own in exported.model.axes.items():
        steps = own.estimate(counts[exported.joint.own(axis)])
        values = steps * 2.0**-own.fraction_bits
        printed = np.array(lines[axis].split(), dtype=float)
        assert np.allclose(printed, values if axis == "h" else np.degrees(values), atol=6e-5)


def build(project: Path, out: Path, *options: str) -> None:
    """Configure and build with the commands of the README, warnings as errors."""
    strict = os.environ | {"CFLAGS": STRICT}
    run("cmake", "-S", project, "-B", out / "build", *options, env=strict)
    run("cmake", "--build", out / "build", env=strict)


@pytest.mark.parametrize("name", JOINTS)
def test_the_cortex_m_example_tells_a_straight_joint_on_its_bus(folders, tmp_path, name):
    require("cmake", "cmake", "arm-none-eabi-gcc", "gcc-arm-none-eabi")
    require("qemu-system-arm", "qemu-system-arm")
    folder = folders / name
    # What the command line says of flags does not take the core's away.
    build(folder / "examples" / "cortex-m", tmp_path, f"-DCMAKE_C_FLAGS=-Os {STRICT}")
    command = [
        "qemu-system-arm", "-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial",
        "stdio", "-semihosting-config", "enable=on,target=native",
        "-kernel", str(tmp_path / "build" / "firmware.elf"),
    ]  # fmt: skip
    client = Client(folder)
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    ) as emulator:
        lines = []
        while len(lines) < 60:
            lines.append(emulator.stdout.readline().strip())
        emulator.send_signal(signal.SIGKILL)
    decoded = [client.decode(line) for line in lines if line]
    assert {f"{name.upper()}_STATUS", f"{name.upper()}_ANGLES_0"} <= {kind for kind, _ in decoded}
    values = [v for _, signals in decoded for s, v in signals.items() if s.startswith("angle_")]
    assert set(values) == {0}


@pytest.mark.parametrize("name", JOINTS)
def test_the_arduino_example_builds_among_the_libraries_without_a_warning(folders, tmp_path, name):
    sensors = len(open_exported(folders / name).joint.sensors)
    board = "arduino:avr:mega:cpu=atmega2560" if sensors > 6 else "arduino:avr:uno"
    libraries = folders
    if name == "spine":  # its fallbacks alone take more RAM than a Mega has
        libraries = tmp_path / "libraries"
        text = JOINTS[name].replace("[estimator]", "[estimator]\nfallback = false", 1)
        assert "fallback = false" in text
        export(parse_joint(text, "spine.toml"), libraries / name, examples=["arduino"])
    sketch = libraries / name / "examples" / "arduino" / "arduino.ino"
    assert arduino(sketch, libraries, board, tmp_path / "build") == []


def zephyr(folder: Path, out: Path) -> Path:
    """Compile the Zephyr example against stand-in headers, under the sanitizers."""
    project = folder / "examples" / "zephyr"
    settings = (project / "prj.conf").read_text().split()
    program = out / "zephyr"
    run(
        "gcc", "-std=c11", *STRICT.split(), "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all", "-g", "-O1",
        *(f"-D{setting.removesuffix('=y')}=1" for setting in settings),
        f"-I{HERE / 'zephyr'}", f"-I{folder / 'src'}", project / "src" / "main.c",
        HERE / "zephyr" / "fake.c", *folder.glob("src/*.c"), *folder.glob("src/ccgen/*.c"),
        "-o", program,
    )  # fmt: skip
    return program


class Zephyr:
    """A folder's example on the fake controller, with simulated sensors on its bus."""

    def __init__(self, folder: Path, out: Path, snapshots: int) -> None:
        self.exported, self.client = open_exported(folder), Client(folder)
        self.program = self.build(folder, out)
        sensors = len(self.exported.joint.sensors)
        rng = np.random.default_rng(5)
        zero = self.exported.model.readings.zero
        self.counts = zero + rng.integers(-40, 40, (snapshots, sensors))
        self.cycle = self.exported.layout.cycle_ms

    def build(self, folder: Path, out: Path) -> Path:
        return zephyr(folder, out)

    def incoming(self) -> list[str]:
        lines = []
        for k, row in enumerate(self.counts):
            for sent in self.exported.codec.encode(row.tolist(), k % self.exported.layout.numbers):
                lines.append(self.line(50 + k * self.cycle, sent.arbitration_id, bytes(sent.data)))
        return lines

    def line(self, at: int, id_: int, data: bytes, flags: int | None = None, dlc=None) -> str:
        layout = self.exported.layout
        own = layout.extended | layout.fd << 2
        code = dlc if dlc is not None else DLC[len(data)]
        return f"{at} {id_:x} {own if flags is None else flags:x} {code} {data.hex() or '00'}"

    def run(self, lines: list[str], seconds: float | None = None, **variables: str):
        """What was sent, decoded, with its time in milliseconds."""
        end = int(1000 * seconds) if seconds else 100 + len(self.counts) * self.cycle
        sent = []
        for line in self.output(lines, end, variables):
            at, id_, flags, dlc, data = line.split()
            flags_, fd = int(flags, 16), self.exported.layout.fd
            assert bool(flags_ & 4) == fd
            assert bool(flags_ & 8) == self.exported.layout.rate_switch
            assert int(dlc) == DLC[len(bytes.fromhex(data))]
            extended = bool(flags_ & 1)
            digits = f"{int(id_, 16):08X}" if extended else f"{int(id_, 16):03X}"
            letter = ("D" if fd else "T") if extended else ("d" if fd else "t")
            sent.append((int(at), *self.client.decode(f"{letter}{digits}0{data}")))
        return sent

    def output(self, lines: list[str], end: int, variables: dict[str, str]) -> list[str]:
        done = subprocess.run(
            [self.program], input="\n".join(lines), capture_output=True, text=True, check=False,
            env=os.environ | {"FAKE_END": str(end), **variables}, timeout=300,
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout.splitlines()

    def angles(self, sent) -> dict[int, dict[str, int]]:
        """Values by number of their snapshot, of whole answers."""
        layout = self.exported.layout
        found: dict[int, dict[str, int]] = {}
        for _, kind, values in sent:
            if "_ANGLES" in kind:
                number = values["counter"] + 15 * values.get("turn", 0)
                own = {s: v for s, v in values.items() if s.startswith(("angle_", "elong"))}
                found.setdefault(number, {}).update(own)
        return {k: own for k, own in found.items() if len(own) == layout.values}

    def expected(self, row: np.ndarray) -> list[int]:
        joint, axes = self.exported.joint, self.exported.model.axes
        return [v for a, own in axes.items() for v in own.estimate(row[joint.own(a)]).tolist()]


@pytest.mark.parametrize("name", JOINTS)
def test_the_zephyr_example_answers_every_snapshot_in_order(folders, tmp_path, name):
    example = Zephyr(folders / name, tmp_path, 14)
    sent = example.run(example.incoming())
    angles = example.angles(sent)
    assert sorted(angles) == list(range(14))
    for number, values in angles.items():
        assert list(values.values()) == example.expected(example.counts[number])
    tips = [v["counter"] for _, kind, v in sent if kind.endswith("_TIP")]
    assert tips == list(range(14))
    assert {v["faults"] & ~0x80 for _, kind, v in sent if kind.endswith("_STATUS")} == {0}


@pytest.mark.parametrize("name", ["shoulder", "spine", "odd"])
def test_the_zephyr_example_does_not_wait_for_a_node_that_acknowledges(folders, tmp_path, name):
    example = Zephyr(folders / name, tmp_path, 40)
    busy = example.cycle * 20 + 50
    sent = example.run(example.incoming(), FAKE_ALONE=f"50-{busy}")
    assert not any(50 <= at < busy for at, *_ in sent)
    angles = example.angles(sent)
    assert angles
    for number, values in angles.items():  # nothing of before comes late
        assert list(values.values()) == example.expected(example.counts[number])
        assert number >= 19
    assert set(range(22, 40)) <= set(angles)


@pytest.mark.parametrize("name", ["shoulder", "spine"])
def test_the_zephyr_example_goes_on_within_three_cycles_after_bus_off(folders, tmp_path, name):
    example = Zephyr(folders / name, tmp_path, 30)
    off = 50 + 10 * example.cycle
    sent = example.run(example.incoming(), FAKE_OFF=f"{off}-{off + 35}")
    angles = example.angles(sent)
    for number, values in angles.items():
        assert list(values.values()) == example.expected(example.counts[number])
    assert set(range(14 + 3, 30)) | set(range(9)) <= set(angles)


@pytest.mark.parametrize("name", ["shoulder", "spine", "odd"])
def test_the_zephyr_example_takes_no_harm_from_frames_that_cannot_be(folders, tmp_path, name):
    example = Zephyr(folders / name, tmp_path, 14)
    layout, lines = example.exported.layout, example.incoming()
    own, most = layout.base_id, 64 if layout.fd else 8
    strange = [
        example.line(20, own, bytes(most), dlc=15),
        example.line(20, own, bytes(most), flags=layout.extended, dlc=15),
        example.line(21, own, bytes(most), flags=layout.extended | 4, dlc=9),
        example.line(22, own, b"", dlc=0),
        example.line(23, own, bytes(8), flags=layout.extended | 2),
        example.line(24, layout.last_id + 1, bytes(8)),
    ]
    angles = example.angles(example.run([*strange, *lines]))
    assert sorted(angles) == list(range(14))
    for number, values in angles.items():
        assert list(values.values()) == example.expected(example.counts[number])


def test_filters_let_in_the_own_frames_and_no_others(folders):
    for name in JOINTS:
        layout = open_exported(folders / name).layout
        wanted = {frame.id for frame in layout.frames_of("lengths")}
        wanted |= {layout.last_id} if layout.commands else set()
        near = range(max(0, layout.base_id - 70), layout.last_id + 70)
        masks = examples.filters(layout)
        assert {i for i in near if any((i ^ id_) & mask == 0 for id_, mask in masks)} == wanted


def test_a_controller_that_does_not_speak_can_fd_is_refused_with_its_name(monkeypatch, tmp_path):
    classic = examples.Example(examples.EXAMPLES["cmake"].files, "the MCP2515")
    monkeypatch.setitem(examples.EXAMPLES, "cmake", classic)
    joint = parse_joint(JOINTS["spine"], "spine.toml")
    with pytest.raises(InputError, match=r"spine.toml: can.fd: true, but the MCP2515 of the"):
        export(joint, tmp_path / "spine", examples=["cmake"])
    assert not (tmp_path / "spine").exists()
    export(parse_joint(JOINTS["wrist"], "wrist.toml"), tmp_path / "wrist", examples=["cmake"])


def test_the_command_line_writes_examples_that_the_manifest_knows(tmp_path, capsys):
    out = tmp_path / "wrist"
    with pytest.raises(SystemExit) as end:
        main(["export", str(EXAMPLES / "wrist.toml"), "-o", str(out), "--example", "zephyr",
              "--example", "cmake", "--example", "cmake"])  # fmt: skip
    assert end.value.code in (0, None)
    assert sorted(path.name for path in (out / "examples").iterdir()) == ["cmake", "zephyr"]
    assert changed_files(out) == []
    shutil.copytree(out / "examples" / "cmake", tmp_path / "elsewhere")
    build(tmp_path / "elsewhere", tmp_path, f"-DJOINT={out}")
    with pytest.raises(SystemExit) as end:
        main(["export", str(EXAMPLES / "wrist.toml"), "-o", str(out), "--example", "boat"])
    assert end.value.code == 2
    assert "--example: boat is unknown; known: cmake, " in capsys.readouterr().err
    assert (out / "examples" / "zephyr").is_dir()
