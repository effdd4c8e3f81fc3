"""How the shapes of a joint come about, before anything is known of it: moments, compliance, sizes.

Bends are compliance times bending moment. Moments along a joint are smooth: actuation makes them
constant, a force at the tip linear, weight quadratic, a contact bends them once. Compliance is not:
fittings make the ends of a joint several times stiffer than its middle. So the bends of an axis are

    x_i = d_i sum_k s_k M_ik w_k,    w ~ N(0, 1)

with the compliance d_i of each segment, smooth modes M and a size s_k of each mode, which a
recording tells (`ccgen.recordings.learning`). Elongation has one coordinate a section; the twist of
the joint, which tilts what lies beyond but no sensor reads, has one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ccgen.joint.loads import LoadRanges
    from ccgen.joint.specification import Geometry

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_MODES = 5
"""Of an axis; the sixth is a thousandth of the first."""
_END = 1 / 6
"""Share of the joint's length that a fitting may take at either end."""
_END_SPREAD = 0.8
"""Standard deviation of the logarithm of compliance that a fitting adds at the very end."""
_SMOOTH, _REACH = 0.3, 0.3
"""The same of compliance that changes along the whole joint, and over what share of its length."""
_SPREAD = 0.05
"""The same of one segment against its neighbours, which are made alike."""
_USUAL = 0.4
"""Root mean square of a segment's bend, share of the range of motion."""
_TWIST = 0.05
"""Standard deviation of the twist, share of the largest bend of the whole joint."""
_ROUGH = 0.4
"""Root mean square of what else a segment may bend, share of its usual bend."""
_STIFF = 0.1
"""Share of the usual twist where no sensors tell it from rough bends."""
_CLAMP = 5.0
"""Of a bend right at the base, where what holds a joint gives way, share of the usual bend."""
_CONTACTS = 64


@dataclass(frozen=True, eq=False)
class Model:
    """Shapes as a linear map of standard normal coordinates.

    Attributes:
        basis: states for unit coordinates at unit compliance and size, shape (p, k).
        compliance: number of the compliance that multiplies each state, -1 for none; shape (p,).
        compliance_root: R of the covariance R R' of their logarithms about 0, shape (c, c).
        expected: logarithm of the compliance that the basis holds, shape (c,).
        size: number of the size that multiplies each coordinate, -1 for none; shape (k,).
        sizes: number of sizes.
    """

    basis: Floats
    compliance: Indices
    compliance_root: Floats
    expected: Floats
    size: Indices
    sizes: int

    @property
    def compliances(self) -> int:
        """Their number."""
        return len(self.compliance_root)

    def transform(self, log_compliance: Floats, log_size: Floats) -> Floats:
        """The map T with x = T w, shape (p, k)."""
        soft = np.exp(np.append(log_compliance, 0.0))[self.compliance]
        large = np.exp(np.append(log_size, 0.0))[self.size]
        return np.asarray(soft[:, None] * self.basis * large)


def smooth_model(
    sections: Sequence[int],
    range_of_motion: float,
    elongation: float,
    profile: Floats | None = None,
    tolerance: float = 0.0,
    rough: bool = False,
) -> Model:
    """Shapes of a joint under moments that nobody has measured yet.

    Args:
        sections: segments of each section.
        range_of_motion: of a segment, radians.
        elongation: largest share of the length by which a section grows; 0 for none.
        profile: compliance of each segment where it is known, shape (m,).
        tolerance: standard deviation of the logarithm of compliance, at least.
        rough: whether segments may also bend in every other way, by so little at first that
            recordings have to ask for it.

    Returns:
        Of states u, v (m each), h (S) and the twist of the whole joint.
    """
    m, count = sum(sections), len(sections)
    modes = _modes(sections) * (_USUAL * range_of_motion)
    known = np.ones(m) if profile is None else profile / profile.mean()
    modes = known[:, None] * modes
    number = np.arange(modes.shape[1])
    if rough:
        usual = _USUAL * range_of_motion
        clamp = np.eye(m)[:, :1] * (_CLAMP * usual)
        others = _others(modes) * (_ROUGH * usual)
        # Smooth modes that moments hardly excite would else be the least of all.
        size = np.linalg.norm(modes, axis=0)
        modes = modes * np.maximum(1.0, _ROUGH * usual / size)
        number = np.append(number, [len(number), *np.full(others.shape[1], len(number) + 1)])
        modes = np.concatenate([modes, clamp, others], axis=1)
    k, sizes = modes.shape[1], int(number.max()) + 1
    stretch = count if elongation else 0
    basis = np.zeros((2 * m + count + 1, 2 * k + stretch + 1))
    basis[:m, :k] = modes
    basis[m : 2 * m, k : 2 * k] = modes
    basis[2 * m : -1, 2 * k : -1] = np.eye(count)[:, :stretch] * abs(elongation) / np.sqrt(3.0)
    basis[-1, -1] = (_STIFF if rough else 1.0) * _TWIST * m * range_of_motion
    segments = np.arange(m)
    return Model(
        basis,
        np.concatenate([segments, segments, np.full(count + 1, -1)]),
        np.asarray(np.linalg.cholesky(_compliance_covariance(m, tolerance)), dtype=np.float64),
        np.log(known),
        np.concatenate([number, number, np.full(stretch, sizes), [sizes + (stretch > 0)]]),
        sizes + (stretch > 0) + 1,
    )


def joint_models(
    geometry: "Geometry", loads: "LoadRanges | None", rough: bool
) -> tuple[Model, ...]:
    """How shapes of a joint may come about, before anything is recorded.

    A stiffness profile that the user states may be a guess, and its tolerance a wide one; what the
    recordings make of it is for them to tell (`ccgen.recordings.learning`).

    Args:
        geometry: of the joint.
        loads: of which the stiffness counts; None where they are not stated.
        rough: as of `smooth_model`.

    Returns:
        The joint alike all along but for its ends; where a profile is stated, that one with the
        usual spread, and last as it is stated.
    """
    reach = 0.0 if geometry.elongation is None else float(np.abs(geometry.elongation).max())
    stated: list[tuple[Floats | None, float]] = [(None, 0.0)]
    if loads is not None and len(loads.stiffness_profile) > 1:
        points = (np.arange(64 * geometry.segments) + 0.5) / (64 * geometry.segments)
        compliance = 1 / np.array(loads.stiffness_profile)
        at = (points * len(compliance)).astype(np.intp)
        profile = compliance[at].reshape(geometry.segments, 64).mean(axis=1)
        stated += [(profile, 0.0), (profile, loads.stiffness_tolerance)]
    sections, range_of_motion = geometry.sections, geometry.range_of_motion
    return tuple(smooth_model(sections, range_of_motion, reach, *one, rough) for one in stated)


def fixed_model(covariance: Floats) -> Model:
    """Shapes of a covariance of their states, shape (p, p), of which nothing is left to learn."""
    values, vectors = np.linalg.eigh(covariance)
    kept = values > values.max() * 1e-12
    basis = vectors[:, kept] * np.sqrt(values[kept])
    none = np.full(len(basis), -1)
    return Model(basis, none, np.zeros((0, 0)), np.zeros(0), np.full(basis.shape[1], -1), 0)


def free_model(states: Floats) -> Model:
    """Shapes of which references leave nothing open: every state for itself, as large as seen.

    Args:
        states: shape (N, p), without the twist, which then stays 0.
    """
    size = np.sqrt(np.mean(np.square(states), axis=0))
    seen = np.flatnonzero(size > 0)
    basis = np.zeros((states.shape[1] + 1, len(seen)))
    basis[seen, np.arange(len(seen))] = size[seen]
    none = np.full(len(basis), -1)
    return Model(basis, none, np.zeros((0, 0)), np.zeros(0), np.full(len(seen), -1), 0)


def _compliance_covariance(segments: int, tolerance: float) -> Floats:
    """Of the logarithms of segments' compliance, shape (m, m).

    Along the joint compliance changes smoothly; towards an end in steps that add up.
    """
    along = (np.arange(segments) + 0.5) / segments
    apart = (along[:, None] - along) / _REACH
    covariance = np.square(_SMOOTH) * np.exp(-np.square(apart) / 2)
    covariance += np.square(max(_SPREAD, tolerance)) * np.eye(segments)
    for distance in (along, 1.0 - along):
        inside = np.maximum(0.0, 1.0 - distance / _END)
        covariance += np.square(_END_SPREAD) * np.minimum(inside[:, None], inside)
    return np.asarray(covariance)


def _modes(sections: Sequence[int]) -> Floats:
    """Smooth modes of an axis, largest first, shape (m, k); their squares have a mean sum of 1."""
    m = sum(sections)
    moments = _moments(m)
    if len(sections) > 1:
        # Sections may be actuated each by itself.
        alone = np.zeros((m, m))
        first = 0
        for length in sections:
            part = slice(first, first + length)
            alone[part, part] = _moments(length)
            first += length
        moments = (moments + alone) / 2
    values, vectors = np.linalg.eigh(moments)
    count = min(m, _MODES + 2 * (len(sections) - 1))
    modes = (vectors * np.sqrt(np.maximum(values, 0.0)))[:, ::-1][:, :count]
    return np.asarray(modes / np.sqrt(np.square(modes).sum() / m))


def _others(modes: Floats) -> Floats:
    """What modes of shape (m, k) leave out, smooth first and larger, shape (m, m - k)."""
    m, k = modes.shape
    kept, _ = np.linalg.qr(modes)
    waves = np.cos(np.pi * np.outer(np.arange(m) + 0.5, np.arange(m)) / m)
    left, _ = np.linalg.qr(np.concatenate([kept, waves[:, k:]], axis=1))
    return np.asarray(left[:, k:m] * (k / np.arange(k, m)))


def _moments(segments: int) -> Floats:
    """Second moment of bending moments along a joint of unit length, shape (m, m)."""
    along = (np.arange(segments) + 0.5) / segments
    left = 1.0 - along
    contact = np.linspace(0.25, 1.0, _CONTACTS)[:, None] - along
    kinked = np.maximum(contact, 0.0)
    families = np.concatenate(
        [[np.ones(segments)], [left / 2], [np.square(left) / 2], kinked / np.sqrt(_CONTACTS)]
    )
    return np.asarray(families.T @ families)
