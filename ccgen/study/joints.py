"""One joint of the study: every placement and method of Table 2, and a few more."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ccgen.errors import ArgumentError
from ccgen.estimation import direct, equal, score_percent_rom, wam, wam_paper_call
from ccgen.joint.layouts import AnySpans, end_to_end, heuristic, single
from ccgen.placement import Evolution, Placement, Problem, Search, evolve, search
from ccgen.shapes import ShapeLibrary, beyond_fold, shape_library
from ccgen.study.paper import (
    DEM,
    E_WAM,
    EE,
    HO,
    OO,
    RANGES_OF_MOTION_DEG,
    SEGMENTS,
    SENSORS,
    SS,
    TABLE_2,
    WAM,
    Cell,
)

SEARCH = "search"
"""Placements by `ccgen.placement.search`, which the paper does not have."""

PAPER_CALL = "WAM, paper's call"
"""WAM by the paper's own optimiser call, which stops short of the minimum."""

EXTRA_CELLS: tuple[Cell, ...] = tuple(
    (placement, method, sensors)
    for placement, method in ((HO, PAPER_CALL), (OO, PAPER_CALL), (EE, WAM), (SEARCH, WAM))
    for sensors in SENSORS
)
"""What the paper does not have: its own optimiser call told apart, WAM without overlap, and our
search."""

_FIT_SAMPLES, _SCORE_SAMPLES = 30, 10


@dataclass(frozen=True, order=True)
class StudyJoint:
    """One of the 80 joints of Table 1."""

    segments: int
    range_of_motion_deg: int

    @property
    def name(self) -> str:
        """Name of its files."""
        return f"m{self.segments}-rom{self.range_of_motion_deg}"


@dataclass(frozen=True)
class Settings:
    """What the results depend on besides the joint."""

    evolution: Evolution = field(default_factory=Evolution)
    search: Search = field(default_factory=lambda: Search(enumerated=70_000, starts=4))


def all_joints() -> tuple[StudyJoint, ...]:
    """The 80 joints of Table 1."""
    return tuple(StudyJoint(m, rom) for m in SEGMENTS for rom in RANGES_OF_MOTION_DEG)


def chosen_joints(joints: str) -> tuple[StudyJoint, ...]:
    """Joints named by a list such as "12:3,48:8", or "12" for all ranges of motion.

    Raises:
        ArgumentError: not such a list, or a joint that is not in Table 1.
    """
    known = all_joints()
    chosen: set[StudyJoint] = set()
    for item in joints.split(","):
        segments, _, degrees = item.strip().partition(":")
        matches = {
            joint
            for joint in known
            if str(joint.segments) == segments and degrees in ("", str(joint.range_of_motion_deg))
        }
        if not matches:
            raise ArgumentError(
                f"{item.strip()!r} is no joint of Table 1; give SEGMENTS:DEGREES with"
                f" segments {SEGMENTS[0]}, {SEGMENTS[1]} to {SEGMENTS[-1]} and degrees"
                f" {RANGES_OF_MOTION_DEG[0]} to {RANGES_OF_MOTION_DEG[-1]}, such as 12:3,48:8",
                "joints",
            )
        chosen |= matches
    return tuple(sorted(chosen))


def study_joint(joint: StudyJoint, settings: Settings) -> dict[str, Any]:
    """Score every placement and method on one joint.

    Returns:
        What goes into the joint's JSON file: the joint, and `scores`, one object for each
        placement, method and number of sensors with its `spans` and its score in `percent_rom`.
    """
    rom = float(np.radians(joint.range_of_motion_deg))
    fit = shape_library(joint.segments, rom, _FIT_SAMPLES)
    score = shape_library(joint.segments, rom, _SCORE_SAMPLES)
    scores = [_score(SS, DEM, single(joint.segments), fit, score)]
    for sensors in SENSORS:
        scores += _scores(joint.segments, sensors, fit, score, settings)
    return {
        "segments": joint.segments,
        "range_of_motion_deg": joint.range_of_motion_deg,
        "beyond_fold": beyond_fold(joint.segments, rom),
        "scores": scores,
    }


def is_result(results: Mapping[str, Any], joint: StudyJoint) -> bool:
    """Whether results are what `study_joint` gives for a joint: its own, every cell once, finite.

    Args:
        results: what a JSON file holds.
        joint: which joint it should be.
    """
    try:
        scores = {
            (score["placement"], score["method"], score["sensors"]): score["percent_rom"]
            for score in results["scores"]
        }
        return (
            results["segments"] == joint.segments
            and results["range_of_motion_deg"] == joint.range_of_motion_deg
            and isinstance(results["beyond_fold"], bool)
            and len(results["scores"]) == len(scores)
            and scores.keys() == {*TABLE_2, *EXTRA_CELLS}
            and all(
                type(percent) is float and 0 <= percent < math.inf for percent in scores.values()
            )
        )
    except (KeyError, TypeError):  # not the structure
        return False


def _scores(
    segments: int, sensors: int, fit: ShapeLibrary, score: ShapeLibrary, settings: Settings
) -> list[dict[str, Any]]:
    apart, overlapping = end_to_end(segments, sensors), heuristic(segments, sensors)
    problem = Problem(fit, score, sensors)
    evolved = evolve(problem, settings.evolution)
    return [
        _score(EE, DEM, apart, fit, score),
        _score(HO, E_WAM, overlapping, fit, score),
        _score(HO, WAM, overlapping, fit, score),
        _optimised(OO, evolved),
        _score(EE, WAM, apart, fit, score),
        _score(HO, PAPER_CALL, overlapping, fit, score),
        _score(OO, PAPER_CALL, evolved.spans, fit, score),
        _optimised(SEARCH, search(problem, settings.search, [evolved.spans])),
    ]


def _score(
    placement: str, method: str, spans: AnySpans, fit: ShapeLibrary, score: ShapeLibrary
) -> dict[str, Any]:
    if method == DEM:
        weights = direct(fit.angles.shape[1], spans)
    elif method == E_WAM:
        weights = equal(fit.angles.shape[1], spans)
    elif method == PAPER_CALL:
        weights = wam_paper_call(fit, spans)
    else:
        weights = wam(fit, spans)
    return _entry(placement, method, spans, score_percent_rom(weights, score))


def _optimised(name: str, placement: Placement) -> dict[str, Any]:
    return {
        **_entry(name, WAM, placement.spans, placement.percent),
        "evaluations": placement.evaluations,
        "optimality": placement.optimality,
    }


def _entry(placement: str, method: str, spans: AnySpans, percent: float) -> dict[str, Any]:
    return {
        "placement": placement,
        "method": method,
        "sensors": len(spans),
        "spans": [list(span) for span in spans],
        "percent_rom": percent,
    }
