"""A joint in motion: shapes that change smoothly from one snapshot to the next."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint
from ccgen.shapes import ShapeLibrary, Shapes, unstretched, within_axes
from ccgen.shapes.loads.library import loads_library

Floats = NDArray[np.float64]

SOURCES = ("cases", "random", "sweep")
"""Names of the motions that `motion` knows."""
LOADS = "loads"
"""Name of the motion through shapes under the loads that a joint states."""

_MODES = 4
"""Cosine modes of a random shape, each half as strong as the one before."""
_STOPS = 8
"""Shapes under drawn loads that a round of the motion passes."""


def joint_motion(
    joint: Joint, source: str, library: ShapeLibrary | None, count: int, period: int, seed: int = 0
) -> Shapes:
    """States of `count` snapshots of a joint: an axis that it leaves out stays, sections stretch.

    Each section elongates and shortens over its whole range at a rate of its own, or as drawn.

    Args:
        joint: its axes, geometry and loads.
        source: "loads" or as of `motion`.
        library: of the joint; None for "loads".
        count, period, seed: as of `motion`.

    Raises:
        ValueError: unknown source, or a joint without loads.
        ReachError: no draw of the joint's loads gives a shape.
    """
    drawn = loads_library(joint) if source == LOADS else None
    if drawn is not None:
        return within_axes(joint, loads_motion(drawn.shapes, np.arange(count) / period, seed))
    if library is None:
        raise ValueError(f"{source!r} takes the shapes of the joint's load cases, or its loads")
    geometry = joint.geometry
    bends = within_axes(joint, motion(source, library, count, period, seed))
    low, high = geometry.elongation or (0.0, 0.0)
    rate = 1.0 + np.arange(len(geometry.sections)) / len(geometry.sections)
    share = 0.5 - 0.5 * np.cos(2 * np.pi * np.outer(np.arange(count) / period, rate))
    return Shapes(bends.u, bends.v, low + (high - low) * share, bends.source)


def motion(source: str, library: ShapeLibrary, count: int, period: int, seed: int = 0) -> Shapes:
    """Angles of `count` snapshots of one of `SOURCES`.

    Args:
        source: "cases" walks through the load cases of the library, "random" through smooth random
            shapes, "sweep" leads a constant curvature around in a spiral.
        library: shapes of the joint.
        count: snapshots.
        period: snapshots that one round of the motion takes.
        seed: of the random shapes.

    Raises:
        ValueError: unknown source.
    """
    motions: dict[str, Callable[[Floats], Shapes]] = {
        "cases": lambda turns: case_motion(library, turns),
        "random": lambda turns: random_motion(library, turns, seed),
        "sweep": lambda turns: sweep_motion(library, turns),
    }
    if source not in motions:
        raise ValueError(f"unknown source {source!r}; known: {', '.join(SOURCES)}")
    return motions[source](np.arange(count) / period)


def case_motion(library: ShapeLibrary, turns: Floats) -> Shapes:
    """Through every load case, there and back by turns, one round of all cases a turn.

    Between the library's shapes the angles are interpolated; the v axis is half a turn ahead.

    Args:
        library: shapes of the joint.
        turns: shape (k,), position along the motion.
    """
    tour = _tour(library)
    return unstretched(_along(tour, turns), _along(tour, turns + 0.5), source="cases")


def random_motion(library: ShapeLibrary, turns: Floats, seed: int) -> Shapes:
    """Smooth shapes within the range of motion that change smoothly from snapshot to snapshot.

    Every axis is a sum of cosine modes along the joint whose amplitudes oscillate at random rates.

    Args:
        library: shapes of the joint.
        turns: shape (k,), position along the motion.
        seed: the same seed gives the same motion.
    """
    random = np.random.default_rng(seed)
    segments = library.angles.shape[1]
    place = (np.arange(segments) + 0.5) / segments
    modes = np.cos(np.pi * np.outer(np.arange(_MODES), place))
    u, v = (np.empty((turns.size, segments)) for _ in range(2))
    for angles in (u, v):
        strength = random.uniform(0.5, 1.0, _MODES) * 0.5 ** np.arange(_MODES)
        weight = strength / strength.sum() * library.range_of_motion
        rate = random.uniform(1.0, 4.0, _MODES)
        phase = random.uniform(0.0, 1.0, _MODES)
        angles[:] = np.sin(2 * np.pi * (np.outer(turns, rate) + phase)) * weight @ modes
    return unstretched(u, v, source="random")


def sweep_motion(library: ShapeLibrary, turns: Floats) -> Shapes:
    """Constant curvature in a spiral: out to full range and back, four circles a turn.

    Args:
        library: shapes of the joint.
        turns: shape (k,), position along the motion.
    """
    segments = library.angles.shape[1]
    amplitude = library.range_of_motion * (0.5 - 0.5 * np.cos(2 * np.pi * turns))
    u = amplitude * np.cos(8 * np.pi * turns)
    v = amplitude * np.sin(8 * np.pi * turns)
    along = np.ones(segments)
    return unstretched(np.outer(u, along), np.outer(v, along), source="sweep")


def loads_motion(drawn: Shapes, turns: Floats, seed: int) -> Shapes:
    """From one shape under drawn loads to the next, at rest at each, eight of them a turn.

    What lies between two shapes is a mean of both, so sensors contradict each other no more there
    than at the shapes, which their checks were made for.

    Args:
        drawn: shapes under the joint's loads; all of them come before one comes again.
        turns: shape (k,), position along the motion.
        seed: of their order.
    """
    order = np.random.default_rng(seed).permutation(len(drawn))
    place = turns * _STOPS
    stop = np.floor(place).astype(np.int64)
    part = place - stop
    share = (part * part * (3.0 - 2.0 * part))[:, None]
    one, other = order[stop % len(order)], order[(stop + 1) % len(order)]
    u, v, h = (
        (1.0 - share) * values[one] + share * values[other]
        for values in (drawn.u, drawn.v, drawn.h)
    )
    return Shapes(u, v, h, (LOADS,) * turns.size)


def _tour(library: ShapeLibrary) -> Floats:
    """The library's shapes with every other load case reversed: neighbours have like amplitudes."""
    cases = list(dict.fromkeys(library.cases))
    parts = [library.angles[[case == c for c in library.cases]] for case in cases]
    return np.concatenate([part[:: -1 if i % 2 else 1] for i, part in enumerate(parts)])


def _along(shapes: Floats, turns: Floats) -> Floats:
    """Shapes at positions along the list, interpolated; a turn passes through all and returns."""
    place = np.mod(turns, 1.0) * len(shapes)
    before = place.astype(np.int64) % len(shapes)
    part = (place - np.floor(place))[:, None]
    after = (before + 1) % len(shapes)
    return np.asarray((1 - part) * shapes[before] + part * shapes[after])
