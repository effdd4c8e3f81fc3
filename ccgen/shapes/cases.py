"""The shapes that a joint takes under its load cases, as segment angles (section 2.4 of the paper).

A shape is named by its load case and by its amplitude, the angle of the first segment; shapes of
negative amplitude are mirror images. The estimators are fitted to, and scored on, a library of
shapes with amplitudes spread evenly over the range of motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ccgen.errors import InputError, ReachError
from ccgen.joint import CASES, Joint
from ccgen.shapes import beam
from ccgen.shapes.library import Shapes
from ccgen.shapes.refinement import segment_angles

FloatArray = NDArray[np.float64]


_STRAIGHT = 1e-100
"""Radians that are none: products of smaller ones leave a double's range."""


@dataclass(frozen=True, eq=False)
class ShapeLibrary:
    """Shapes of one bending axis, grouped by load case.

    Attributes:
        angles: shape (n_shapes, n_segments), radians.
        cases: load case of each shape.
        amplitudes: angle of the first segment of each shape, shape (n_shapes,), radians.
        range_of_motion: largest amplitude, radians.
    """

    angles: FloatArray
    cases: tuple[str, ...]
    amplitudes: FloatArray
    range_of_motion: float


def amplitudes(range_of_motion: float, samples: int) -> FloatArray:
    """Amplitudes -ROM + i 2 ROM / s for i = 1 to s (eq. 6), shape (samples,).

    Raises:
        ValueError: no sample.
    """
    if samples < 1:
        raise ValueError(f"{samples} samples give no shape")
    steps = 2 * np.arange(1, samples + 1, dtype=np.float64) - samples
    return range_of_motion * steps / samples


def shape_library(
    segments: int, range_of_motion: float, samples: int, cases: Sequence[str] = CASES
) -> ShapeLibrary:
    """Sample every load case over the range of motion.

    Args:
        segments: number of segments.
        range_of_motion: largest angle of the first segment, radians.
        samples: amplitudes per load case.
        cases: load cases, names of `ccgen.joint.CASES`.

    Raises:
        InputError: unknown load case.
        ReachError: a load case that does not bend the first segment so far.
    """
    return _shape_libraries(segments, range_of_motion, (samples,), tuple(cases))[0]


@lru_cache(maxsize=8)
def _shape_libraries(
    segments: int, range_of_motion: float, samples: tuple[int, ...], cases: tuple[str, ...]
) -> tuple[ShapeLibrary, ...]:
    """A library for each number of samples; what bends the joint is solved for all at once."""
    parts = [amplitudes(range_of_motion, count) for count in samples]
    every = np.concatenate(parts)
    bent = [_segment_angles(segments, case, every) for case in cases]
    ends = np.cumsum(samples)[:-1]
    split = zip(*(np.split(angles, ends) for angles in bent), strict=True)
    libraries = []
    for first_segment, angles in zip(parts, split, strict=True):
        library = ShapeLibrary(
            angles=np.concatenate(angles),
            cases=tuple(case for case in cases for _ in first_segment),
            amplitudes=np.tile(first_segment, len(cases)),
            range_of_motion=range_of_motion,
        )
        library.angles.setflags(write=False)
        library.amplitudes.setflags(write=False)
        libraries.append(library)
    return tuple(libraries)


def single_shape(segments: int, case: str, first_segment: float) -> FloatArray:
    """Segment angles under one load case, shape (segments,), radians.

    Args:
        segments: number of segments.
        case: load case, a name of `ccgen.joint.CASES`.
        first_segment: angle of the first segment, radians, of either sign.

    Raises:
        InputError: unknown load case.
        ReachError: an angle that the load case does not reach.
    """
    angles = _segment_angles(segments, case, [first_segment])
    return angles.reshape(segments)


def fit_library(joint: Joint) -> ShapeLibrary:
    """Build the library to which the joint's estimators are fitted.

    Raises:
        ReachError: names the joint file and its key.
    """
    return _joint_libraries(joint)[0]


def score_library(joint: Joint) -> ShapeLibrary:
    """Build the library on which the joint's estimators are scored (eq. 12).

    Raises:
        ReachError: names the joint file and its key.
    """
    return _joint_libraries(joint)[1]


def axis_library(shapes: Shapes, axis: str, range_of_motion: float) -> ShapeLibrary:
    """The rows of one bending axis.

    Args:
        shapes: the rows.
        axis: "u" or "v".
        range_of_motion: what errors are a share of, radians.
    """
    angles = shapes.u if axis == "u" else shapes.v
    return ShapeLibrary(angles, shapes.source, angles[:, 0], range_of_motion)


def beyond_fold(segments: int, range_of_motion: float) -> bool:
    """Tell whether the s-shape at full range lies beyond the fold of its base curvature.

    There the joint turns back past its base, and a base curvature alone no longer names a shape.

    Raises:
        ReachError: an angle that the s-shape does not reach.
    """
    fold = beam.fold(beam.S_SHAPE)
    if fold is None:
        return False
    # The load grows along the whole branch, so it orders the states.
    return bool(beam.bend(beam.S_SHAPE, segments, [range_of_motion]).load[0] > fold.load)


def _joint_libraries(joint: Joint) -> tuple[ShapeLibrary, ...]:
    """The libraries to fit to and to score with."""
    geometry, shapes = joint.geometry, joint.shapes
    samples = (shapes.fit_samples, shapes.score_samples)
    try:
        return _shape_libraries(
            geometry.segments, geometry.range_of_motion, samples, tuple(shapes.cases)
        )
    except ReachError as error:
        raise ReachError(f"{joint.source}: geometry.range_of_motion: {error}") from error


def _segment_angles(segments: int, case: str, first_segment: ArrayLike) -> FloatArray:
    """Segment angles (eq. 4), shape (n, segments), for first segments of shape (n,)."""
    first = np.asarray(first_segment, dtype=np.float64)
    first = np.where(np.abs(first) < _STRAIGHT, 0.0, first)
    if case == "constant-curvature":
        return np.repeat(first[:, None], segments, axis=1)
    if case not in beam.LOAD_CASES:
        raise InputError(f"unknown load case {case!r}; known: {', '.join(CASES)}")
    magnitudes, which = np.unique(np.abs(first), return_inverse=True)
    bent = beam.bend(beam.LOAD_CASES[case], segments, magnitudes)
    angles = segment_angles(bent.case, bent.states, segments, magnitudes)
    return angles[which] * np.sign(first)[:, None]
