"""What is told of a placement, whatever it was judged by: errors as `ccgen fit` would tell them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ccgen.estimation import score_percent_rom, score_with_noise_percent_rom
from ccgen.estimation.errors import ErrorRow, errors_of, missed
from ccgen.estimation.sources import CASES
from ccgen.joint.layouts import Spans
from ccgen.placement.moved import with_spans
from ccgen.placement.problem import Problem, placed_noise
from ccgen.placement.stated import StatedProblem
from ccgen.shapes import score_shapes

if TYPE_CHECKING:
    from ccgen.estimation.weights import Floats
    from ccgen.joint import Joint


def error_rows(
    joint: "Joint", question: Problem | StatedProblem, axes: Sequence[str], spans: Spans
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
    question: Problem | StatedProblem,
    axis: str,
    spans: Spans,
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
    if isinstance(question, StatedProblem):
        noise = question.reading_noise(axis, spans)
        known = question.mean_percent(rows, noise=True) if question.noise else None
        return question.mean_percent(rows, noise=False), known, noise
    weights, noise = question.weights(spans), placed_noise(joint, axis, spans, question.fit)
    known = None if noise is None else score_with_noise_percent_rom(weights, question.score, noise)
    return score_percent_rom(weights, question.score), known, noise
