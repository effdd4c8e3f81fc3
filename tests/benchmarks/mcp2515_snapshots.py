"""Snapshots through an emulated AVR and a modelled MCP2515, both ways, without and with mishaps.

    python tests/benchmarks/mcp2515_snapshots.py [SNAPSHOTS]

Of examples/wrist.toml; 10,000 unless another number is given. Values are decoded with cantools,
checked with autosar-e2e and held against the integer reference model.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from avr_mcp2515 import Board
from mcp2515 import frame

from ccgen.export.package import export

EXAMPLES = Path(__file__).resolve().parent.parent.parent / "examples"
EVERY = 100
"""Snapshots from one mishap to the next."""


def mishaps(board: Board, snapshots: int) -> tuple[list[str], list[str], list[int]]:
    """Frames of others, what else goes wrong, and the snapshots after which it is over."""
    layout, strange, spans, over = board.exported.layout, [], [], []
    for turn, k in enumerate(range(EVERY, snapshots - EVERY, EVERY)):
        at = board.time_of(k) + 137 * turn % board.cycle_us
        kind, last = turn % 3, k + 1
        if kind == 0 and turn < 90:
            spans.append(f"broken {at} {at + 30_000}")
            last = k + 1 + 35_000 // board.cycle_us
        elif kind == 1:
            spans.append(f"deaf {at} {at + 20 * board.cycle_us}")
            last = k
        else:
            strange += [
                frame(at + 50 * i, layout.base_id, bytes(8), int(layout.extended))
                for i in range(40)
            ]
        over.append(last)
    return strange, spans, over


def main() -> None:
    """Print the figures."""
    snapshots = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    with tempfile.TemporaryDirectory() as name:
        out = Path(name)
        export(EXAMPLES / "wrist.toml", out / "wrist", examples=["mcp2515"])
        board = Board(out / "wrist", out)
        told = board.run(board.traffic(snapshots), snapshots)
        answered, wrong = board.answers(told, snapshots)
        print(f"quiet: {len(answered):,} of {snapshots:,} answered, {wrong} values wrong")
        print(f"  {told.counters}, {told.violations or 'as the data sheet asks'}")
        strange, spans, over = mishaps(board, snapshots)
        script = [*board.traffic(snapshots), *strange]
        told = board.run([*sorted(script, key=lambda s: int(s.split()[1])), *spans], snapshots)
        answered, wrong = board.answers(told, snapshots)
        late = sum(not {k + 1 + i for i in range(3)} & answered for k in over)
        print(f"{len(over)} mishaps: {len(answered):,} of {snapshots:,} answered, {wrong} wrong")
        print(f"  {late} not over within three good cycles; {told.overruns} overruns of the chip")
        print(f"  {told.counters}, {told.violations or 'as the data sheet asks'}")


if __name__ == "__main__":
    main()
