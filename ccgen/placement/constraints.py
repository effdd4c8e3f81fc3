"""What a builder allows: which spans a sensor may have, and how spans may lie together."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import ArgumentError
from ccgen.joint.layouts import Spans
from ccgen.placement.slots import Indices, Slots, coverage


@dataclass(frozen=True)
class Constraints:
    """Limits on a placement; every segment must be covered in any case.

    Attributes:
        shortest: fewest segments of a span.
        longest: most segments of a span; None for the whole joint.
        forbidden: segments at which no span may begin or end, because nothing can be attached.
        fixed: spans of sensors of a set that stay where they are; they count among the sensors, and
            the limits above do not concern them.
        stacked: most sensors over one segment, of those on one side; None for any number.
        staying: names of sensors of [[sensor]] that stay where they are.
    """

    shortest: int = 1
    longest: int | None = None
    forbidden: tuple[int, ...] = ()
    fixed: Spans = ()
    stacked: int | None = None
    staying: tuple[str, ...] = ()

    def check(self, segments: int, sensors: int) -> None:
        """Refuse limits that make no sense for a joint.

        Raises:
            ArgumentError: which limit, and what would be right.
        """
        if sensors < 1:
            raise ArgumentError(f"{sensors} sensors measure nothing; give at least 1", "sensors")
        longest = segments if self.longest is None else self.longest
        if not 1 <= self.shortest <= longest <= segments:
            raise ArgumentError(
                f"spans of {self.shortest} to {longest} segments do not fit a joint of {segments};"
                f" give 1 <= shortest <= longest <= {segments}",
                "shortest",
                "longest",
            )
        for segment in self.forbidden:
            if not 0 <= segment < segments:
                raise ArgumentError(
                    f"segment {segment} does not exist; give 0 to {segments - 1}", "forbidden"
                )
        for first, last in self.fixed:
            if not 0 <= first <= last < segments:
                raise ArgumentError(
                    f"span [{first}, {last}] does not fit;"
                    f" give 0 <= first <= last <= {segments - 1}",
                    "fixed",
                )
        if len(self.fixed) > sensors:
            raise ArgumentError(
                f"{len(self.fixed)} spans are more than {sensors} sensors; leave some out", "fixed"
            )
        if self.stacked is not None and self.stacked < 1:
            raise ArgumentError(
                f"at most {self.stacked} sensors over a segment leave it bare; give at least 1",
                "stacked",
            )

    def allowed(self, segments: int) -> NDArray[np.bool_]:
        """Whether a free sensor may span from first (row) to last (column) segment, (m, m)."""
        first, last = np.indices((segments, segments))
        lengths = last - first + 1
        fits = (lengths >= self.shortest) & (lengths <= (self.longest or segments))
        attachable = np.ones(segments, dtype=bool)
        attachable[list(self.forbidden)] = False
        return np.asarray(fits & attachable[:, None] & attachable[None, :])

    def catalogue(self, segments: int) -> Indices:
        """All spans that a free sensor may have, ordered by first and last, shape (S, 2)."""
        return np.argwhere(self.allowed(segments)).astype(np.intp)

    def violations(self, spans: Indices, segments: int, slots: Slots) -> Indices:
        """Number of bare and of overfull segments and of spans that are not allowed, shape (P,).

        A segment is bare as often as it lacks a direction.

        Args:
            spans: placements, shape (P, n, 2).
            segments: number m of segments.
            slots: whose spans they are.
        """
        broken = slots.lacking(spans, segments).sum(axis=-1)
        if self.stacked is not None:
            for side in slots.of_each_side(spans):
                broken += (coverage(side, segments) > self.stacked).sum(axis=-1)
        free = spans[:, slots.free]
        broken += (~self.allowed(segments)[free[..., 0], free[..., 1]]).sum(axis=-1)
        return np.asarray(broken, dtype=np.intp)
