"""Poses in integers: the segment's turn and the tip's place as plans, and what is proven of them.

A frame's columns X, Y, Z are in Q30, or in fewer bits where segments bend far. One compiled
function turns it by a segment's angles and gives the segment's chord for a length of 1; chords are
added up by section. A second one takes the sums and the sections' elongations to the position:

    p = h0 sum_s (1 + e_s) (sum of the chords of section s)

with h0 the length of a segment. Angles beyond the format's limits count as them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ccgen.fixedpoint.model import FixedPointModel, Integers
from ccgen.polynomial import Compiled
from ccgen.polynomial.intervals import power_of_two


@dataclass(frozen=True)
class PoseTask:
    """What an integer pose is made for.

    Attributes:
        sections: segments of each section.
        segment_length: metres.
        precision: bits of angles and elongations, 16 or 32.
        fraction_bits: of the angles' formats, u and v.
        angle: largest angle that the shapes need, with a quarter more, radians.
        elongation_bits: fraction bits of the elongation's format; None where there is none.
        elongation: largest magnitude of it, a share of the length.
    """

    sections: tuple[int, ...]
    segment_length: float
    precision: int
    fraction_bits: tuple[int, int]
    angle: float
    elongation_bits: int | None = None
    elongation: float = 0.0

    @property
    def segments(self) -> int:
        """Of all sections."""
        return sum(self.sections)

    @property
    def length(self) -> float:
        """Of the neutral axis without elongation, metres."""
        return self.segments * self.segment_length

    @property
    def largest(self) -> int:
        """Largest integer of an angle; the most negative value means "no reading"."""
        return int(2 ** (self.precision - 1) - 1)

    @property
    def full_angle(self) -> Fraction:
        """Largest angle of the coarser format, radians."""
        return self.largest * power_of_two(-min(self.fraction_bits))

    @property
    def full_elongation(self) -> Fraction:
        """Largest elongation of the format."""
        if self.elongation_bits is None:
            return Fraction(0)
        return self.largest * power_of_two(-self.elongation_bits)


@dataclass(frozen=True)
class PoseBounds:
    """Proven errors of any segment's end, up to the tip.

    Attributes:
        position: Euclidean norm, metres.
        rotation: Frobenius norm.
    """

    position: float
    rotation: float


@dataclass(frozen=True, eq=False)
class PoseModel:
    """The integer reference model of poses.

    Attributes:
        task: what it is made for.
        turn: one segment, (frame, u, v) to (distal, chord).
        place: sums of chords and elongations to the position.
        bounds: over all angles and elongations that the shapes need, and a quarter more.
        wide_bounds: over all that the formats hold.
    """

    task: PoseTask
    turn: Compiled
    place: Compiled
    bounds: PoseBounds
    wide_bounds: PoseBounds

    @property
    def frame_bits(self) -> int:
        """Fraction bits of a frame's entries."""
        return self.turn.formats["distal"]

    @property
    def position_bits(self) -> int:
        """Fraction bits of a position in metres."""
        return self.place.formats["position"]

    def pose(
        self, u: ArrayLike, v: ArrayLike, h: ArrayLike | None = None, segment: int | None = None
    ) -> tuple[Integers, Integers]:
        """Pose of a segment's distal end, of the tip unless one is named.

        Args:
            u: integers of the angles, shape (N, m).
            v: likewise.
            h: integers of the elongations, shape (N, sections); where the joint has them.
            segment: its number, from 0.

        Returns:
            Rotation, shape (N, 3, 3), in `frame_bits`, and position, shape (N, 3), metres in
            `position_bits`.
        """
        entries = self.entries(u, v, h, segment)
        return entries[:, :9].reshape(-1, 3, 3).swapaxes(1, 2), entries[:, 9:]

    def entries(
        self, u: ArrayLike, v: ArrayLike, h: ArrayLike | None = None, segment: int | None = None
    ) -> Integers:
        """A pose as the C has it: the frame's columns X, Y, Z, then the position; shape (N, 12).

        Args:
            u, v, h, segment: as of `pose`.
        """
        last = self.task.segments - 1 if segment is None else segment
        *_, (frame, sums) = self.walk(u, v, last)
        return self._entries(frame, sums, h)

    def chain(self, u: ArrayLike, v: ArrayLike, h: ArrayLike | None = None) -> Integers:
        """`entries` of all segments; shape (N, m, 12)."""
        walk = self.walk(u, v, self.task.segments - 1)
        return np.stack([self._entries(frame, sums, h) for frame, sums in walk], axis=1)

    def walk(self, u: ArrayLike, v: ArrayLike, last: int) -> Iterator[tuple[Integers, Integers]]:
        """Frames, (N, 9), and sums of chords by section, (N, 3 sections), at segments' ends."""
        first, second = (np.asarray(x, dtype=np.int64) for x in (u, v))
        frame = self.straight(len(first))
        sums = np.zeros((len(first), 3 * len(self.task.sections)), dtype=np.int64)
        section = np.repeat(np.arange(len(self.task.sections)), self.task.sections)
        for i in range(last + 1):
            moved = self.turn.evaluate({"frame": frame, "u": first[:, i], "v": second[:, i]})
            frame, sums = moved["distal"], sums.copy()
            start = 3 * section[i]
            sums[:, start : start + 3] += moved["chord"]
            yield frame, sums

    def _entries(self, frame: Integers, sums: Integers, h: ArrayLike | None) -> Integers:
        return np.concatenate([frame, self.place_of(sums, h)], axis=1)

    def straight(self, count: int) -> Integers:
        """Frames at the base, shape (count, 9)."""
        return np.tile((np.eye(3, dtype=np.int64) << self.frame_bits).ravel(), (count, 1))

    def place_of(self, sums: Integers, h: ArrayLike | None) -> Integers:
        """Positions, shape (N, 3), of sums of chords by section, (N, 3 sections)."""
        values: dict[str, Any] = {"sums": sums}
        if self.task.elongation_bits is not None:
            elongations = np.asarray(h, dtype=np.int64)
            values["h"] = elongations[:, 0] if len(self.task.sections) == 1 else elongations
        return np.asarray(self.place.evaluate(values)["position"])


def pose_inputs(
    model: FixedPointModel, values: Integers
) -> tuple[Integers, Integers, Integers | None]:
    """Angles u and v and elongations h of poses, from values of all axes, shape (N, rows).

    A bending axis that the joint lacks is straight; without an axis h there are no elongations.
    """
    parts = model.split(values)
    straight = np.zeros((len(values), model.segments), dtype=np.int64)
    return parts.get("u", straight), parts.get("v", straight), parts.get("h")
