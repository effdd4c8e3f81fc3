"""A client written from an exported README alone: cantools, autosar-e2e, model.json, no ccgen."""

import json
import os
import re
import select
import shlex
import subprocess
import termios
import tty
from pathlib import Path

import cantools
import e2e.p01
import e2e.p05
import numpy as np
import pytest
from test_both_ends import EXAMPLES, ODD

from ccgen.export.package import export
from ccgen.joint.file import parse_joint

SNAPSHOTS = 1000
JOINTS = {
    "shoulder": (EXAMPLES / "shoulder.toml").read_text(),
    "spine": (EXAMPLES / "spine.toml").read_text(),
    "odd": ODD,
}
PROTECT = {"P01": e2e.p01.e2e_p01_protect, "P05": e2e.p05.e2e_p05_protect}
CHECK = {"P01": e2e.p01.e2e_p01_check, "P05": e2e.p05.e2e_p05_check}
BYTES = (*range(9), 12, 16, 20, 24, 32, 48, 64)


@pytest.fixture(scope="module", params=JOINTS)
def folder(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("client") / request.param
    export(parse_joint(JOINTS[request.param], f"{request.param}.toml"), folder)
    return folder


def frames_in(database, kind):
    name = f"_{kind}"
    return sorted((m for m in database.messages if name in m.name), key=lambda m: m.frame_id)


def protected(message, counter, values):
    """Bytes of a LENGTHS frame: cantools packs, autosar-e2e protects."""
    values = {"crc": 0, "counter": counter, **values}
    data = bytearray(message.encode(values, scaling=False, padding=False, strict=True))
    attributes = message.dbc.attributes
    # The library's call advances the counter that it finds and then protects.
    modulus = 15 if attributes["E2EProfile"].value == "P01" else 256
    before = (counter - 1) % modulus
    if modulus == 15:
        data[1] = data[1] & 0xF0 | before
    else:
        data[2] = before
    PROTECT[attributes["E2EProfile"].value](data, attributes["E2EDataId"].value)
    return bytes(data)


def line_of(message, data):
    letter = "d" if message.is_fd else "t"
    if message.is_extended_frame:
        return f"{letter.upper()}{message.frame_id:08X}{BYTES.index(len(data)):X}{data.hex()}\r"
    return f"{letter}{message.frame_id:03X}{BYTES.index(len(data)):X}{data.hex()}\r"


def number_of(message, number):
    """Counter and turn of a snapshot's number."""
    if message.is_fd:
        return number % 256, {}
    turn, counter = divmod(number % 240, 15)
    return counter, {"turn": turn}


def lines_of(database, number, counts):
    """A snapshot's LENGTHS frames."""
    waiting = iter(counts)
    for message in frames_in(database, "LENGTHS"):
        signals = [s.name for s in message.signals if s.name.startswith("length_")]
        counter, turn = number_of(message, number)
        values = {name: int(next(waiting)) for name in signals} | turn
        yield message, protected(message, counter, values)


def expected(model, counts):
    """The formula of the README."""
    rows = []
    for axis in model["axes"].values():
        weights = np.array(axis["weights"], dtype=object)
        mine = slice(axis["first"], axis["first"] + weights.shape[1])
        moved = (counts - np.concatenate(zeros_of(model)))[:, mine].astype(object)
        values = (np.array(axis["bias"], dtype=object) + moved @ weights.T) >> axis["shift"]
        limit = 2 ** (model["precision"] - 1) - 1
        rows.append(np.clip(values.astype(np.int64), -limit, limit))
    return np.hstack(rows)


def zeros_of(model):
    """Zeros of all sensors, in their order."""
    own = {axis["first"]: axis["zero"] for axis in model["axes"].values()}
    return [own[first] for first in sorted(own)]


def test_the_snapshot_that_is_worked_out_is_what_others_make_of_it(folder):
    database = cantools.database.load_file(folder / f"{folder.name}.dbc")
    text = (folder / "README.md").read_text()
    told = re.search(r"Number (\d+)(?: \(turn \d+, counter \d+\))?, counts ([\d, ]+):", text)
    counts = [int(count) for count in told[2].split(", ")]
    made = [
        f"0x{message.frame_id:03X}  {data.hex(' ')}"
        for message, data in lines_of(database, int(told[1]), counts)
    ]
    assert "\n".join(made) in text
    first = line_of(*next(iter(lines_of(database, int(told[1]), counts))))
    assert first.upper().strip() in text.upper()


class Line:
    """A pseudo-terminal with the node at its far end."""

    def __init__(self, program: Path) -> None:
        self.near, far = os.openpty()
        tty.setraw(far, termios.TCSANOW)
        name = os.ttyname(far)
        self.node = subprocess.Popen([program, "--patient", name])
        os.close(far)
        self.waiting = b""
        self.write("S8\rO\r")

    def write(self, text: str) -> None:
        data = text.encode()
        while data:
            data = data[os.write(self.near, data) :]

    def lines(self, enough):
        """Lines until one is the last of an answer."""
        while True:
            while b"\r" not in self.waiting:
                ready, _, _ = select.select([self.near], [], [], 60)
                assert ready, "the node does not answer"
                self.waiting += os.read(self.near, 65536)
            line, _, self.waiting = self.waiting.partition(b"\r")
            if len(line) > 4:
                yield line.decode()
                if enough(line.decode()):
                    return

    def close(self) -> None:
        self.node.terminate()
        self.node.wait(60)
        os.close(self.near)


@pytest.fixture
def line(folder, tmp_path):
    (command,) = re.findall(
        r"^cc .*ports/posix/main\.c.*$", (folder / "README.md").read_text(), re.M
    )
    program = tmp_path / "node"
    words = shlex.split(command)
    words[-1] = str(program)
    subprocess.run(["sh", "-c", " ".join(words)], cwd=folder, check=True)
    line = Line(program)
    yield line
    line.close()


def test_a_client_from_the_readme_alone_gets_the_formulas_angles(folder, line):
    database = cantools.database.load_file(folder / f"{folder.name}.dbc")
    model = json.loads((folder / "model.json").read_text())
    low, high = (
        np.concatenate([axis[end] for axis in model["axes"].values()])
        for end in ("minimum", "maximum")
    )
    zeros = np.concatenate(zeros_of(model))
    if len(low) != len(zeros):
        low, high = low[: len(zeros)], high[: len(zeros)]
    reach = np.minimum(zeros - low, high - zeros) // 4
    shapes = np.random.default_rng(5).uniform(-1, 1, (SNAPSHOTS, 2))
    counts = zeros + np.round(reach * shapes[:, :1]).astype(np.int64)
    wanted = expected(model, counts)
    prefix = folder.name.upper()
    found, own = np.full_like(wanted, 2**40), {"STATUS": [], "HEALTH": []}
    order = [
        s.name
        for m in frames_in(database, "ANGLES")
        for s in m.signals
        if s.name[:2] in ("an", "el")
    ]

    def decoded(text):
        digits = 8 if text[0].isupper() else 3
        message = database.get_message_by_frame_id(int(text[1 : 1 + digits], 16))
        data = bytearray.fromhex(text[2 + digits :])
        assert len(data) == message.length == BYTES[int(text[1 + digits], 16)]
        attributes = message.dbc.attributes
        assert CHECK[attributes["E2EProfile"].value](data, attributes["E2EDataId"].value)
        return message.name, message.decode(data, scaling=False, decode_choices=False)

    def answers(text, sample):
        """Whether this is the STATUS that ends the answer, not one that silence brought."""
        name, values = decoded(text)
        return name == f"{prefix}_STATUS" and values["sample_counter"] == sample

    for k, row in enumerate(counts):
        line.write("".join(line_of(*frame) for frame in lines_of(database, k, row)))
        for text in line.lines(lambda text, sample=k + 1: answers(text, sample)):
            name, values = decoded(text)
            kind = name.removeprefix(f"{prefix}_").partition("_")[0]
            if kind in own:
                own[kind].append(values["counter"])
            else:
                counter, turn = number_of(database.get_message_by_name(name), k)
                assert (values["counter"], values.get("turn")) == (counter, turn.get("turn"))
            if kind == "ANGLES":
                for signal, value in values.items():
                    if signal in order:
                        found[k, order.index(signal)] = value
    assert np.array_equal(found, wanted)
    *_, last = line.lines(lambda text: decoded(text)[0] == f"{prefix}_HEALTH")
    health = decoded(last)[1]
    assert {health[f"axis_{axis}"] for axis in model["axes"]} == {0}
    modulus = 256 if database.messages[0].is_fd else 15
    for counters in own.values():
        assert counters == [(counters[0] + k) % modulus for k in range(len(counters))]
