"""The two methods that need no fit: direct (DEM) and equal weights (E-WAM)."""

from ccgen.errors import InputError
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.readings import reading_matrix


def direct(segments: int, spans: AnySpans) -> Weights:
    """Each segment takes the reading of the one sensor that covers it (section 2.5.2.1).

    The paper defines this for spans without overlap only. Overlapping spans are refused rather
    than settled by some order of the sensors.

    Raises:
        InputError: a segment is covered by no sensor or by more than one.
    """
    cover = _coverage(segments, spans)
    for i, row in enumerate(cover):
        if row.sum() > 1:
            names = " and ".join(str(j) for j in row.nonzero()[0])
            raise InputError(
                f"segment {i} is covered by sensors {names}, so it has no one reading to take; "
                'use the method "equal" for spans that overlap'
            )
    return without_intercept("direct", spans, cover)


def equal(segments: int, spans: AnySpans) -> Weights:
    """Each segment takes the mean reading of the sensors that cover it (section 2.5.2.2).

    Raises:
        InputError: a segment is covered by no sensor.
    """
    cover = _coverage(segments, spans)
    return without_intercept("equal", spans, cover / cover.sum(axis=1, keepdims=True))


def _coverage(segments: int, spans: AnySpans) -> Floats:
    """One where sensor j covers segment i, else zero; shape (m, n)."""
    cover: Floats = (reading_matrix(segments, spans).T > 0).astype(float)
    bare = (cover.sum(axis=1) == 0).nonzero()[0]
    if bare.size:
        raise InputError(f"segment {bare[0]} is covered by no sensor; extend a span over it")
    return cover
