"""The ports for CAN controllers, with the examples' programs, on models of their registers.

The models hold three frames in a FIFO, lose the fourth, go off the bus after 32 destroyed frames,
and come in between with their interrupt; what a manual forbids ends the program.
"""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from runtime_c import HERE, PORTS, WARNINGS
from test_example_projects import run
from test_export_examples import JOINTS, Zephyr, build

from ccgen.export.package import export
from ccgen.joint.file import parse_joint

FAKES = HERE / "controllers"
SANITIZED = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1")
FDCAN = [(name, "fdcan") for name in JOINTS]
CLASSIC = [(name, "bxcan") for name in ("shoulder", "wrist", "odd")]
SOME = [("shoulder", "bxcan"), ("shoulder", "fdcan"), ("spine", "fdcan"), ("odd", "fdcan")]
COUNTERS = ("received", "dropped", "sent", "aborted", "bus_off", "errors")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("controllers")
    for name, text in JOINTS.items():
        export(parse_joint(text, f"{name}.toml"), folder / name, examples=["stm32"])
    return folder


def joint_objects(folder: Path) -> list[Path]:
    """The joint's sources and the ports' bit timing, which all programs share, compiled once."""
    out = folder.parent / f"{folder.name}-joint"
    sources = [*folder.glob("src/*.c"), *folder.glob("src/ccgen/*.c"),
               folder / "ports" / "can" / "can_timing.c"]  # fmt: skip
    if not out.exists():
        out.mkdir()
        flags = ("-std=c99", *WARNINGS, *SANITIZED, f"-I{folder / 'src'}")
        run("gcc", *flags, "-c", *sources, cwd=out)
    return [out / f"{source.stem}.o" for source in sources]


class OnController(Zephyr):
    """A folder's example on the model of a controller, with simulated sensors on its bus."""

    def __init__(self, folder: Path, out: Path, controller: str, snapshots: int) -> None:
        self.controller = controller
        super().__init__(folder, out, snapshots)
        self.counters: dict[str, int] = {}

    def build(self, folder: Path, out: Path) -> Path:
        project, ports = folder / "examples" / "stm32", folder / "ports"
        out = folder.parent / "-".join((folder.name, self.controller, *self.definitions))
        program = out / "node"
        if program.exists():
            return program
        out.mkdir()
        options = (*self.definitions, f"-DBOARD_{self.controller.upper()}")
        objects = []
        for file in (ports / self.controller / f"can_{self.controller}.c", project / "main.c"):
            objects.append(out / f"{file.stem}.o")
            run(
                "gcc", "-std=c99", *WARNINGS, *SANITIZED, *options, "-include",
                FAKES / "access.h", f"-I{project}", f"-I{folder / 'src'}", f"-I{ports / 'can'}",
                f"-I{ports / self.controller}", "-c", file, "-o", objects[-1],
            )  # fmt: skip
        run(
            "gcc", "-std=c99", *WARNINGS, *SANITIZED, *options, f"-I{project}", f"-I{HERE}",
            f"-I{folder / 'src'}", f"-I{ports / 'can'}", f"-I{ports / self.controller}", *objects,
            *joint_objects(folder), FAKES / f"fake_{self.controller}.c", FAKES / "bus.c",
            FAKES / "board.c", "-o", program,
        )  # fmt: skip
        return program

    definitions: tuple[str, ...] = ("-DLENGTHS_FROM_BUS",)

    def output(self, lines, end, variables) -> list[str]:
        *sent, last = super().output(lines, end, variables)
        assert last.startswith("# ")
        self.counters = dict(zip(COUNTERS, map(int, last[2:].split()), strict=True))
        assert 0 <= len(sent) - self.counters["sent"] <= 3  # the last may not be counted yet
        return sent

    def check(self, sent) -> set[int]:
        """Numbers of the snapshots that were answered, each rightly and in order."""
        angles = self.angles(sent)
        for number, values in angles.items():
            assert list(values.values()) == self.expected(self.counts[number])
        numbers = [v["counter"] + 15 * v.get("turn", 0) for _, k, v in sent if "_ANGLES" in k]
        assert numbers == sorted(numbers)
        return set(angles)


def waits_for_nobody(node):
    """Nobody acknowledges for twenty cycles of the 40."""
    busy = node.cycle * 20 + 50
    sent = node.run(node.incoming(), FAKE_ALONE=f"50-{busy}")
    assert not any(50 <= at < busy for at, *_ in sent)
    answered = node.check(sent)
    assert min(answered) >= 19  # nothing of before comes late
    assert set(range(22, 40)) <= answered
    assert node.counters["aborted"] >= 3
    assert node.counters["errors"] > 0


def counts_a_full_queue(node):
    """The program alone is held up within 60 snapshots; the queue has 16 places."""
    begin, frames = 50 + 8 * node.cycle, node.exported.layout.lengths_frames
    held = 16 // frames + 3
    sent = node.run(node.incoming(), FAKE_BUSY=f"{begin - 1}-{begin + held * node.cycle}")
    assert set(range(8)) | set(range(8 + held + 3, 60)) <= node.check(sent)
    lost = node.counters["dropped"]
    assert lost >= 1
    assert node.counters["received"] == 60 * frames - lost


@pytest.mark.parametrize(("name", "controller"), FDCAN + CLASSIC)
def test_a_controller_brings_every_snapshot_and_its_answer(folders, tmp_path, name, controller):
    node = OnController(folders / name, tmp_path, controller, 14)
    sent = node.run(node.incoming())
    assert node.check(sent) == set(range(14))
    frames = node.exported.layout.lengths_frames
    assert node.counters["received"] == 14 * frames
    assert [node.counters[k] for k in COUNTERS if k not in ("received", "sent")] == [0, 0, 0, 0]


@pytest.mark.parametrize(("name", "controller"), SOME)
def test_nothing_waits_for_a_node_that_acknowledges(folders, tmp_path, name, controller):
    node = OnController(folders / name, tmp_path, controller, 40)
    waits_for_nobody(node)
    assert node.counters["bus_off"] == 0


@pytest.mark.parametrize(("name", "controller"), SOME)
def test_a_controller_is_back_within_three_cycles_after_bus_off(
    folders, tmp_path, name, controller
):
    node = OnController(folders / name, tmp_path, controller, 30)
    off = 50 + 10 * node.cycle
    sent = node.run(node.incoming(), FAKE_OFF=f"{off}-{off + 3 * node.cycle}")
    assert set(range(13 + 3, 30)) | set(range(9)) <= node.check(sent)
    assert node.counters["bus_off"] >= 1
    assert node.counters["aborted"] >= 1


@pytest.mark.parametrize(("name", "controller"), SOME)
def test_without_the_interrupt_the_main_loop_receives_alone(folders, tmp_path, name, controller):
    node = OnController(folders / name, tmp_path, controller, 14)
    sent = node.run(node.incoming(), FAKE_DEAF="0-100000")
    assert node.check(sent) == set(range(14))
    assert node.counters["dropped"] == 0


@pytest.mark.parametrize(("name", "controller"), SOME)
def test_a_full_fifo_is_counted_and_leaves_nothing_wrong(folders, tmp_path, name, controller):
    """The program is held up for five cycles and its interrupts are lost meanwhile."""
    node = OnController(folders / name, tmp_path, controller, 24)
    begin = 50 + 8 * node.cycle
    span = f"{begin - 1}-{begin + 5 * node.cycle}"
    sent = node.run(node.incoming(), FAKE_DEAF=span, FAKE_BUSY=span)
    assert set(range(8)) | set(range(13 + 3, 24)) <= node.check(sent)
    assert node.counters["dropped"] >= 1


@pytest.mark.parametrize(("name", "controller"), SOME)
def test_a_full_queue_is_counted_and_leaves_nothing_wrong(folders, tmp_path, name, controller):
    node = OnController(folders / name, tmp_path, controller, 60)
    counts_a_full_queue(node)


@pytest.mark.parametrize(("name", "controller"), SOME)
def test_frames_that_cannot_be_do_no_harm(folders, tmp_path, name, controller):
    node = OnController(folders / name, tmp_path, controller, 14)
    layout, lines = node.exported.layout, node.incoming()
    own, most = layout.base_id, 64 if layout.fd else 8
    strange = [
        node.line(20, own, bytes(most), dlc=15),
        node.line(20, own, bytes(8), flags=layout.extended, dlc=15),
        node.line(21, own, bytes(most), flags=layout.extended | 4, dlc=9),
        node.line(22, own, b"", dlc=0),
        node.line(23, own, bytes(8), flags=layout.extended | 2),
        node.line(24, layout.last_id + 1, bytes(8)),
        node.line(24, own, bytes(8), flags=1 - layout.extended),
    ]
    assert node.check(node.run([*strange, *lines])) == set(range(14))


class OwnConverter(OnController):
    """The example as it is without options: it reads its own converter."""

    definitions = ()


@pytest.mark.parametrize(("name", "controller"), [*SOME, ("bellows", "fdcan")])
def test_the_example_publishes_what_its_converter_reads(folders, tmp_path, name, controller):
    node = OwnConverter(folders / name, tmp_path, controller, 1)
    sent = node.run(node.incoming(), 0.2)
    readings = node.exported.model.readings
    low, high = readings.minimum.astype(object), readings.maximum.astype(object)
    raw = 2047 + np.arange(len(low))
    counts = np.array([b + int((t - b) * r / 4095) for b, t, r in zip(low, high, raw, strict=True)])
    angles = list(node.angles(sent).values())
    assert len(angles) >= int(200 / node.cycle) - 2
    assert all(list(values.values()) == node.expected(counts) for values in angles)
    assert node.counters["received"] == 0  # LENGTHS of others are not let in


@pytest.mark.parametrize(
    ("name", "family"), [*((name, "g4") for name in JOINTS), *((n, "f4") for n, _ in CLASSIC)]
)
def test_the_stm32_example_links_for_every_joint(folders, tmp_path, name, family):
    strict = "-Wall -Wextra -Wconversion -Wdouble-promotion -Werror"
    build(
        folders / name / "examples" / "stm32", tmp_path, f"-DFAMILY={family}",
        f"-DCMAKE_C_FLAGS=-Os {strict}",
    )  # fmt: skip
    symbols = run("arm-none-eabi-nm", tmp_path / "build" / "firmware.elf").splitlines()
    kept = {line.split()[-1]: int(line.split()[0], 16) for line in symbols if len(line) > 12}
    assert kept["core_vectors"] == 0x08000000
    assert {"fdcan" if family == "g4" else "bxcan"} == {
        c for c in ("fdcan", "bxcan") if f"can_{c}_start" in kept
    }


def test_bxcan_is_refused_for_a_can_fd_joint_with_the_reason(folders, tmp_path):
    project = folders / "spine" / "examples" / "stm32"
    done = subprocess.run(
        ["cmake", "-S", project, "-B", tmp_path, "-DFAMILY=f4"], capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert "spine speaks CAN FD (can.fd)" in done.stderr


REFUSED = """
#include <stdio.h>
#include "can_bxcan.h"
#include "can_fdcan.h"
static volatile uint32_t registers[0x100], memory[212];
int main(void) {
    static const can_port_filter_t filters[29];
    static can_bxcan_t bxcan;
    static can_fdcan_t fdcan;
    can_port_config_t c = {.clock_hz = 42000000u, .bitrate = 1000000u, .filters = filters};
    printf("%d ", can_bxcan_start(&bxcan, registers, &c));
    c.filter_count = 15;
    printf("%d ", can_bxcan_start(&bxcan, registers, &c));
    c.clock_hz = 42000001u;
    printf("%d ", can_bxcan_start(&bxcan, registers, &c));
    c.fd = true;
    printf("%d ", can_bxcan_start(&bxcan, registers, &c));
    c.clock_hz = 80000000u, c.filter_count = 29;
    printf("%d ", can_fdcan_start(&fdcan, registers, memory, &c));
    c.extended = true, c.filter_count = 9;
    printf("%d ", can_fdcan_start(&fdcan, registers, memory, &c));
    c.data_bitrate = 3000000u;
    printf("%d ", can_fdcan_start(&fdcan, registers, memory, &c));
    c.clock_hz = 170000000u, c.data_bitrate = 2000000u, c.filter_count = 1;
    registers[6] = 3u; /* INIT, CCE: plain memory keeps them */
    printf("%d ", can_fdcan_start(&fdcan, registers, memory, &c));
    printf("%d ", (int)((registers[3] >> 23) & 1u));
    c.clock_hz = 80000000u;
    registers[6] = 3u;
    printf("%d ", can_fdcan_start(&fdcan, registers, memory, &c));
    printf("%d %u\\n", (int)((registers[3] >> 23) & 1u), (unsigned)registers[18] >> 8);
    return 0;
}
"""


def test_a_port_refuses_what_its_controller_cannot_do_with_a_code(folders, tmp_path):
    source, program, ports = tmp_path / "refused.c", tmp_path / "refused", folders / "wrist/ports"
    source.write_text(REFUSED)
    run(
        "gcc", "-std=c99", *WARNINGS, *SANITIZED, f"-I{folders / 'wrist/src'}",
        *(f"-I{ports / folder}" for folder in ("can", "bxcan", "fdcan")), source,
        ports / "can/can_timing.c", ports / "bxcan/can_bxcan.c", ports / "fdcan/can_fdcan.c",
        "-o", program,
    )  # fmt: skip
    silent, filters, timing, frame = -3, -2, -1, -4
    # 170 MHz: 2 Mbit/s with a prescaler of 5, sampled late enough to do without compensation;
    # 80 MHz: compensated at the sample point, 30 clocks after the beginning of a bit of 40.
    assert [int(word) for word in run(program).split()] == [
        silent, filters, timing, frame, filters, filters, timing, 0, 0, 0, 1, 30,
    ]  # fmt: skip


def test_the_ports_compile_for_the_target_and_with_every_compiler(tmp_path):
    built = tmp_path / "port.o"
    for port in ("can/can_timing", "bxcan/can_bxcan", "fdcan/can_fdcan"):
        for compiler in (["gcc"], ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb"]):
            run(
                *compiler, "-std=c99", "-O2", "-Wmissing-prototypes", *WARNINGS,
                f"-I{PORTS.parent / 'include'}", f"-I{PORTS / 'can'}", "-c",
                PORTS / f"{port}.c", "-o", built,
            )  # fmt: skip
