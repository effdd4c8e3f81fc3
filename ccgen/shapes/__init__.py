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

__all__ = [
    "ShapeLibrary",
    "amplitudes",
    "beyond_fold",
    "fit_library",
    "score_library",
    "shape_library",
    "single_shape",
]
