"""The shapes that a joint takes, as segment angles with their source."""

from ccgen.shapes.cases import (
    ShapeLibrary,
    amplitudes,
    beyond_fold,
    fit_library,
    score_library,
    shape_library,
    single_shape,
)
from ccgen.shapes.library import Shapes, joined, unstretched

__all__ = [
    "ShapeLibrary",
    "Shapes",
    "amplitudes",
    "beyond_fold",
    "fit_library",
    "joined",
    "score_library",
    "shape_library",
    "single_shape",
    "unstretched",
]
