"""Sensors that are read together, and what they read of a joint's state.

The length of a sensor over its radius is a sum over the segments that it covers,

    y = sum_i t . x_i,    x_i = (u_i, v_i, e_i),    t = (sin(alpha), -cos(alpha), h0 / r),

with its angle alpha, its radius r, the length h0 of a segment and its elongation e_i
(`ccgen.sensing.readings`). t is the sensor's kind; where its span lies is what is asked.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ccgen.placement.objective import Floats, Indices


@dataclass(frozen=True, eq=False)
class Group:
    """n sensors that estimate some output axes together.

    Attributes:
        axes: their names, each with its part of the rows.
        slots: which sensors of a placement these are.
        rows: the R rows of the state that they read.
        estimated: whether a row is estimated, shape (R,).
        kinds: of each sensor, shape (n,), numbers below K.
        patterns: what each kind reads of each segment, shape (K, m, R).
        deviation: of the noise of each kind's lengths over the radius, shape (K,), radians.
        tolerance: of each kind's gain, share of it, shape (K,).
    """

    axes: Mapping[str, slice]
    slots: slice
    rows: slice
    estimated: NDArray[np.bool_]
    kinds: Indices
    patterns: Floats
    deviation: Floats
    tolerance: Floats

    def response(self, spans: Indices) -> Floats:
        """Matrix H, shape (n, R): lengths over the radius are H x, for spans of shape (n, 2)."""
        sums = self._sums
        return np.asarray(sums[self.kinds, spans[:, 1] + 1] - sums[self.kinds, spans[:, 0]])

    def judged(self, D: Floats) -> Floats:
        """What of a weight of errors, shape (R, R), an estimate can change: see `moments`."""
        fixed = ~self.estimated
        return np.where(np.outer(fixed, fixed), 0.0, D)

    @cached_property
    def _sums(self) -> Floats:
        kinds, segments, rows = self.patterns.shape
        sums = np.zeros((kinds, segments + 1, rows))
        np.cumsum(self.patterns, axis=1, out=sums[:, 1:])
        return sums


def of_one_kind(
    axis: str, rows: slice, sensors: int, deviation: float = 0.0, tolerance: float = 0.0
) -> Group:
    """Sensors of one kind that read one bending axis, and nothing else.

    Args:
        axis: its name.
        rows: of the state.
        sensors: number n of sensors.
        deviation: of the noise of a length over the radius, radians.
        tolerance: of a gain, share of it.
    """
    segments = rows.stop - rows.start
    return Group(
        axes={axis: slice(0, segments)},
        slots=slice(0, sensors),
        rows=rows,
        estimated=np.ones(segments, dtype=bool),
        kinds=np.zeros(sensors, dtype=np.intp),
        patterns=np.eye(segments)[None],
        deviation=np.array([deviation]),
        tolerance=np.array([tolerance]),
    )
