"""Tip Jacobians in integers: their reference model.

The chain is followed twice. First for the sums of all chords, by section; then again, with what
one segment's angles move: the frame turns by `turn`, the segment's own chord by `chord`, and the
tip lies at the lever of the chords that are ahead,

    linear = h0 (1 + e) chord + turn x lever        angular = turn

A column of an elongation is h0 times the sum of its section's chords.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ccgen.fixedpoint.model import Integers
from ccgen.fixedpoint.pose import PoseModel
from ccgen.polynomial import Compiled


@dataclass(frozen=True)
class JacobianBounds:
    """Proven errors of any column, Euclidean norms.

    Attributes:
        linear: metres for a rate of 1: a radian, or the length.
        angular: radians for a rate of 1.
    """

    linear: float
    angular: float


@dataclass(frozen=True, eq=False)
class JacobianModel:
    """The integer reference model of tip Jacobians.

    Attributes:
        poses: whose frames and chords it follows.
        columns: of one segment, (frame, u, v) to (turn_u, turn_v, chord_u, chord_v).
        column: (turn, chord, lever[, h]) to the linear part.
        stretch: a section's sum of chords to the linear part; None without elongation.
        bounds: over all angles and elongations that the shapes need, and a quarter more.
        wide_bounds: over all that the formats hold.
    """

    poses: PoseModel
    columns: Compiled
    column: Compiled
    stretch: Compiled | None
    bounds: JacobianBounds
    wide_bounds: JacobianBounds

    @property
    def angular_bits(self) -> int:
        """Fraction bits of an angular entry."""
        return self.columns.formats["turn_u"]

    @property
    def linear_bits(self) -> int:
        """Fraction bits of a linear entry, metres."""
        return self.column.formats["linear"]

    def jacobian(self, u: ArrayLike, v: ArrayLike, h: ArrayLike | None = None) -> Integers:
        """Tip Jacobians, shape (N, 6, columns): linear rows, then angular ones.

        Columns are those of u, of v, and of h where the joint elongates.

        Args:
            u: integers of the angles, shape (N, m).
            v: likewise.
            h: integers of the elongations, shape (N, sections); where the joint has them.
        """
        task = self.poses.task
        first, second = (np.asarray(x, dtype=np.int64) for x in (u, v))
        stretched = None if task.elongation_bits is None else np.asarray(h, dtype=np.int64)
        section = np.repeat(np.arange(len(task.sections)), task.sections)
        walk = list(self.poses.walk(first, second, task.segments - 1))
        total = walk[-1][1]
        frame = self.poses.straight(len(first))
        found: dict[str, list[Integers]] = {"u": [], "v": [], "h": []}
        for i, (distal, sums) in enumerate(walk):
            moved = self.columns.evaluate({"frame": frame, "u": first[:, i], "v": second[:, i]})
            values: dict[str, Any] = {"lever": self.poses.place_of(total - sums, stretched)}
            if stretched is not None:
                values["h"] = stretched[:, section[i]]
            for axis in ("u", "v"):
                turn = moved[f"turn_{axis}"]
                own = {"turn": turn, "chord": moved[f"chord_{axis}"]}
                linear = self.column.evaluate(values | own)["linear"]
                found[axis].append(np.concatenate([linear, turn], axis=1))
            frame = distal
        if self.stretch is not None:
            for s in range(len(task.sections)):
                linear = self.stretch.evaluate({"sum": total[:, 3 * s : 3 * s + 3]})["linear"]
                found["h"].append(np.concatenate([linear, np.zeros_like(linear)], axis=1))
        return np.stack([column for axis in found.values() for column in axis], axis=2)
