"""Weight matrices per output axis, by several methods, and their scores."""

from ccgen.estimation.errors import ErrorRow
from ccgen.estimation.fit import (
    FIT_METHODS,
    fit_coupled,
    fit_joint,
    fit_weights,
    in_the_papers_way,
)
from ccgen.estimation.noise_aware import noise_aware, posterior_covariance
from ccgen.estimation.score import (
    axis_errors,
    elongation_adds,
    elongation_bias,
    elongation_warning,
    noise_gain,
    score_percent_rom,
    score_with_noise_percent_rom,
)
from ccgen.estimation.simple import direct, equal
from ccgen.estimation.wam import wam, wam_matrix, wam_objective, wam_paper_call
from ccgen.estimation.weights import Weights

__all__ = [
    "FIT_METHODS",
    "ErrorRow",
    "Weights",
    "axis_errors",
    "direct",
    "elongation_adds",
    "elongation_bias",
    "elongation_warning",
    "equal",
    "fit_coupled",
    "fit_joint",
    "fit_weights",
    "in_the_papers_way",
    "noise_aware",
    "noise_gain",
    "posterior_covariance",
    "score_percent_rom",
    "score_with_noise_percent_rom",
    "wam",
    "wam_matrix",
    "wam_objective",
    "wam_paper_call",
]
