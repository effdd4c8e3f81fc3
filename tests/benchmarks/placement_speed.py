"""Time of the evolutionary algorithm per evaluation: batched, and the literal way.

The literal way is DEAP as in its manual, its evaluation one individual at a time: readings by
sums over spans, one `scipy.optimize.least_squares(loss="soft_l1", f_scale=0.1)` a segment with
default tolerances, then the sum of absolute errors. Both run here, one after the other, on the
same joint and the same thread, in processor time. Individuals that leave a segment bare take next
to no time and do not count; the literal way runs again and again, with other individuals, until
enough have counted. Two factors are printed: of the cost of an evaluation, and of whole
runs with as many evaluations, where DEAP's own share weighs in. Exits with status 1 where an
evaluation is not 1000 times cheaper.

    python tests/benchmarks/placement_speed.py [--segments 48 --degrees 4 --sensors 4]
"""

import argparse
import os
import random
import sys
import time

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import numpy as np
from deap import algorithms, base, creator, tools
from scipy.optimize import least_squares

from ccgen.placement import Problem, evolution
from ccgen.shapes import shape_library

creator.create("Cost", base.Fitness, weights=(-1.0,))
creator.create("Individual", list, fitness=creator.Cost)

RADIUS = 0.004
REQUIRED = 1000


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--segments", type=int, default=48)
    parser.add_argument("--degrees", type=float, default=4.0)
    parser.add_argument("--sensors", type=int, default=4)
    parser.add_argument("--individuals", type=int, default=200, help="of one literal run")
    parser.add_argument("--evaluations", type=int, default=100, help="of the literal way, at least")
    options = parser.parse_args()
    if min(options.individuals, options.evaluations) < 1:
        parser.error("--individuals and --evaluations: give at least 1")
    rom = np.radians(options.degrees)
    fit = shape_library(options.segments, rom, 30)
    score = shape_library(options.segments, rom, 10)
    problem = Problem(fit, score, options.sensors)
    print(f"{options.segments} segments, {options.degrees:g} degrees, {options.sensors} sensors")
    batched = report("batched", *evolve_batched(problem))
    literal = report(
        "literal", *evolve_literally(problem, options.individuals, options.evaluations)
    )
    factor, whole = (slow / fast for slow, fast in zip(literal, batched, strict=True))
    print(f"an evaluation: {factor:.0f} times cheaper (required {REQUIRED})")
    print(f"a whole run: {whole:.0f} times cheaper")
    return 0 if factor >= REQUIRED else 1


def report(name, watch, seconds, best):
    """Print and return the processor time of one evaluation, alone and with all else, seconds."""
    alone, share = watch.seconds / watch.placements, seconds / watch.placements
    print(
        f"{name}: {watch.placements} evaluations, {1e6 * alone:.1f} us each,"
        f" {1e6 * share:.1f} us with the algorithm's share; best {best:.5g} % of ROM"
    )
    return alone, share


class Watch:
    """Counts valid evaluations, and their processor time."""

    def __init__(self, evaluate):
        self.evaluate = evaluate
        self.placements = 0
        self.seconds = 0.0

    def __call__(self, *arguments):
        start = time.process_time()
        values = self.evaluate(*arguments)
        self.seconds += time.process_time() - start
        self.placements += int(np.sum(np.asarray(values) < evolution.WORST))
        return values


def evolve_batched(problem):
    start = time.process_time()
    watch = Watch(evolution.fitnesses)
    evolution.fitnesses = watch
    found = evolution.evolve(problem, evolution.Evolution(seed=1))
    return watch, time.process_time() - start, found.percent


def evolve_literally(problem, individuals, evaluations):
    """The paper's algorithm with fewer individuals and one generation, until enough are valid."""
    start = time.process_time()
    watch = Watch(lambda individual: evaluate(problem, individual))
    toolbox = base.Toolbox()
    top = problem.segments - 1
    genes = 2 * problem.sensors
    toolbox.register("gene", random.randint, 0, top)
    toolbox.register("individual", tools.initRepeat, creator.Individual, toolbox.gene, genes)
    toolbox.register("population", tools.initRepeat, list, toolbox.individual)
    toolbox.register("evaluate", watch)
    toolbox.register("mate", tools.cxOnePoint)
    toolbox.register("mutate", tools.mutUniformInt, low=0, up=top, indpb=0.2)
    toolbox.register("select", tools.selTournament, tournsize=3)
    random.seed(1)
    best = tools.HallOfFame(1)
    while watch.placements < evaluations:
        population = toolbox.population(individuals)
        algorithms.eaSimple(population, toolbox, 0.7, 0.5, 1, halloffame=best, verbose=False)
    return watch, time.process_time() - start, best[0].fitness.values[0]


def evaluate(problem, individual):
    """Cost of one individual in % of the range of motion, as section 2.6.3 of the paper says."""
    segments = problem.segments
    pairs = zip(individual[::2], individual[1::2], strict=True)
    spans = [(min(pair), max(pair)) for pair in pairs]
    if {k for a, b in spans for k in range(a, b + 1)} != set(range(segments)):
        return (evolution.WORST,)
    fit, score = problem.fit.angles, problem.score.angles
    lengths = RADIUS * means(fit, spans)
    error = 0.0
    for segment in range(segments):
        target = RADIUS * fit[:, segment]
        weights = least_squares(
            lambda w, target=target: lengths @ w - target,
            np.ones(len(spans)),
            loss="soft_l1",
            f_scale=0.1,
        ).x
        error += np.abs(means(score, spans) @ weights - score[:, segment]).sum()
    return (100 * error / (score.size * problem.score.range_of_motion),)


def means(angles, spans):
    """Mean angle over each span, shape (N, n)."""
    return np.stack([angles[:, a : b + 1].mean(axis=1) for a, b in spans], axis=1)


if __name__ == "__main__":
    sys.exit(main())
