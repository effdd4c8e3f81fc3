"""The port for the MCP2515 against a model of the chip, on this machine and in C++.

INT interrupts the main loop wherever that speaks with the chip. On an emulated AVR:
test_mcp2515_avr.py.
"""

import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mcp2515 import OSCILLATOR, RATE, Told, frame, run
from runtime_c import (
    ADDRESS,
    CXX14,
    GLUE,
    HERE,
    INCLUDE,
    PORTS,
    RUNTIME,
    SAMPLE,
    WARNINGS,
    compile_c,
    next_build,
)  # fmt: skip
from test_runtime_estimator import sample_model
from test_runtime_ports import lengths

from ccgen.e2e import P01

CYCLE = 10_000
FIRST = 5_000
OWN = ((0x300, 0x7FE),) * 6
NO_INTERRUPT, INTERRUPT, NO_LEVEL = 0, 1, 2
PORT = (PORTS / "mcp2515" / "can_mcp2515.c", PORTS / "can" / "can_timing.c")
PATHS = (f"-I{PORTS / 'can'}", f"-I{PORTS / 'mcp2515'}", f"-I{HERE / 'mcp2515'}")


@cache
def program() -> Path:
    """The port and the sample joint's node at the chip, under the sanitizers."""
    objects = []
    for stem in ("chip", "bus", "host"):
        objects.append(next_build().with_suffix(f".{stem}.o"))
        command = ["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", *ADDRESS, *PATHS,
                   *INCLUDE, "-c", str(HERE / "mcp2515" / f"{stem}.c"),
                   "-o", str(objects[-1])]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    files = (*RUNTIME, *GLUE, SAMPLE / "sample.c", *PORT, *objects)
    return compile_c(files, ("-O1", *ADDRESS, *PATHS), target=next_build().with_suffix(".host"))


def counts(snapshots: int) -> np.ndarray:
    return np.random.default_rng(7).integers(-2000, 2000, (snapshots, 6))


def traffic(snapshots: int, gap: int = 0) -> list[str]:
    """LENGTHS of so many snapshots, the second frame of each so many microseconds behind."""
    script = []
    for k, row in enumerate(counts(snapshots).tolist()):
        for i, (id_, data) in enumerate(lengths(k, tuple(row))):
            script.append(frame(FIRST + k * CYCLE + i * gap, id_, data))
    return script


def served(
    script: list[str], snapshots: int, interrupt: int = INTERRUPT, estimate_us: int = 1500,
    oscillator: int = OSCILLATOR, rate: int = RATE, own_rate: int | None = None,
    start_us: int = 0, extended: bool = False, fd: bool = False, filters=OWN,
) -> Told:  # fmt: skip
    end = [f"end {FIRST + snapshots * CYCLE + CYCLE // 2}"]
    numbers = (oscillator, rate, rate if own_rate is None else own_rate, interrupt, estimate_us,
               start_us, int(extended), int(fd))  # fmt: skip
    masks = [f"{id_:x}:{mask:x}" for id_, mask in filters]
    told = run([program(), *map(str, numbers), *masks], [*script, *end])
    assert told.violations == ""
    return told


def answers(told: Told, snapshots: int) -> set[int]:
    """Numbers of the snapshots that were answered whole; nothing is wrong, nothing out of order."""
    u, v = sample_model(0), sample_model(1)
    rows = counts(snapshots)
    expected = np.hstack([u.estimate(rows[:, :3]), v.estimate(rows[:, 3:])])
    parts: dict[int, list[int]] = {}
    whole: set[int] = set()
    last = (-1, 0)
    for sent in told.sent:
        P01.check(sent.id, sent.data)
        if 0x302 <= sent.id < 0x30B:
            number = (sent.data[1] >> 4) * 15 + (sent.data[1] & 0x0F)
            assert last < (number, sent.id)
            last = (number, sent.id)
        if 0x302 <= sent.id < 0x30A:
            first = 3 * (sent.id - 0x302)
            values = np.frombuffer(sent.data[2:], "<i2").tolist()
            assert values == expected[number, first : first + 3].tolist()
            parts.setdefault(number, []).append(sent.id)
        if sent.id == 0x30A and len(parts.get(number, ())) == 8:
            whole.add(number)
    return whole


@pytest.mark.parametrize("interrupt", [NO_INTERRUPT, INTERRUPT, NO_LEVEL])
@pytest.mark.parametrize("gap", [0, 130, 1000, 3300])
def test_every_snapshot_is_answered_in_order(interrupt, gap):
    told = served(traffic(100, gap), 100, interrupt, 0 if interrupt == NO_INTERRUPT else 1500)
    assert answers(told, 100) == set(range(100))
    assert told.counters["received"] == 200
    assert told.counters["sent"] == len(told.sent)
    rest = {"dropped": 0, "aborted": 0, "bus_off": 0, "errors": 0}
    assert {name: told.counters[name] for name in rest} == rest


def test_an_interrupt_that_meets_the_main_loop_at_the_chip_leaves_it_its_turn():
    nested = 0
    for gap in range(200, 2400, 222):  # where LENGTHS meet frames that leave
        told = served(traffic(40, gap), 40, INTERRUPT, 10)
        assert answers(told, 40) == set(range(40))
        nested += told.nested
    assert nested > 10


def test_the_clock_may_wrap():
    told = served(traffic(40), 40, start_us=2**32 - 200_000)
    assert answers(told, 40) == set(range(40))
    assert told.counters["aborted"] == 0


@pytest.mark.parametrize(
    ("oscillator", "rate"),
    [(16_000_000, 1_000_000), (8_000_000, 500_000), (20_000_000, 1_000_000), (40_000_000, 500_000)],
)
def test_the_chip_keeps_the_bit_rate_of_the_bus(oscillator, rate):
    told = served(traffic(10), 10, oscillator=oscillator, rate=rate)
    assert told.clocks * rate == oscillator
    assert answers(told, 10) == set(range(10))


@pytest.mark.parametrize("oscillator", [8_000_000, 16_000_000, 20_000_000, 25_000_000, 40_000_000])
@pytest.mark.parametrize("rate", [1_000_000, 800_000, 500_000, 250_000, 125_000, 100_000, 20_000])
def test_a_bit_rate_is_met_exactly_or_refused(oscillator, rate):
    told = served([], 1, oscillator=oscillator, rate=rate)
    possible = {n for n in range(5, 26) if oscillator % (2 * rate * n) == 0}
    possible = {n for n in possible if 1 <= oscillator // (2 * rate * n) <= 64}
    assert told.started in ((0, -1) if possible else (-1,))
    if told.started == 0:
        assert told.clocks * rate == oscillator  # and the model refuses what the data sheet does
    # Where the sample point can be between 70 and 90 %.
    assert told.started == 0 or not {n for n in possible if 8 <= n <= 24}


@pytest.mark.parametrize(
    ("oscillator", "rate"),
    [(8_000_000, 1_000_000), (16_000_001, 500_000), (48_000_000, 1_000_000), (16_000_000, 0),
     (32_000_000, 2_000_000)],
)  # fmt: skip
def test_a_crystal_that_does_not_give_the_bit_rate_is_refused(oscillator, rate):
    assert served([], 1, oscillator=oscillator, own_rate=rate).started == -1


def test_filters_let_in_the_own_frames_and_no_others():
    strange = [frame(100 + 200 * i, id_, b"\x01", flags)
               for i, (id_, flags) in enumerate([(0x2FF, 0), (0x302, 0), (0x30B, 0), (0x300, 1),
                                                 (0x300 << 18, 1), (0x700, 0)])]  # fmt: skip
    told = served([*strange, *traffic(3)], 3)
    assert told.counters["received"] == 6
    assert answers(told, 3) == {0, 1, 2}


def test_filters_of_both_buffers_let_in_what_they_name_with_29_bits_too():
    low, high = 0x18DA0100, 0x18DA0177
    filters = ((low, 0x1FFFFFFC), (low + 8, 0x1FFFFFFC), *((high, 0x1FFFFFFF),) * 4)
    own = [*range(low, low + 4), *range(low + 8, low + 12), high]
    near = [*range(low - 8, low + 24), *range(high - 8, high + 8), 0x18DA0100 ^ 1 << 28]
    script = [frame(300 * i, id_, bytes(8), 1) for i, id_ in enumerate(near)]
    script += [frame(300 * len(near), low & 0x7FF, bytes(8), 0)]
    told = served(script, 4, filters=filters, extended=True)
    assert told.counters["received"] == len(own)


@pytest.mark.parametrize(
    "filters", [OWN[:5], (*OWN[:1], (0x300, 0x7FF), *OWN[2:]), (*OWN[:5], (0x300, 0x7FF))]
)
def test_filters_that_the_chip_has_not_are_refused(filters):
    assert served([], 1, filters=filters).started == -2


def test_can_fd_is_refused():
    assert served([], 1, fd=True).started == -4


def test_a_chip_that_is_not_there_is_told():
    assert served(["dead 0 1000000"], 1).started == -3


def test_frames_that_cannot_be_do_no_harm():
    strange = [
        frame(100, 0x300, bytes(8), 0, 15), frame(300, 0x300, b"", 2, 8), frame(500, 0x301, b""),
        frame(700, 0x301, bytes(3)),
    ]  # fmt: skip
    told = served([*strange, *traffic(14)], 14)
    assert told.counters["received"] == 4 + 28
    assert answers(told, 14) == set(range(14))


def test_codes_of_lengths_above_eight_mean_eight():
    script = [
        frame(FIRST + k * CYCLE, id_, data, 0, 9 + k % 7)
        for k, row in enumerate(counts(14).tolist()) for id_, data in lengths(k, tuple(row))
    ]  # fmt: skip
    assert answers(served(script, 14), 14) == set(range(14))


def test_what_finds_both_buffers_full_is_counted():
    burst = [frame(FIRST + 10 * CYCLE + 600 + 60 * i, 0x300, bytes(8)) for i in range(6)]
    script = sorted([*traffic(30), *burst], key=lambda line: int(line.split()[1]))
    told = served(script, 30, NO_INTERRUPT, 1500)
    assert told.overruns > 0
    assert 1 <= told.counters["dropped"] <= told.overruns  # one says of at least one frame
    assert told.counters["received"] == 60 + 6 - told.overruns
    assert set(range(30)) - answers(told, 30) <= {10, 11, 12}


def test_what_finds_the_queue_full_is_counted():
    burst = [frame(FIRST + 10 * CYCLE + 400 + 60 * i, 0x300, bytes(8)) for i in range(30)]
    script = sorted([*traffic(30), *burst], key=lambda line: int(line.split()[1]))
    told = served(script, 30, INTERRUPT, 7000)
    assert told.overruns == 0
    assert told.counters["dropped"] > 0
    assert told.counters["received"] + told.counters["dropped"] == 60 + 30
    assert set(range(30)) - answers(told, 30) <= {10, 11, 12}


@pytest.mark.parametrize("at", range(100, CYCLE, 1900))
def test_bus_off_ends_within_three_cycles_and_is_counted(at):
    off = FIRST + 10 * CYCLE + at
    told = served([*traffic(30), f"broken {off} {off + 35_000}"], 30)
    assert set(range(10)) | set(range(14 + 3, 30)) <= answers(told, 30)
    assert told.counters["bus_off"] >= 1
    assert told.counters["aborted"] > 0
    assert told.counters["errors"] > 0


def test_without_a_node_that_acknowledges_nothing_is_sent_late():
    off, back = FIRST + 5 * CYCLE, FIRST + 25 * CYCLE + 3_000
    told = served([*traffic(40), f"alone {off} {back}"], 40)
    assert told.counters["bus_off"] == 0
    assert told.counters["aborted"] > 0
    assert set(range(5)) | set(range(28, 40)) <= answers(told, 40)
    assert not any(off <= sent.at < back for sent in told.sent)
    late = [s for s in told.sent if back <= s.at < back + 2_000 and s.id < 0x30B]
    assert late == []  # of what was measured before


def test_edges_that_are_lost_hold_nothing_up():
    told = served([*traffic(40, 200), "deaf 50000 300000"], 40, estimate_us=0)
    assert answers(told, 40) == set(range(40))


def test_a_chip_that_loses_its_settings_is_set_up_anew():
    at = FIRST + 10 * CYCLE
    told = served([*traffic(30), f"reset {at + 700}", f"dead {at + 90_000} {at + 95_000}"], 30)
    assert told.counters["errors"] >= 2
    assert {*range(10), *range(13, 19), *range(23, 30)} <= answers(told, 30)


def test_a_chip_at_another_bit_rate_says_errors_and_publishes_nothing():
    told = served(traffic(10), 10, rate=1_000_000, own_rate=500_000)
    assert (told.started, told.sent, told.counters["received"]) == (0, [], 0)
    assert told.counters["errors"] > 0


@pytest.mark.parametrize(
    "command",
    [
        ["avr-gcc", "-mmcu=atmega328p", "-std=c99", "-Os"],
        ["arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "-std=c99", "-Os"],
        ["clang", "-std=c99", "-Wmissing-prototypes"],
    ],
    ids=["avr", "cortex-m0", "clang"],
)
def test_the_port_compiles_without_a_warning_and_its_header_in_c_plus_plus(tmp_path, command):
    include = (*PATHS, f"-I{PORTS.parent / 'include'}")
    for file in PORT:
        done = subprocess.run(
            [*command, *WARNINGS, *include, "-c", str(file), "-o", str(tmp_path / "port.o")],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    source = tmp_path / "port.cpp"
    source.write_text('#include "can_mcp2515.h"\nvoid f(can_mcp2515_t *c);\n')
    done = subprocess.run(
        ["g++", *CXX14, *WARNINGS, *include, "-fsyntax-only", str(source)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
