"""Estimates that mix sendings, under disturbed traffic: 2 million snapshots a joint and window.

An observer knows which sending each frame is of. Frames are lost, repeated, reordered, late by up
to 40 cycles (110 at the widest window), cut short; senders fall silent for 1 to 90 cycles and start
anew at any frame; the clock wraps. Where they start anew as the contract asks there must be no mix.
With any number at once a mix needs the number by chance, and that the frame which would tell does
not come before the snapshot is complete: counted beside what the rule alone gives on other traffic.
With 1 to 3 bits flipped in a frame, wrong estimates are counted beside the frames whose check did
not tell, and those beside what enumerating all such flips gives. Takes some ten minutes; needs cc.

    python tests/benchmarks/snapshot_mixes.py [--snapshots N]
"""

import argparse
import math
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent))

from mixes import Traffic, compile_mixes, stream

from ccgen.export.package import export

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
JOINTS = ("shoulder", "wrist", "spine")
WINDOWS = ((1, 40), (15, 40), (100, 110))
"""Window and most delay, cycles: the default, 150 ms, the widest."""

SIGMAS = 5.0
"""How far a count may lie from its expectation, in standard deviations of a Poisson count."""


def main() -> None:
    """Run every case; status 1 where one of them does not hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--snapshots", type=int, default=2_000_000, help="a case")
    snapshots = parser.parse_args().snapshots
    held = True
    with tempfile.TemporaryDirectory() as root:
        for joint in JOINTS:
            folder = Path(root) / joint
            export(EXAMPLES / f"{joint}.toml", folder)
            program = compile_mixes(folder, Path(root))
            for window, delay in WINDOWS:
                held &= run(program, joint, Traffic(snapshots, window, delay))
    sys.exit(0 if held else 1)


def run(program: Path, joint: str, traffic: Traffic) -> bool:
    """The three cases of one joint and window; whether all hold."""
    title = f"{joint}, window {traffic.window} cycles"
    as_asked = stream(program, traffic, seed=1)
    anew = stream(program, replace(traffic, any_number=True), seed=2)
    ruled = stream(program, replace(traffic, any_number=True, model=True), seed=3)
    flipped = stream(program, replace(traffic, corrupt=True), seed=4)
    print(
        f"{title}: {as_asked['published']:,} snapshots of {as_asked['sendings']:,} sendings, "
        f"{as_asked['restarts']:,} restarts: {as_asked['mixed']} mixed, {as_asked['slow']} late "
        f"recoveries, {as_asked['false_stale']} wrong STALE"
    )
    print(
        f"  any number: {anew['mixed']} mixed in {anew['published']:,}, {anew['by_chance']} by "
        f"chance; the rule alone: {ruled['mixed']} in {ruled['published']:,}; "
        f"{anew['slow']} late recoveries"
    )
    print(
        f"  bits flipped: {flipped['mixed']} mixed, {flipped['wrong']} wrong estimates; "
        f"{flipped['undetected']} of {flipped['corrupted']:,} frames not detected, "
        f"expected {flipped['undetected_expected']:.1f}"
    )
    return all((sound(as_asked), sound_anew(anew, ruled), sound_flipped(flipped)))


def sound(result: dict[str, Any]) -> bool:
    """Nothing mixed, nothing late, no wrong STALE."""
    return not (result["mixed"] or result["wrong"] or result["slow"] or result["false_stale"])


def sound_anew(result: dict[str, Any], ruled: dict[str, Any]) -> bool:
    """Every mix is one that the rule cannot see, and they are as many as the rule alone gives."""
    spread = SIGMAS * math.sqrt(result["mixed"] + ruled["mixed"] + 1)
    near = abs(result["mixed"] - ruled["mixed"]) <= spread
    return result["mixed"] == result["by_chance"] and near and not result["slow"]


def sound_flipped(result: dict[str, Any]) -> bool:
    """Nothing mixed, and no more wrong estimates than frames whose check could not tell."""
    expected = result["undetected_expected"]
    near = abs(result["undetected"] - expected) <= SIGMAS * math.sqrt(expected + 1)
    return result["mixed"] == 0 and result["wrong"] <= result["undetected"] and near


if __name__ == "__main__":
    main()
