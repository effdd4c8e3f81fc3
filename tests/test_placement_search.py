from contextlib import suppress
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccgen.errors import InputError
from ccgen.joint.file import read_joint
from ccgen.joint.layouts import heuristic
from ccgen.placement import (
    METHODS,
    Constraints,
    Evolution,
    Problem,
    Search,
    joint_problem,
    place_by,
    search,
)
from ccgen.placement.compare import NEGLIGIBLE, total_length
from ccgen.placement.descent import Descent
from ccgen.placement.exhaustive import count_allowed, covering
from ccgen.placement.problem import as_spans
from ccgen.placement.search import descend, enumerate_all
from ccgen.shapes import shape_library

EXAMPLES = Path(__file__).parents[1] / "examples"


@cache
def libraries(segments, degrees):
    rom = np.radians(degrees)
    return shape_library(segments, rom, 30), shape_library(segments, rom, 10)


def problem(segments, degrees, sensors, noise=0.0, **limits):
    return Problem(*libraries(segments, degrees), sensors, Constraints(**limits), noise)


def every_allowed(posed):
    """All placements that keep to the constraints, from the definition."""
    segments, fixed = posed.segments, posed.constraints.fixed
    spans = [(a, b) for a in range(segments) for b in range(a, segments)]
    free = combinations_with_replacement(spans, posed.sensors - len(fixed))
    return {as_spans((*fixed, *one)) for one in free if posed.allows((*fixed, *one))}


def test_counting_ends_above_a_limit():
    posed = problem(12, 3.0, 4)
    assert count_allowed(posed) == count_allowed(posed, 290_863) == 290_863
    assert count_allowed(posed, 290_862) is None
    assert count_allowed(posed, 8_000) is None


LIMITS = [
    {},
    {"shortest": 2, "longest": 4},
    {"forbidden": (2, 3)},
    {"fixed": ((1, 3),)},
    {"fixed": ((2, 3), (0, 1)), "shortest": 2},
    {"stacked": 1},
    {"stacked": 2, "fixed": ((0, 5),), "forbidden": (4,)},
]


@pytest.mark.parametrize("limits", LIMITS, ids=str)
@pytest.mark.parametrize("sensors", [2, 3])
def test_enumeration_meets_every_allowed_placement_once(sensors, limits):
    posed = problem(6, 3.0, sensors, **limits)
    met = [as_spans(one) for chunk in covering(posed) for one in chunk]
    assert len(met) == len(set(met))
    assert set(met) == every_allowed(posed)
    assert count_allowed(posed) == len(met)


def test_a_limit_on_stacked_sensors_leaves_few_placements_to_enumerate():
    # Without it there are more than a hundred thousand.
    found = search(problem(48, 2.0, 6, shortest=8, stacked=1))
    assert (found.optimality, found.evaluations) == ("proven", 1)
    assert count_allowed(problem(48, 2.0, 6, shortest=7, stacked=1), 1000) == 462
    with pytest.raises(InputError, match="no placement of 6 sensors"):
        search(problem(48, 2.0, 6, shortest=9, stacked=1))
    with pytest.raises(InputError, match="no placement of 6 sensors"):
        search(problem(48, 2.0, 6, shortest=17, stacked=2))


def test_counting_under_a_limit_on_stacked_sensors_ends_too():
    assert count_allowed(problem(48, 2.0, 6, stacked=2), 100) is None
    assert count_allowed(problem(48, 2.0, 6, stacked=1), 1e5) is None


@pytest.mark.parametrize("limits", LIMITS[:5], ids=str)
@pytest.mark.parametrize("noise", [0.0, 4e-4])
def test_search_returns_the_proven_best_of_all_placements(limits, noise):
    posed = problem(6, 8.0, 2, noise, **limits)
    if not every_allowed(posed):
        with pytest.raises(InputError, match="constraints"):
            search(posed)
        return
    found = search(posed)
    assert found.optimality == "proven"
    assert found.percent == min(map(posed.percent, every_allowed(posed)))
    assert posed.allows(found.spans)


@pytest.mark.parametrize("degrees", [1.0, 3.0, 8.0])
@pytest.mark.parametrize("sensors", [2, 3])
def test_search_on_twelve_segments_is_the_exhaustive_optimum(degrees, sensors):
    posed = problem(12, degrees, sensors)
    found = search(posed)
    everything = np.concatenate(list(covering(posed)))
    assert len(everything) == {2: 144, 3: 8438}[sensors]
    near = everything[np.argsort(posed.model.values(everything))[:200]]
    assert found.percent == pytest.approx(posed.percents(near).min(), rel=1e-9)
    assert found.optimality == "proven"
    assert found.gap == 0.0


@pytest.mark.parametrize(
    ("segments", "degrees", "sensors", "noise"),
    [(12, 3.0, 3, 0.0), (12, 8.0, 3, 4e-4), (20, 8.0, 3, 0.0), (12, 8.0, 4, 0.0)],
)
def test_descents_find_what_enumeration_proves(segments, degrees, sensors, noise):
    posed = problem(segments, degrees, sensors, noise)
    lowest = min(posed.model.values(chunk).min() for chunk in covering(posed))
    found = search(posed, Search(enumerated=0))
    assert found.optimality == "bound"
    assert 0 < found.gap < 1
    assert found.percent == pytest.approx(lowest, rel=1e-3)


@pytest.mark.parametrize(
    "limits",
    [
        {},
        {"shortest": 3, "stacked": 2},
        {"fixed": ((9, 12),)},
        # Neither heuristic nor end-to-end spans are allowed here.
        {"shortest": 12},
        {"longest": 4},
        {"longest": 5, "stacked": 1, "forbidden": (3, 4)},
    ],
    ids=str,
)
def test_descents_keep_to_the_constraints(limits):
    posed = problem(16, 4.0, 4, **limits)
    found = search(posed, Search(enumerated=0, starts=4))
    assert posed.allows(found.spans)
    assert found.percent == posed.percent(found.spans)


@st.composite
def tight_problems(draw):
    """Small problems with limits so tight that many have no solution."""
    segments, sensors = draw(st.integers(3, 6)), draw(st.integers(1, 3))
    segment = st.integers(0, segments - 1)
    spans = st.tuples(segment, segment).map(lambda pair: tuple(sorted(pair)))
    shortest = draw(st.integers(1, segments))
    limits = Constraints(
        shortest=shortest,
        longest=draw(st.none() | st.integers(shortest, segments)),
        forbidden=tuple(sorted(draw(st.sets(segment, max_size=segments // 2)))),
        fixed=tuple(draw(st.lists(spans, max_size=sensors - 1))),
        stacked=draw(st.none() | st.integers(1, sensors)),
    )
    degrees, noise = draw(st.sampled_from([2.0, 8.0])), draw(st.sampled_from([0.0, 4e-4]))
    return Problem(*libraries(segments, degrees), sensors, limits, noise)


def answer(method, *arguments):
    """What a method finds, or None where it says that it finds nothing."""
    with suppress(InputError):
        return method(*arguments)
    return None


@settings(max_examples=150, derandomize=True, deadline=None)
@given(posed=tight_problems())
def test_every_method_keeps_to_tight_constraints_or_says_that_it_cannot(posed):
    allowed = every_allowed(posed)
    best = min((max(posed.percent(one), NEGLIGIBLE) for one in allowed), default=None)
    quick = Evolution(individuals=20, generations=1), Search(enumerated=0, starts=2)
    found = [answer(place_by, posed, method, *quick) for method in METHODS]
    found += [answer(descend, posed, quick[1]), answer(enumerate_all, posed)]
    assert (found[-2] is None) == (found[-1] is None) == (best is None)
    for placement in filter(None, found):
        assert placement.spans in allowed
        assert max(placement.percent, NEGLIGIBLE) >= best * (1 - 1e-12)
    if best is not None:
        assert max(found[-1].percent, NEGLIGIBLE) == pytest.approx(best, rel=1e-12)


@pytest.mark.parametrize(
    "limits",
    [
        {"shortest": 10},
        {"longest": 5},
        {"longest": 6, "forbidden": (3, 4)},
        {"shortest": 4, "stacked": 1, "fixed": ((4, 8),)},
    ],
    ids=str,
)
@pytest.mark.parametrize("noise", [0.0, 4e-4])
def test_descents_find_the_proven_best_under_tight_limits(limits, noise):
    posed = problem(14, 8.0, 3, noise, **limits)
    assert descend(posed, Search()).spans == enumerate_all(posed).spans


def test_descents_start_from_an_allowed_placement_where_they_meet_none_themselves():
    # The one placement there is: every span begins where the one before it ends.
    posed = problem(30, 3.0, 5, shortest=6, stacked=1)
    found = descend(posed, Search(starts=1))
    assert found.spans == tuple((k, k + 5) for k in range(0, 30, 6))


@pytest.mark.parametrize(("segments", "sensors"), [(2, 2), (3, 3), (3, 4), (5, 5), (8, 8)])
@pytest.mark.parametrize("enumerated", [0, 20_000])
def test_of_placements_without_error_the_one_with_the_shortest_spans_is_found(
    segments, sensors, enumerated
):
    found = search(problem(segments, 5.0, sensors), Search(enumerated=enumerated, starts=4))
    assert found.percent < NEGLIGIBLE
    assert total_length(found.spans) == sensors
    assert set(found.spans) == {(k, k) for k in range(segments)}


def test_descents_are_reproducible():
    posed = problem(16, 4.0, 4)
    settings = Search(enumerated=0, starts=6, seed=5)
    assert search(posed, settings) == search(posed, settings)


def test_search_is_never_worse_than_a_placement_it_is_given():
    posed = problem(16, 4.0, 4, fixed=((2, 9),))
    known = search(posed, Search(enumerated=0)).spans
    found = search(posed, Search(enumerated=0, starts=1), [known])
    assert found.percent <= posed.percent(known)
    assert found.evaluations < 10_000


def test_a_descent_ends_where_no_single_move_helps():
    posed = problem(16, 4.0, 4)
    spans, value = Descent(posed).run(np.array(heuristic(16, 4)))
    for slot in range(4):
        moved = np.repeat(spans[None], len(posed.catalogue), axis=0)
        moved[:, slot] = posed.catalogue
        moved = moved[posed.violations(moved) == 0]
        assert posed.model.values(moved).min() >= value * (1 - 1e-6)


def test_search_is_never_worse_than_the_heuristic():
    for sensors in (2, 3, 4, 5, 6):
        posed = problem(16, 2.0, sensors)
        found = search(posed, Search(enumerated=1000, starts=4))
        assert found.percent <= posed.percent(heuristic(16, sensors))


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"shortest": 0}, "shortest, longest: spans of 0 to 12"),
        ({"longest": 13}, "spans of 1 to 13"),
        ({"forbidden": (12,)}, "forbidden: segment 12"),
        ({"fixed": ((3, 12),)}, r"fixed: span \[3, 12\]"),
        ({"fixed": ((0, 1), (2, 3), (4, 5))}, "fixed: 3 spans"),
        ({"stacked": 0}, "stacked: at most 0 sensors"),
    ],
)
def test_senseless_constraints_are_refused(limits, message):
    with pytest.raises(InputError, match=message):
        problem(12, 3.0, 2, **limits)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"enumerated": -1}, "enumerated: -1 is too small; give at least 0"),
        ({"starts": 0}, "starts: 0 is too small; give at least 1"),
        ({"seed": -1}, "seed: -1 is too small; give at least 0"),
    ],
)
def test_impossible_settings_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        search(problem(12, 3.0, 2), Search(**wrong))


@pytest.mark.parametrize("enumerated", [0, 10_000])
def test_progress_ends_when_everything_is_done(enumerated):
    reported = []
    quick = Search(enumerated, starts=4)
    search(problem(12, 3.0, 3), quick, report=lambda *progress: reported.append(progress))
    total = reported[0][1]
    assert total == (8438 if enumerated else 4)
    assert reported == sorted(reported)
    assert reported[-1] == (total, total)


def test_constraints_that_nothing_meets_are_an_error():
    with pytest.raises(InputError, match="no placement of 2 sensors"):
        search(problem(12, 3.0, 2, longest=5))
    with pytest.raises(InputError, match="no span"):
        search(problem(12, 3.0, 2, forbidden=tuple(range(12))))
    with pytest.raises(InputError, match="no placement of 4 sensors"):
        search(problem(16, 3.0, 4, shortest=5, stacked=1), Search(enumerated=0, starts=3))


def test_layouts_are_placements_too():
    posed = problem(12, 3.0, 3)
    found = place_by(posed, "heuristic")
    assert found.spans == heuristic(12, 3)
    assert found.percent == posed.percent(found.spans)
    with pytest.raises(InputError, match="single has 1 sensor"):
        place_by(posed, "single")
    with pytest.raises(InputError, match="does not keep"):
        place_by(problem(12, 3.0, 3, stacked=1), "heuristic")
    with pytest.raises(InputError, match="unknown method"):
        place_by(posed, "best")


def test_a_joint_file_states_the_noise_of_the_objective():
    joint = read_joint(EXAMPLES / "shoulder.toml")
    quiet, noisy = joint_problem(joint, "u", 3), joint_problem(joint, "u", 3, with_noise=True)
    assert quiet.noise == 0.0
    assert noisy.noise == pytest.approx(joint.u.transducer.noise / joint.u.radius)
    assert noisy.percent(heuristic(12, 3)) > quiet.percent(heuristic(12, 3))


@pytest.mark.parametrize("degrees", [1e-2, 1e-3, 1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize(("segments", "sensors"), [(6, 2), (5, 3)])
def test_at_a_tiny_range_of_motion_nothing_better_than_the_proven_is_left(
    segments, sensors, degrees
):
    posed = problem(segments, degrees, sensors)
    found = search(posed)
    best = min(posed.percent(spans) for spans in every_allowed(posed))
    if found.optimality == "proven":
        assert found.percent == pytest.approx(best, rel=1e-11)
    else:
        assert (found.optimality, found.gap) == ("none", None)
        assert best <= found.percent <= NEGLIGIBLE
