"""The shapes that a joint takes, as segment angles with their source."""

from ccgen.shapes.cases import (
    ShapeLibrary,
    amplitudes,
    axis_library,
    beyond_fold,
    fit_library,
    score_library,
    shape_library,
    single_shape,
)
from ccgen.shapes.combined import combined_shapes, fit_shapes, score_shapes
from ccgen.shapes.library import Shapes, bent_alike, joined, unstretched, within_axes

__all__ = [
    "ShapeLibrary",
    "Shapes",
    "amplitudes",
    "axis_library",
    "bent_alike",
    "beyond_fold",
    "combined_shapes",
    "fit_library",
    "fit_shapes",
    "joined",
    "score_library",
    "score_shapes",
    "shape_library",
    "single_shape",
    "unstretched",
    "within_axes",
]
