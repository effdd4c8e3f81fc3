import random
import threading

import numpy as np
import pytest

from ccgen.errors import InputError
from ccgen.joint.layouts import heuristic
from ccgen.placement import (
    Constraints,
    Evolution,
    Problem,
    Search,
    evolution,
    evolve,
    search,
)
from ccgen.placement.evolution import decode, fitnesses
from ccgen.shapes import shape_library

SMALL = Evolution(individuals=60, generations=4)


def problem(segments, degrees, sensors, noise=0.0, **limits):
    rom = np.radians(degrees)
    fit, score = shape_library(segments, rom, 30), shape_library(segments, rom, 10)
    return Problem(fit, score, sensors, Constraints(**limits), noise)


def test_settings_are_the_papers():
    settings = Evolution()
    assert (settings.individuals, settings.generations) == (500, 10)
    assert (settings.crossover, settings.mutation) == (0.7, 0.5)


def test_pairs_of_an_individual_are_swapped_into_order():
    posed = problem(12, 3.0, 2)
    assert decode(posed, [[7, 0, 4, 11]]).tolist() == [[[0, 7], [4, 11]]]


def test_fixed_sensors_are_no_genes():
    posed = problem(12, 3.0, 2, fixed=((0, 5),))
    assert decode(posed, [[11, 3]]).tolist() == [[[0, 5], [3, 11]]]


def test_an_uncovered_segment_counts_as_the_worst():
    posed = problem(12, 3.0, 2)
    assert fitnesses(posed, np.array([[[0, 4], [6, 11]]])).tolist() == [200.0]
    assert fitnesses(posed, np.array([[[0, 5], [6, 11]]]))[0] < 20


@pytest.mark.parametrize("sensors", [2, 3, 5])
def test_result_is_never_worse_than_the_heuristic(sensors):
    posed = problem(16, 3.0, sensors)
    found = evolve(posed, SMALL)
    assert found.percent <= posed.percent(heuristic(16, sensors))
    assert found.percent == posed.percent(found.spans)
    assert found.optimality == "none"


def test_best_ever_seen_is_returned_even_if_later_generations_lose_it(monkeypatch):
    posed = problem(12, 8.0, 4)
    settings = Evolution(individuals=40, generations=6, mutation=1.0, gene_mutation=1.0)
    lowest = []

    def watched(problem, spans):
        result = fitnesses(problem, spans)
        lowest.append(result.min())
        return result

    monkeypatch.setattr(evolution, "fitnesses", watched)
    found = evolve(posed, settings)
    assert min(lowest) < lowest[-1]
    assert found.percent <= min(lowest) * (1 + 1e-5)


def test_same_seed_gives_the_same_placement_while_others_draw_random_numbers():
    posed = problem(12, 8.0, 4)
    quiet = evolve(posed, SMALL)
    stop = threading.Event()

    def draw():
        while not stop.is_set():
            random.random()

    thread = threading.Thread(target=draw)
    thread.start()
    try:
        assert evolve(posed, SMALL) == quiet
    finally:
        stop.set()
        thread.join()


def test_process_wide_random_numbers_are_left_alone():
    random.seed(4)
    expected = random.Random(4).random()
    evolve(problem(12, 3.0, 2), SMALL)
    assert random.random() == expected


def test_seeds_differ():
    posed = problem(24, 8.0, 5)
    results = {evolve(posed, Evolution(individuals=60, generations=2, seed=s)) for s in range(4)}
    assert len(results) > 1


def test_constraints_hold():
    posed = problem(12, 3.0, 3, shortest=3, forbidden=(5,), stacked=2)
    found = evolve(posed, Evolution(individuals=300))
    assert posed.allows(found.spans)


def test_no_allowed_placement_is_an_error():
    with pytest.raises(InputError, match="met no placement"):
        evolve(problem(12, 3.0, 2, longest=4), SMALL)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"individuals": 0}, "individuals: 0 is too small; give at least 1"),
        ({"generations": -1}, "generations: -1 is too small; give at least 0"),
        ({"seed": -1}, "seed: -1 is too small; give at least 0"),
        ({"tournament": 0}, "tournaments of 0"),
        ({"crossover": 1.5}, "probability 1.5"),
        ({"mutation": -0.1}, "probability -0.1"),
    ],
)
def test_impossible_settings_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        evolve(problem(12, 3.0, 2), Evolution(**wrong))


def test_progress_ends_when_everything_is_done():
    reported = []
    evolve(problem(12, 3.0, 2), SMALL, lambda done, total: reported.append((done, total)))
    assert reported == [(k, 5) for k in range(1, 6)]


@pytest.mark.parametrize("degrees", [1.0, 8.0])
@pytest.mark.parametrize("segments", [12, 28])
@pytest.mark.parametrize("sensors", [4, 6])
def test_search_is_never_worse_than_evolution(segments, degrees, sensors):
    posed = problem(segments, degrees, sensors)
    found = search(posed, Search(enumerated=0))
    for seed in range(3):
        assert found.percent <= evolve(posed, Evolution(seed=seed)).percent


def test_objective_under_noise_is_optimised():
    posed = problem(12, 3.0, 4, noise=4e-4)
    found = evolve(posed, SMALL)
    assert found.percent <= posed.percent(heuristic(12, 4))
