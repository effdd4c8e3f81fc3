"""What happens on a bus with a modelled MCP2515, and what others make of it."""

import subprocess
from dataclasses import dataclass, field
from pathlib import Path

OSCILLATOR, RATE = 16_000_000, 1_000_000


@dataclass(frozen=True)
class Sent:
    """A frame that the chip sent, with its time in microseconds."""

    at: int
    id: int
    flags: int
    data: bytes


@dataclass
class Told:
    """What a run told: frames in the order of the bus, counters of the port, truth of the model."""

    sent: list[Sent] = field(default_factory=list)
    counters: dict[str, int] = field(default_factory=dict)
    started: int | None = None
    nested: int = 0
    clocks: int = 0
    overruns: int = 0
    violations: str = ""


COUNTERS = ("received", "dropped", "sent", "aborted", "bus_off", "errors")


def frame(at: int, id_: int, data: bytes, flags: int = 0, code: int | None = None) -> str:
    """A line of the script: somebody else sends."""
    return f"frame {at} {id_:x} {flags} {len(data) if code is None else code} {data.hex() or '-'}"


def run(command: list[str | Path], script: list[str]) -> Told:
    """Run a program of tests/c/mcp2515 with a script; frames are those of any time first."""
    done = subprocess.run(
        [str(part) for part in command], input="\n".join(script) + "\n", capture_output=True,
        text=True, check=False, timeout=600,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    told = Told()
    for line in done.stdout.splitlines():
        word, *rest = line.split()
        if word == "counters":
            told.counters = dict(zip(COUNTERS, map(int, rest), strict=True))
        elif word == "started":
            told.started, told.nested, told.clocks = int(rest[0]), int(rest[2]), int(rest[4])
        elif word == "model":
            told.overruns = int(rest[0])
            told.violations = "" if rest[1] == "0" else " ".join(rest[2:])
        else:
            id_, flags, length, data = rest
            payload = b"" if data == "-" else bytes.fromhex(data)
            assert len(payload) == int(length)
            told.sent.append(Sent(int(word), int(id_, 16), int(flags, 16), payload))
    return told
