"""Placement of sensors one by one against an exchange over all spans, from many starts.

Nine strings at 120 degrees, in pairs or in a plane, on a joint of 12 segments with loads, by the
angles and by the tip. The exchange moves one string at a time to the best of all spans by the
objective itself, from random starts. Exits with status 1 where the search is worse than 1.01 times
the best of it.

    python tests/benchmarks/listed_placement.py [--starts 6 --segments 12]
"""

import argparse
import sys
import time

import numpy as np

from ccgen.estimation.sources import simulated_sources
from ccgen.joint.file import parse_joint
from ccgen.placement import ListedProblem, search

JOINT = """
name = "strung"
[geometry]
segments = {segments}
length = 0.24
range_of_motion = 4.0
{elongation}
[sensors.transducer]
bits = 14
metres_per_count = 2e-5
noise = 5e-5
gain_tolerance = 0.01
[loads]
stiffness = 0.3
stiffness_profile = [2.0, 1.0, 1.0, 2.0]
actuation = [-40.0, 40.0]
tip_force = [0.0, 1.5]
contact = [0.0, 3.0]
{elongation}
[estimator]
method = "noise-aware"
{axes}
"""

STRETCH = "elongation = [0.0, 0.05]"
KINDS = {
    "nine at 120 degrees": ([90, 210, 330] * 3, STRETCH, ""),
    "four pairs and one": ([90, 270, 0, 180] * 2 + [45], STRETCH, ""),
    "nine without elongation": ([90, 210, 330] * 3, "", ""),
    "five in a plane": ([180, 0, 180, 0, 150], STRETCH, 'axes = ["v", "h"]'),
}


def problem_of(kind, segments, by_tip):
    degrees, elongation, axes = KINDS[kind]
    text = JOINT.format(segments=segments, elongation=elongation, axes=axes)
    for j, angle in enumerate(degrees):
        noise = "noise = 1e-4" if j == 4 else ""
        place = f"span = [0, {segments - 1}]\nangle = {angle}\nradius = 0.03"
        text += f'[[sensor]]\nname = "s{j}"\n{place}\n{noise}\n'
    joint = parse_joint(text, "strings.toml")
    return ListedProblem(joint=joint, sources=simulated_sources(joint), by_tip=by_tip)


def exchanged(problem, starts):
    """The lowest objective that moves of one string at a time reach, from random starts."""
    random, lowest = np.random.default_rng(5), np.inf
    catalogue = problem.catalogue
    for _ in range(starts):
        spans = catalogue[random.integers(len(catalogue), size=problem.sensors)]
        best, rested, slot = np.inf, 0, 0
        while rested < problem.sensors:
            tried = np.repeat(spans[None], len(catalogue), axis=0)
            tried[:, slot] = catalogue
            values = problem.percents(tried) + 200.0 * problem.violations(tried)
            rested += 1
            if values.min() < best * (1 - 1e-9):
                best, spans, rested = values.min(), tried[np.argmin(values)], 1
            slot = (slot + 1) % problem.sensors
        lowest = min(lowest, best)
    return lowest


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--starts", type=int, default=6)
    parser.add_argument("--segments", type=int, default=12)
    options = parser.parse_args()
    worst = 0.0
    for kind in KINDS:
        for by_tip in (False, True):
            problem = problem_of(kind, options.segments, by_tip)
            start = time.process_time()
            found = problem.percents(np.array([search(problem).spans]))[0]
            seconds = time.process_time() - start
            best = exchanged(problem, options.starts)
            worst = max(worst, found / best)
            print(
                f"{kind}, {problem.objective}: search {found:.5g} % ({seconds:.1f} s), exchange "
                f"from {options.starts} starts {best:.5g} %, ratio {found / best:.5f}",
                flush=True,
            )
    print(f"largest ratio {worst:.5f}")
    return 0 if worst <= 1.01 else 1


if __name__ == "__main__":
    sys.exit(main())
