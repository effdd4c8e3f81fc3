"""States of the whole joint from the load cases of one axis.

Where axes do not meet, both bend alike. Where some sensor reads more than one of them, bending
about x and about y and the elongation of each section are independent of each other: each axis goes
through the load cases, elongations are uniform in their range.
"""

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Geometry, Joint
from ccgen.shapes.cases import ShapeLibrary, fit_library, score_library
from ccgen.shapes.library import Shapes, unstretched

Floats = NDArray[np.float64]

_SIGNS = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))
"""Mirror images in either axis: bends about x, about y and elongations are uncorrelated exactly."""

_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def fit_shapes(joint: Joint) -> Shapes:
    """Build the rows to which the joint's estimators are fitted.

    Raises:
        ReachError: names the joint file and its key.
    """
    return _case_shapes(joint, fit_library(joint))


def score_shapes(joint: Joint) -> Shapes:
    """Build the rows on which the joint's estimators are scored (eq. 12).

    Raises:
        ReachError: names the joint file and its key.
    """
    return _case_shapes(joint, score_library(joint))


def _case_shapes(joint: Joint, library: ShapeLibrary) -> Shapes:
    if joint.couples:
        return combined_shapes(library, joint.geometry, joint.axes)
    straight = np.zeros_like(library.angles)
    u, v = (library.angles if axis in joint.axes else straight for axis in ("u", "v"))
    return unstretched(u, v, len(joint.geometry.sections), "cases")


def combined_shapes(library: ShapeLibrary, geometry: Geometry, axes: tuple[str, ...]) -> Shapes:
    """Pair the shapes of the library with each other, with mirror images and with elongations.

    Args:
        library: shapes of one axis, shape (N, m).
        geometry: of the joint; its elongation is uniform in its range, 0 where it has none.
        axes: the output axes; a bending axis that is not among them stays straight.

    Returns:
        4 N rows, or 2 N where one axis bends; the source of each is "cases".
    """
    angles = library.angles
    about_y = angles[_spread_order(len(angles))]
    signs = _SIGNS if {"u", "v"} <= set(axes) else ((1.0, 1.0), (-1.0, -1.0))
    u = np.concatenate([sign * angles for sign, _ in signs])
    v = np.concatenate([sign * about_y for _, sign in signs])
    if "v" not in axes:
        v = np.zeros_like(u)
    if "u" not in axes:
        u = np.zeros_like(v)
    h = np.tile(_elongations(geometry, len(angles)), (len(signs), 1))
    return Shapes(u, v, h, ("cases",) * len(u))


def _spread_order(count: int) -> NDArray[np.intp]:
    """An order in which neighbours stand far from each other: steps of a golden section."""
    step = max(1, round(count * _GOLDEN))
    while np.gcd(step, count) != 1:
        step += 1
    return np.asarray((np.arange(count) * step) % count, dtype=np.intp)


def _elongations(geometry: Geometry, count: int) -> Floats:
    """Elongations of each section, spread evenly over their range; shape (count, S)."""
    sections = len(geometry.sections)
    if geometry.elongation is None:
        return np.zeros((count, sections))
    low, high = geometry.elongation
    # Multiples of roots of primes, which IEEE 754 rounds alike everywhere (Kronecker's sequence).
    share = np.mod(np.outer(np.arange(1, count + 1), np.sqrt(_primes(sections))), 1.0)
    return np.asarray(low + (high - low) * share)


def _primes(count: int) -> list[float]:
    """The first primes."""
    found: list[int] = []
    number = 2
    while len(found) < count:
        if all(number % prime for prime in found):
            found.append(number)
        number += 1
    return [float(prime) for prime in found]
