"""A joint of few segments cut finer, so that curvature may change within a segment.

Bodies on a joint of two segments lie off any two arcs of a circle by more than cameras miss them.
On a joint of twelve they lie off by little, but alike in every row: a fitting that ends within a
segment moves all that lies beyond, which few bodies would take for compliance elsewhere. A
segment's angles are the sums over its pieces, which is what sensors read.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.joint.specification import Geometry

Floats = NDArray[np.float64]

_ENOUGH, _ENOUGH_SEEN = 20, 10
"""Pieces of a joint that is cut finer: where few places are seen, and where directions are too, or
as many places as let segments bend as they like: then nothing is taken for something else."""


@dataclass(frozen=True, eq=False)
class Fine:
    """A joint of m segments and S sections with each segment in k pieces.

    Attributes:
        coarse: the joint as it is stated.
        geometry: with its pieces as segments.
        pieces: k.
    """

    coarse: Geometry
    geometry: Geometry
    pieces: int

    @property
    def gather(self) -> Floats:
        """What turns a state of the pieces into the joint's own, shape (2m + S, 2 k m + S)."""
        m, S = self.coarse.segments, len(self.coarse.sections)
        bends = np.repeat(np.eye(2 * m), self.pieces, axis=1)
        whole = np.zeros((2 * m + S, bends.shape[1] + S))
        whole[: 2 * m, : bends.shape[1]] = bends
        whole[2 * m :, bends.shape[1] :] = np.eye(S)
        return whole


def fine(geometry: Geometry, well_seen: bool) -> Fine:
    """Cut a joint's segments finer where there are few.

    Args:
        geometry: of the joint.
        well_seen: whether directions of the joint are seen, or many places.
    """
    m = geometry.segments
    pieces = max(1, -(-(_ENOUGH_SEEN if well_seen else _ENOUGH) // m))
    return Fine(
        geometry,
        replace(
            geometry,
            segments=pieces * m,
            range_of_motion=geometry.range_of_motion / pieces,
            sections=tuple(pieces * section for section in geometry.sections),
        ),
        pieces,
    )
