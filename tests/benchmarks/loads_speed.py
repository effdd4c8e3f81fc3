"""Time to draw loads and to bend a joint under them, and to draw other loads, in processor time.

All kinds of load act at once, with stiffness and elongation drawn too. Exits with status 1 where
300 drawn loads of 24 segments take 10 seconds or more.

    python tests/benchmarks/loads_speed.py
"""

import math
import os
import sys
import time

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

from ccgen.joint.loads import LoadRanges
from ccgen.shapes.loads.drawn import drawn_shapes
from ccgen.shapes.loads.other import other_shapes

ALLOWED = 10.0
RANGES = LoadRanges(
    samples=300,
    stiffness=0.4,
    stiffness_profile=(2.0, 1.0, 1.0, 2.5),
    stiffness_tolerance=0.1,
    actuation=(-math.pi / 2, math.pi / 2),
    mass=0.4,
    payload=(0.0, 0.25),
    tip_force=(0.0, 6.0),
    tip_moment=(0.0, 0.2),
    contact=(0.0, 6.0),
    contact_from=0.05,
    elongation=(0.0, 0.03),
)


def main():
    drawn_shapes(RANGES, (6, 6), 0.24, math.radians(3.0))  # imports
    for segments in (12, 24, 64):
        begin = time.process_time()
        drawn = drawn_shapes(RANGES, (segments,), 0.24, math.radians(36.0 / segments))
        drawing = time.process_time() - begin
        scaled = int((drawn.factor < 1).sum())
        begin = time.process_time()
        other = other_shapes(segments, math.radians(36.0 / segments))
        others = time.process_time() - begin
        print(
            f"{segments} segments: {len(drawn.shapes)} drawn loads, {scaled} scaled back,"
            f" {drawing:.2f} s; {len(other.kinds)} other loads, {others:.3f} s"
        )
        if segments == 24 and drawing >= ALLOWED:
            sys.exit(1)


if __name__ == "__main__":
    main()
