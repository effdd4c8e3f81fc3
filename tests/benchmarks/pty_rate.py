"""Snapshots a second through the node's process on a pseudo-terminal, without a lost frame.

The joint has 12 segments and 3 + 3 sensors and a cycle of 2 ms: a snapshot is 2 frames in, and 8
frames of angles, tip and status out. First a minute at 500 snapshots a second (6,000 frames a
second, four fifths of what a bus of 1 Mbit/s carries), then as fast as answers come.
"""

import argparse
import tempfile
from pathlib import Path

from ccgen.can.exchange import Exchange, Pace, exchange
from ccgen.can.transports.process import process_node
from ccgen.export.package import export
from ccgen.targets.exported import Exported, open_exported
from ccgen.targets.host import compile_process
from ccgen.targets.inputs import bus_counts

SHOULDER = Path(__file__).resolve().parents[2] / "examples" / "shoulder.toml"
RATE_HZ = 500


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=60, help="at 500 snapshots a second")
    seconds = parser.parse_args().seconds
    with tempfile.TemporaryDirectory() as folder:
        exported = exported_shoulder(Path(folder))
        program = compile_process(exported.directory, Path(folder))
        show("paced", run(exported, program, RATE_HZ * seconds, Pace(rate_hz=RATE_HZ)))
        for in_flight in (1, 2, 4, 8, 14):
            answers = run(exported, program, 20_000, Pace(in_flight=in_flight))
            show(f"unpaced, {in_flight} in flight", answers)


def exported_shoulder(folder: Path) -> Exported:
    text = SHOULDER.read_text(encoding="utf-8").replace("cycle_ms = 10", "cycle_ms = 2")
    joint = folder / "shoulder.toml"
    joint.write_text(text, encoding="utf-8")
    export(joint, folder / "shoulder")
    return open_exported(folder / "shoulder")


def run(exported: Exported, program: Path, snapshots: int, pace: Pace) -> Exchange:
    with process_node(program) as bus:
        return exchange(bus, exported.codec, bus_counts(exported, snapshots, seed=1), pace)


def show(title: str, answers: Exchange) -> None:
    frames = 2 * answers.snapshots + 9 * int(answers.complete.sum()) + len(answers.statuses)
    print(
        f"{title:<24} {answers.snapshots:>7,} snapshots in {answers.seconds:5.1f} s: "
        f"{answers.rate_hz:6,.0f} snapshots/s, {frames / answers.seconds:7,.0f} frames/s, "
        f"{len(answers.statuses):,} statuses, {answers.lost_frames} lost frames"
    )


if __name__ == "__main__":
    main()
