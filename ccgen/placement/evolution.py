"""The paper's evolutionary algorithm (section 2.6), with DEAP.

An individual is a list of 2n segment numbers, a pair for each sensor, swapped into order where
need be. A whole generation is evaluated at once.
"""

from __future__ import annotations

import itertools
import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from deap import algorithms, base, tools
from deap.tools import crossover, mutation, selection

from ccgen.errors import InputError, require_least
from ccgen.joint.layouts import AnySpans
from ccgen.placement.compare import best_of
from ccgen.placement.objective import Floats, Indices
from ccgen.placement.problem import Placement
from ccgen.placement.question import Question
from ccgen.placement.settings import Report, silent

WORST = 200.0
"""Fitness of an invalid individual: 2 ROM for every angle, in % of ROM."""

_FINALISTS = 20
"""Best individuals ever seen whose objective is computed again without approximation."""

_RANDOM_USERS = (algorithms, crossover, mutation, selection)
_LOCK = threading.Lock()


@dataclass(frozen=True)
class Evolution:
    """Settings of the algorithm; the paper's, where it states them.

    Attributes:
        individuals: size of the population.
        generations: how many follow the first.
        crossover: probability of mating a pair.
        mutation: probability of mutating an individual.
        gene_mutation: probability of each number of a mutated individual; not in the paper.
        tournament: individuals of a tournament; not in the paper.
        seed: of the random numbers.
    """

    individuals: int = 500
    generations: int = 10
    crossover: float = 0.7
    mutation: float = 0.5
    gene_mutation: float = 0.2
    tournament: int = 3
    seed: int = 0

    def check(self) -> None:
        """Refuse settings that the algorithm cannot run with.

        Raises:
            InputError: which, and what would be right.
        """
        require_least(1, "individuals", self.individuals)
        require_least(0, "generations", self.generations)
        require_least(0, "seed", self.seed)
        if self.tournament < 1:
            raise InputError(f"tournaments of {self.tournament} have no winner; give at least 1")
        for share in (self.crossover, self.mutation, self.gene_mutation):
            if not 0 <= share <= 1:
                raise InputError(f"probability {share:g} is not one; give 0 to 1")


class _Random(random.Random):
    """A generator whose integers come from one floating-point draw.

    Those of the standard library go through several calls each, which takes longer than
    evaluating an individual. The bias is below 2^-40.
    """

    def randint(self, a: int, b: int) -> int:
        return a + int(self.random() * (b - a + 1))

    def choice(self, seq: Any) -> Any:
        return seq[int(self.random() * len(seq))]


class _Fitness(base.Fitness):  # type: ignore[misc]
    weights = (-1.0,)

    def __gt__(self, other: Any) -> bool:
        return bool(self.wvalues > other.wvalues)


class _Individual(list[int]):
    """Numbers of first and last segments, and the fitness that DEAP asks for."""

    def __init__(self, genes: list[int]) -> None:
        super().__init__(genes)
        self.fitness = _Fitness()


def _clone(individual: _Individual) -> _Individual:
    """A copy; DEAP's usual deep copy takes longer than evaluating one."""
    fitness = _Fitness.__new__(_Fitness)
    fitness.wvalues = individual.fitness.wvalues
    twin = _Individual.__new__(_Individual)
    twin.extend(individual)
    twin.fitness = fitness
    return twin


def evolve(
    problem: Question, settings: Evolution | None = None, report: Report = silent
) -> Placement:
    """Run the evolutionary algorithm.

    The best placement ever seen is returned, or the heuristic one if that is better and allowed.

    Args:
        problem: the joint, its sensors and constraints.
        settings: the paper's by default.
        report: called after each generation.

    Raises:
        InputError: impossible settings, or no allowed placement was met.
    """
    settings = settings or Evolution()
    settings.check()
    with _seeded(settings.seed):
        best, evaluations = _run(problem, settings, report)
    candidates = [spans for spans in best if not problem.violations(spans[None])[0]]
    usual = _heuristic(problem)
    if usual is not None:
        candidates.append(np.array(usual, dtype=np.intp))
    if not candidates:
        raise InputError(
            "the evolutionary algorithm met no placement that keeps to the constraints;"
            " loosen them, or use the search"
        )
    spans, percent = best_of(problem, np.array(candidates))
    return Placement("evolutionary", spans, percent, evaluations)


def _run(problem: Question, settings: Evolution, report: Report) -> tuple[Indices, int]:
    """The best distinct individuals as placements, and evaluations."""
    toolbox = _toolbox(problem, settings)
    generations = settings.generations + 1
    finished = itertools.count(1)

    def evaluate_all(evaluate: Any, individuals: Any) -> list[tuple[float]]:
        """DEAP's map, for an evaluation that takes the whole generation."""
        generation = list(individuals)
        found = evaluate(generation).tolist() if generation else []
        report(next(finished), generations)
        return [(value,) for value in found]

    toolbox.register("map", evaluate_all)
    best = tools.HallOfFame(_FINALISTS)
    population = toolbox.population(n=settings.individuals)
    _, log = algorithms.eaSimple(
        population,
        toolbox,
        cxpb=settings.crossover,
        mutpb=settings.mutation,
        ngen=settings.generations,
        halloffame=best,
        verbose=False,
    )
    return decode(problem, best), sum(log.select("nevals"))


def _toolbox(problem: Question, settings: Evolution) -> base.Toolbox:
    genes = 2 * len(problem.slots.free)
    top = problem.segments - 1
    toolbox = base.Toolbox()
    # `algorithms.random` is the seeded generator only while the algorithm runs.
    toolbox.register("gene", lambda: algorithms.random.randint(0, top))
    toolbox.register("individual", tools.initRepeat, _Individual, toolbox.gene, genes)
    toolbox.register("population", tools.initRepeat, list, toolbox.individual)
    toolbox.register("select", tools.selTournament, tournsize=settings.tournament)
    toolbox.register("mate", tools.cxOnePoint if genes > 1 else lambda a, b: (a, b))
    toolbox.register("mutate", tools.mutUniformInt, low=0, up=top, indpb=settings.gene_mutation)
    toolbox.register("clone", _clone)
    toolbox.register("evaluate", lambda generation: fitnesses(problem, decode(problem, generation)))
    return toolbox


def decode(problem: Question, individuals: Any) -> Indices:
    """Placements of individuals, shape (P, n, 2), with the sensors that stay in their slots."""
    pairs = np.array(list(individuals), dtype=np.intp).reshape(len(individuals), -1, 2)
    spans = np.empty((len(pairs), problem.sensors, 2), dtype=np.intp)
    spans[:, problem.slots.free] = np.sort(pairs, axis=-1)
    for slot, span in problem.slots.held.items():
        spans[:, slot] = span
    return spans


def fitnesses(problem: Question, spans: Indices) -> Floats:
    """Objective of each placement in %; the worst where a constraint is broken, shape (P,)."""
    valid = problem.violations(spans) == 0
    result = np.full(len(spans), WORST)
    result[valid] = problem.model.values(spans[valid])
    return result


def _heuristic(problem: Question) -> AnySpans | None:
    """The heuristic placement, where there is one that is allowed."""
    try:
        spans = problem.laid_out("heuristic")
    except InputError:
        return None
    return spans if problem.allows(spans) else None


@contextmanager
def _seeded(seed: int) -> Iterator[None]:
    """Give DEAP's modules a generator of their own.

    They use the process-wide one of the module `random`, which other threads use too: on a
    cluster's worker, say, where the same seed must give the same result.
    """
    generator = _Random(seed)
    with _LOCK:
        shared = [module.random for module in _RANDOM_USERS]
        try:
            for module in _RANDOM_USERS:
                module.random = generator
            yield
        finally:
            for module, original in zip(_RANDOM_USERS, shared, strict=True):
                module.random = original
