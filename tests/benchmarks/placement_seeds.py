"""Search against the evolutionary algorithm over ten seeds, on all 80 joints.

For 4 to 6 sensors: the search must never be worse than the best of the seeds. For 12 segments and
2 and 3 sensors: the search must be proven, and equal to the best of all placements as
`ccgen.estimation` itself scores them. Exits with status 1 otherwise.

    python tests/benchmarks/placement_seeds.py [--seeds 10 --processes 2 --joints 12,48:8]
"""

import argparse
import itertools
import sys
import time

import numpy as np

from ccgen.placement import Evolution, Problem, evolve, search
from ccgen.shapes import shape_library
from ccgen.study import spread
from ccgen.study.joints import all_joints, chosen_joints


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--processes", type=int)
    parser.add_argument("--joints")
    options = parser.parse_args()
    joints = chosen_joints(options.joints) if options.joints else all_joints()
    with spread.on_processes(options.processes) as executor:
        contests = [
            executor.submit(contest, joint, sensors, options.seeds)
            for joint in joints
            for sensors in (4, 5, 6)
        ]
        proofs = [
            executor.submit(proof, joint, sensors)
            for joint in joints
            for sensors in (2, 3)
            if joint.segments == 12
        ]
        ratios = [print_contest(*future.result()) for future in contests]
        proven = [print_proof(*future.result()) for future in proofs]
    worse = sum(ratio > 1 for ratio in ratios)
    print(f"{len(ratios)} contests of {options.seeds} seeds: search worse in {worse};")
    print(f"search over best seed: largest {max(ratios):.9f}, median {np.median(ratios):.6f}")
    print(f"{len(proven)} exhaustive optima: {sum(proven)} returned and proven")
    return 0 if not worse and all(proven) else 1


def problem(joint, sensors):
    rom = np.radians(joint.range_of_motion_deg)
    fit, score = (shape_library(joint.segments, rom, samples) for samples in (30, 10))
    return Problem(fit, score, sensors)


def contest(joint, sensors, seeds):
    posed = problem(joint, sensors)
    start = time.process_time()
    found = search(posed)
    seconds = time.process_time() - start
    evolved = [evolve(posed, Evolution(seed=seed)).percent for seed in range(seeds)]
    return joint, sensors, found, seconds, evolved


def proof(joint, sensors):
    """The search, and the best of all covering placements from the definition."""
    posed = problem(joint, sensors)
    spans = [(a, b) for a in range(joint.segments) for b in range(a, joint.segments)]
    sets = np.array(list(itertools.combinations_with_replacement(spans, sensors)))
    covered = (posed.violations(sets) == 0).nonzero()[0]
    return joint, sensors, search(posed), float(posed.percents(sets[covered]).min())


def print_contest(joint, sensors, found, seconds, evolved):
    ratio = found.percent / min(evolved)
    print(
        f"{joint.name} n={sensors}: search {found.percent:.6g} ({found.optimality}, {seconds:.1f}"
        f" s), evolution {min(evolved):.6g} to {max(evolved):.6g}, ratio {ratio:.6f}",
        flush=True,
    )
    return ratio


def print_proof(joint, sensors, found, best):
    same = found.optimality == "proven" and abs(found.percent / best - 1) < 1e-9
    print(f"{joint.name} n={sensors}: search {found.percent:.10g}, best of all {best:.10g}")
    return same


if __name__ == "__main__":
    sys.exit(main())
