"""What is told of a placement, whatever it was judged by: errors as `ccgen fit` would tell them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ccgen.estimation import score_percent_rom, score_with_noise_percent_rom
from ccgen.estimation.errors import ErrorRow, errors_of, missed
from ccgen.estimation.sources import CASES
from ccgen.joint.layouts import AnySpans
from ccgen.placement.asked import Placeable
from ccgen.placement.faults import seen_faults, visible_faults
from ccgen.placement.listed import ListedProblem
from ccgen.placement.moved import with_spans
from ccgen.placement.problem import Problem, placed_noise
from ccgen.placement.sets import SetsProblem
from ccgen.placement.stated import StatedProblem
from ccgen.sensing.readings import length_changes, normaliser
from ccgen.shapes import score_shapes, within_axes

if TYPE_CHECKING:
    from ccgen.estimation.weights import Floats
    from ccgen.joint import Joint
    from ccgen.placement.placed import Placed
    from ccgen.shapes import Shapes


@dataclass(frozen=True)
class Told:
    """Figures of one placement.

    Attributes:
        percent_rom: mean error of a segment's angle without noise, % of the range of motion.
        with_noise_percent_rom: the same with noise and tolerances; None where no noise is stated.
        errors: on each source, without and with noise.
        faults_percent: the smallest fault of each sensor that the others contradict, % of its
            largest reading, NaN where none is seen; None where no noise is stated.
    """

    percent_rom: float
    with_noise_percent_rom: float | None
    errors: Sequence[ErrorRow]
    faults_percent: "Floats | None"


def told(joint: "Joint", placed: "Placed", axis: str, spans: AnySpans, wide: "Shapes") -> Told:
    """Tell of one placement.

    Args:
        joint: the joint.
        placed: what was asked.
        axis: one of those that it is for.
        spans: of the sensors.
        wide: shapes of the joint at work, as of `wide_shapes`.
    """
    question = placed.problem
    rows = error_rows(joint, question, placed.axes, spans)
    if isinstance(question, ListedProblem):
        known = question.mean_percent(rows, noise=True) if question.noisy else None
        clean = question.mean_percent(rows, noise=False)
        return Told(clean, known, rows, _listed_faults(question, spans, wide))
    clean, known, noise = scores(joint, question, axis, spans, rows)
    if noise is None:
        return Told(clean, known, rows, None)
    # Axes that share a table are told alike, by the shapes of both.
    angles = np.concatenate([wide.state[:, joint.rows(one)] for one in placed.axes])
    return Told(clean, known, rows, visible_faults(angles, spans, noise, joint.false_alarms))


def _listed_faults(question: ListedProblem, spans: AnySpans, wide: "Shapes") -> "Floats | None":
    """Faults of sensors that are held against those that they are read with."""
    noise = question.reading_noise(spans)
    if noise is None:
        return None
    joint = question.at(spans)
    read = length_changes(joint, within_axes(joint, wide).state) / normaliser(joint)
    percent = np.empty(len(noise))
    for group in question.groups:
        own = group.slots
        percent[own] = seen_faults(read[:, own], noise[own], joint.false_alarms)
    return percent


def error_rows(
    joint: "Joint", question: Placeable, axes: Sequence[str], spans: AnySpans
) -> list[ErrorRow]:
    """Errors of one placement on each source, without and with noise.

    Args:
        joint: the joint.
        question: what was asked.
        axes: those whose sensors have these spans.
        spans: of the sensors of an axis.
    """
    if isinstance(question, StatedProblem):
        return question.errors(spans)
    moved, weights = with_spans(joint, dict.fromkeys(axes, spans)), question.weights(spans)
    served = dict.fromkeys(axes, weights)
    shapes = score_shapes(joint)
    return [
        errors_of(CASES, missed(moved, served, shapes, noise), noise, False)
        for noise in (False, True)
    ]


def scores(
    joint: "Joint",
    question: Problem | SetsProblem,
    axis: str,
    spans: AnySpans,
    rows: Sequence[ErrorRow],
) -> "tuple[float, float | None, Floats | None]":
    """Mean errors in % of the range of motion without and with noise, and the readings' noise.

    Args:
        joint: the joint.
        question: what was asked.
        axis: one of those that have these spans.
        spans: of the sensors of an axis.
        rows: of `error_rows`.

    Returns:
        None for what is not known where no noise is stated. The noise has shape (n,), radians.
    """
    if isinstance(question, SetsProblem):
        noise = question.reading_noise(axis, spans)
        known = question.mean_percent(rows, noise=True) if question.noisy else None
        return question.mean_percent(rows, noise=False), known, noise
    weights, noise = question.weights(spans), placed_noise(joint, axis, spans, question.fit)
    known = None if noise is None else score_with_noise_percent_rom(weights, question.score, noise)
    return score_percent_rom(weights, question.score), known, noise
