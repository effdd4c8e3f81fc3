"""Disturbed traffic to an exported joint's node, told apart by the sending (tests/c/mixes.c)."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reference_c import reference

from ccgen.targets.compiler import sources

C = Path(__file__).parent / "c"
CORRUPT = 1966
"""Frames of 65,536 in which 1 to 3 bits are flipped, where any are: 3 %."""


@dataclass(frozen=True)
class Traffic:
    """What a run of the harness sends.

    Attributes:
        snapshots: published ones after which it ends.
        window: cycles.
        delay: cycles by which a frame may be late.
        any_number: a sender starts anew with any number and at once, not as the contract asks.
        corrupt: whether bits are flipped.
        model: only the rule runs, not the node.
    """

    snapshots: int
    window: int = 1
    delay: int = 40
    any_number: bool = False
    corrupt: bool = False
    model: bool = False


def compile_mixes(folder: Path, out: Path, *flags: str) -> Path:
    """The harness for a folder; fails with the compiler's words."""
    (out / "fuzz_reference.h").write_text(reference(folder))
    command = [
        "cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Werror",
        f"-DFUZZ_LAYOUT={folder.name}_layout", *flags, f"-I{folder / 'src'}",
        f"-I{folder / 'ports'}", f"-I{out}", C / "mixes.c", *sources(folder), "-o", out / "mixes",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out / "mixes"


def stream(program: Path, traffic: Traffic, seed: int) -> dict[str, Any]:
    """Run the harness; fails where the node departs from the rule or from the reference model."""
    arguments = [
        seed, traffic.snapshots, traffic.window, traffic.delay,
        "any" if traffic.any_number else "contract", CORRUPT if traffic.corrupt else 0,
        "model" if traffic.model else "node",
    ]  # fmt: skip
    done = subprocess.run(
        [program, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
