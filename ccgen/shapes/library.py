"""Rows of states: every shape that a joint takes, whatever it came from, and its source."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from ccgen.joint import Joint

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Shapes:
    """States of a joint of m segments and S sections, N rows; the arrays are read-only.

    Attributes:
        u: bending about x, shape (N, m), radians.
        v: bending about y, shape (N, m), radians.
        h: elongation of each section, shape (N, S), share of its length.
        source: where each row came from, N names such as "cases" or "loads".
    """

    u: Floats
    v: Floats
    h: Floats
    source: tuple[str, ...]

    def __post_init__(self) -> None:
        for name in ("u", "v", "h"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        shapes = (self.u.shape, self.v.shape, self.h.shape)
        fits = self.u.ndim == self.h.ndim == 2 and self.u.shape == self.v.shape
        if not fits or not len(self.u) == len(self.h) == len(self.source):
            raise ValueError(
                f"u, v and h of shapes {', '.join(map(str, shapes))} with {len(self.source)} "
                "sources are no rows of states; give (N, m), (N, m), (N, S) and N sources"
            )

    def __len__(self) -> int:
        return len(self.u)

    @property
    def segments(self) -> int:
        """Number m of segments."""
        return int(self.u.shape[1])

    @property
    def sections(self) -> int:
        """Number S of sections."""
        return int(self.h.shape[1])

    def of_source(self, source: str) -> "Shapes":
        """The rows that came from one source."""
        rows = [name == source for name in self.source]
        return Shapes(self.u[rows], self.v[rows], self.h[rows], (source,) * sum(rows))

    @property
    def state(self) -> Floats:
        """State of each row: u of all segments, v of all segments, h; shape (N, 2m + S)."""
        return np.concatenate([self.u, self.v, self.h], axis=1)


def unstretched(u: ArrayLike, v: ArrayLike, sections: int = 1, source: str = "angles") -> Shapes:
    """Shapes without elongation.

    Args:
        u, v: segment angles, shape (N, m), radians.
        sections: number of sections.
        source: of all rows.
    """
    bent = np.asarray(u, dtype=np.float64)
    return Shapes(
        bent,
        np.asarray(v, dtype=np.float64),
        np.zeros((len(bent), sections)),
        (source,) * len(bent),
    )


def bent_alike(angles: ArrayLike, sections: int = 1, source: str = "angles") -> Shapes:
    """Rows of planar shapes, each in both bending axes at once, for axes that do not meet.

    Args:
        angles: segment angles, shape (N, m), radians.
        sections: number of sections.
        source: of all rows.
    """
    return unstretched(angles, angles, sections, source)


def joined(parts: Sequence[Shapes]) -> Shapes:
    """All rows of several lists of shapes of one joint, in their order."""
    return Shapes(
        np.concatenate([part.u for part in parts]),
        np.concatenate([part.v for part in parts]),
        np.concatenate([part.h for part in parts]),
        tuple(name for part in parts for name in part.source),
    )


def within_axes(joint: "Joint", shapes: Shapes) -> Shapes:
    """The same shapes without bending about an axis that the joint leaves out."""
    out = {
        axis: np.zeros_like(getattr(shapes, axis)) for axis in ("u", "v") if axis not in joint.axes
    }
    return replace(shapes, **out) if out else shapes
