"""Noise-aware weights: the linear estimator of least mean square error (LMMSE, Wiener).

With segment angles x of second moment C, readings y = H x + e and noise e of covariance R, the
weights are G = C H^T (H C H^T + R)^-1 and the error that remains has covariance C - G H C.

C is the second moment about zero, not the covariance about the mean: a joint bends to either
side alike, so its shapes are centred on the straight pose, and the small mean of a library (its
amplitudes leave out -ROM_max) is an accident of sampling. The intercept therefore is zero: the
straight joint estimates as straight.

Both formulas are evaluated in square-root form. With C = L L^T, where L holds the library's
shapes over sqrt(N), G solves the least-squares problem

    [(H L)^T  ]         [L^T]
    [R^(1/2)  ] G^T  ~  [ 0 ]

which never squares the readings' condition number. Without noise it becomes the plain
least-squares fit of smallest norm, where the formula would divide by zero.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ccgen.double_double import DoubleDouble, concatenate, least_squares
from ccgen.estimation.weights import Floats, Weights, without_intercept
from ccgen.joint.layouts import AnySpans
from ccgen.sensing.noise import checked_noise
from ccgen.sensing.readings import exact_readings

if TYPE_CHECKING:
    from ccgen.shapes import ShapeLibrary


def noise_aware(library: "ShapeLibrary", spans: AnySpans, noise_rad: ArrayLike) -> Weights:
    """LMMSE weights for readings with independent noise, the same bits on every machine.

    Args:
        library: shapes whose second moment stands for what the joint does.
        spans: the n sensors' spans.
        noise_rad: one standard deviation of each normalised reading, shape (n,), radians.

    Raises:
        InputError: noise that is not n finite numbers of at least zero.
    """
    noise = checked_noise(noise_rad, spans)
    return without_intercept("noise-aware", spans, gain(*_roots(library, spans), noise))


def posterior_covariance(library: "ShapeLibrary", spans: AnySpans, noise_rad: ArrayLike) -> Floats:
    """Error covariance of the noise-aware estimate, C - G H C, shape (m, m), radians squared.

    Evaluated as (I - G H) C (I - G H)^T + G R G^T, which stays positive semidefinite.

    Raises:
        InputError: noise that is not n finite numbers of at least zero.
    """
    noise = checked_noise(noise_rad, spans)
    shapes, sensed = _roots(library, spans)
    weights = gain(shapes, sensed, noise)
    missed = shapes.T - weights @ sensed.hi.T
    passed = weights * noise
    covariance: Floats = missed @ missed.T + passed @ passed.T
    return covariance


def _roots(library: "ShapeLibrary", spans: AnySpans) -> tuple[Floats, DoubleDouble]:
    """L^T, shape (N, m), with C = L L^T, and (H L)^T, shape (N, n)."""
    shapes = library.angles / np.sqrt(len(library.angles))
    return shapes, exact_readings(shapes, spans)


def gain(shapes: Floats, sensed: DoubleDouble, noise: Floats) -> Floats:
    """G in square-root form, the same bits on every machine.

    Args:
        shapes: L^T, shape (N, m).
        sensed: (H L)^T, shape (N, n).
        noise: one standard deviation of each reading, shape (n,).

    Returns:
        Shape (m, n).
    """
    system = concatenate([sensed, DoubleDouble.of(np.diag(noise))])
    wanted = np.vstack([shapes, np.zeros((noise.size, shapes.shape[1]))])
    return least_squares(system, wanted).T
