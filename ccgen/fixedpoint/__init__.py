"""Fixed-point formats, proofs, and the integer reference model."""

from ccgen.fixedpoint.fitted import Fit, fit
from ccgen.fixedpoint.formats import quantise
from ccgen.fixedpoint.model import AxisModel, FixedPointModel
from ccgen.fixedpoint.storage import load_model, model_json

__all__ = [
    "AxisModel",
    "Fit",
    "FixedPointModel",
    "fit",
    "load_model",
    "model_json",
    "quantise",
]
