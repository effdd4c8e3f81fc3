"""The shapes that a joint takes, as segment angles with their source."""

from ccgen.shapes.cases import (
    ShapeLibrary,
    amplitudes,
    axis_library,
    beyond_fold,
    fit_library,
    fit_shapes,
    score_library,
    shape_library,
    single_shape,
)
from ccgen.shapes.library import Shapes, bent_alike, joined, unstretched

__all__ = [
    "ShapeLibrary",
    "Shapes",
    "amplitudes",
    "axis_library",
    "bent_alike",
    "beyond_fold",
    "fit_library",
    "fit_shapes",
    "joined",
    "score_library",
    "shape_library",
    "single_shape",
    "unstretched",
]
