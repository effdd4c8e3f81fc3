"""From a method's name, or a whole joint, to weights."""

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ccgen.errors import InputError
from ccgen.estimation.coupled import fit_coupled
from ccgen.estimation.noise_aware import noise_aware
from ccgen.estimation.simple import direct, equal
from ccgen.estimation.wam import wam, wam_paper_call
from ccgen.estimation.weights import Weights
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.noise import reading_noise

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.shapes import ShapeLibrary, Shapes

FIT_METHODS = ("direct", "equal", "wam", "noise-aware", "wam-paper-call")


def fit_weights(
    method: str, library: "ShapeLibrary", spans: AnySpans, noise_rad: ArrayLike | None = None
) -> Weights:
    """Weights by the method of that name, one of `FIT_METHODS`.

    Args:
        method: its name.
        library: shapes to fit.
        spans: the n sensors' spans.
        noise_rad: noise of the normalised readings, shape (n,), radians; "noise-aware" needs it.

    Raises:
        InputError: unknown method, spans that the method cannot use, or noise not given.
    """
    segments = library.angles.shape[1]
    if method == "direct":
        return direct(segments, spans)
    if method == "equal":
        return equal(segments, spans)
    if method == "wam":
        return wam(library, spans)
    if method == "wam-paper-call":
        return wam_paper_call(library, spans)
    if method != "noise-aware":
        raise InputError(f"unknown method {method!r}; give one of {', '.join(FIT_METHODS)}")
    if noise_rad is None:
        raise InputError(
            '"noise-aware" needs the noise of the readings; state sensors.transducer.noise '
            '(metres, one standard deviation) or use "wam"'
        )
    return noise_aware(library, spans, noise_rad)


def fit_joint(
    joint: "Joint", method: str | None = None, shapes: "Shapes | None" = None
) -> dict[str, Weights]:
    """Weights of each output axis, under its name.

    Args:
        joint: the joint.
        method: instead of the joint's own.
        shapes: to fit instead of what the joint states.

    Raises:
        InputError: as `fit_weights`, naming the joint's file and the axis; ReachError: a shape
            that no load reaches.
    """
    from ccgen.shapes import fit_shapes

    rows = fit_shapes(joint) if shapes is None else shapes
    return {axis: fit_axis(joint, axis, method or joint.method, rows) for axis in joint.axes}


def in_the_papers_way(joint: "Joint") -> bool:
    """Whether each axis has a set of the paper's kind: whole segments, read by nothing else."""
    sets = [one for one in (joint.u, joint.v) if one is not None]
    whole = all(isinstance(end, int) for one in sets for span in one.spans for end in span)
    return bool(sets) and whole and not joint.couples


def fit_axis(joint: "Joint", axis: str, method: str, shapes: "Shapes") -> Weights:
    """Weights of one output axis.

    Raises:
        InputError: as `fit_joint`.
    """
    from ccgen.shapes import axis_library

    try:
        if not in_the_papers_way(joint):
            return fit_coupled(joint, axis, method, shapes)
        library = axis_library(shapes, axis, joint.geometry.range_of_motion)
        return fit_weights(method, library, joint.axis(axis).spans, reading_noise(joint, axis))
    except InputError as error:
        raise InputError(f"{joint.source}: estimator.method: axis {axis}: {error}") from error
