"""What each sensor's span did in recordings, by shapes that do not rest on that sensor's readings.

Most probable shapes from bodies and readings rest on the sensor that is in question. Its reading
is taken out of them again: of a normal distribution of mean x and covariance P, a reading with the
response h, noise s and misfit e leaves x - P h e / (s^2 - h' P h) (leave one out; Rasmussen and
Williams, "Gaussian processes for machine learning", 2006, section 5.4.2).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ccgen.calibration.places import Bent, Place, places
from ccgen.calibration.sources import Followed
from ccgen.joint import Joint
from ccgen.recordings.lengths import expected_changes
from ccgen.sensing.readings import coverage, response

Floats = NDArray[np.float64]

_LARGEST_SHARE = 0.9
"""Of what is known of a reading, that is known by itself alone: beyond, nothing else tells it."""


def found_places(joint: Joint, followed: Sequence[Followed]) -> tuple[Place, ...]:
    """Find where the sensors of a joint run: by segment angles, or without them by bodies.

    Args:
        joint: its nominal gains near those that it has, in sign too.
        followed: its recordings.
    """
    none = np.zeros(len(joint.sensors))
    dense = [one for one in followed if one.reference.dense]
    if dense or not followed:
        return places([_bent(joint, one, [one.reference.state] * len(none)) for one in dense], none)
    vague = followed[0].gain_std / np.abs(followed[0].gain)
    return places([_bent(joint, one, left_out(joint, one)) for one in followed], vague)


def _bent(joint: Joint, one: Followed, states: Sequence[Floats]) -> Bent:
    """Bends and elongation of each sensor's span, by states (N, 2m + S) for each sensor."""
    m, covered, stretched = joint.geometry.segments, coverage(joint), response(joint)

    def each(part: slice, matrix: Floats) -> Floats:
        columns = [expected_changes(x[:, part], matrix[[j]]) for j, x in enumerate(states)]
        return np.concatenate(columns, axis=1)

    return Bent(
        u=each(slice(0, m), covered),
        v=each(slice(m, 2 * m), covered),
        stretch=each(slice(2 * m, None), stretched[:, 2 * m :]),
        lengths=one.lengths,
    )


def left_out(joint: Joint, one: Followed) -> list[Floats]:
    """States without each sensor's own readings; NaN where nothing else tells them."""
    covariance, found = one.reference.covariance, []
    assert covariance is not None  # of a reference that is not dense
    misfit = one.misfit(own=False)
    for j, h in enumerate(one.gain[:, None] * response(joint)):
        along = covariance @ h
        own, noise = along @ h, one.noise[j] ** 2
        rest = np.where(own < _LARGEST_SHARE * noise, noise - own, np.nan)
        found.append(one.reference.state - along * (misfit[:, j] / rest)[:, None])
    return found
