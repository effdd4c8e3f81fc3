"""What is known of a joint at one time, as it is looked at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.joint import Joint
from ccgen.kinematics.tip import tip_position
from ccgen.sensing.simulation import segment_lengths

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bends:
    """A state of a joint of m segments and S sections.

    Attributes:
        u: bends about x, shape (m,), radians.
        v: the same about y.
        h: elongation of each section, shape (S,), share of its length.
    """

    u: Floats
    v: Floats
    h: Floats

    @classmethod
    def straight(cls, joint: Joint) -> "Bends":
        """The joint unbent."""
        segments, sections = joint.geometry.segments, len(joint.geometry.sections)
        return cls(np.zeros(segments), np.zeros(segments), np.zeros(sections))

    def tip(self, joint: Joint) -> Floats:
        """Place of the tip in the base frame, shape (3,), metres."""
        return tip_position(self.u, self.v, segment_lengths(joint, self.h))


@dataclass(frozen=True, eq=False)
class Sight:
    """A joint as it is seen once.

    Attributes:
        t: seconds, from any beginning.
        estimate: by the sensors; what an axis that is lost had last stays.
        readings: mean bend over each sensor's span, as its length tells it; shape (n,), radians,
            NaN where it is not known.
        truth: what the estimate is held against; None where nobody knows it.
        lost: axes without an estimate.
        missing: sensors that give no reading.
        suspected: sensors that others contradict.
        faults: what was wrong, in words.
    """

    t: float
    estimate: Bends
    readings: Floats
    truth: Bends | None = None
    lost: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    suspected: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()


@dataclass(frozen=True)
class Errors:
    """How far an estimate lies from what it is held against.

    Attributes:
        bends: root mean square of a segment's error by bending axis that has an estimate, radians.
        tip: distance of the tips, metres; NaN while an axis is lost.
    """

    bends: dict[str, float]
    tip: float


def errors_of(joint: Joint, sight: Sight) -> Errors | None:
    """Errors of an estimate; None where nothing is known to hold it against."""
    estimate, truth = sight.estimate, sight.truth
    if truth is None:
        return None
    bends = {
        axis: float(np.sqrt(np.mean(np.square(getattr(estimate, axis) - getattr(truth, axis)))))
        for axis in joint.axes
        if axis != "h" and axis not in sight.lost
    }
    distance = float(np.linalg.norm(estimate.tip(joint) - truth.tip(joint)))
    return Errors(bends, float("nan") if sight.lost else distance)
